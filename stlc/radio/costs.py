"""Link costs: what one step of one link costs, from its mean and spread.

mu [dBm] and sigma [dB] are those of one packet (fading included) unless said otherwise; the
SNR cost uses mu minus the noise floor. Infinite values are clamped and the clamping reported.
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum
from math import log
from typing import assert_never

import numpy as np
from numpy.typing import NDArray

from stlc.radio.averages import average, average_bounds
from stlc.radio.errors import RadioError
from stlc.radio.link_budget import LinkBudget, q_function

Array = NDArray[np.float64]

CLAMP = 1e6
"""Largest cost a table may hold."""


class CostName(StrEnum):
    """Link costs a mission may name."""

    INV_SNR = "inv_snr"
    ETX = "etx"
    NEG_LOG_PRR = "neg_log_prr"
    OUTAGE = "outage"
    NEG_RSSI = "neg_rssi"
    PAPER_INV_RSSI = "paper_inv_rssi"
    ENERGY = "energy"


MOST_TRIES = 1e3
"""Transmissions that the energy of a packet counts at most, so that its table spans no more than
three powers of ten."""


@dataclass(frozen=True, slots=True, eq=False)
class CostValues:
    """Costs of any shape; `clamped` of them were infinite or above CLAMP; notes to show."""

    values: Array
    clamped: int
    notes: tuple[str, ...] = ()


def link_cost(cost: CostName, mean: Array, sigma: Array, budget: LinkBudget) -> CostValues:
    """The cost of links of mean strength `mean` [dBm] and spread `sigma` [dB], same shapes.

    inv_snr         E[1/SNR] = 10^(-snr/10) exp((ln10/10)^2 sigma^2 / 2), energy for each bit
    etx             1 / (PRR_f PRR_r), both directions alike; PRR averaged over sigma
    neg_log_prr     -ln PRR
    outage          P(rssi < sensitivity)
    neg_rssi        -mu
    paper_inv_rssi  the paper's 1/RSSI with RSSI in dB: wrong in scale, singular at 0
    energy          what sending a packet until it arrives takes [mJ]: power x time on the air / PRR
    Raises RadioError when the receiver lacks what the cost needs.
    """
    with np.errstate(divide="ignore", over="ignore"):
        raw = np.asarray(_raw_cost(cost, mean, sigma, budget), dtype=np.float64)
    bad = ~np.isfinite(raw) | (np.abs(raw) > CLAMP)
    clean = np.clip(np.nan_to_num(raw, nan=CLAMP, posinf=CLAMP, neginf=-CLAMP), -CLAMP, CLAMP)
    return CostValues(clean, int(bad.sum()), _notes(cost, int(bad.sum())))


def _raw_cost(cost: CostName, mean: Array, sigma: Array, budget: LinkBudget) -> Array:
    """Expected cost of a link at mean and sigma [dB], before it is cut at the ceiling."""
    match cost:
        case CostName.INV_SNR:
            scale = log(10.0) / 10.0
            return np.exp(-scale * budget.snr(mean) + 0.5 * (scale * sigma) ** 2)
        case CostName.ETX:
            return np.asarray(1.0 / average(budget.prr, mean, sigma) ** 2)
        case CostName.NEG_LOG_PRR:
            return np.asarray(-np.log(np.maximum(average(budget.prr, mean, sigma), 0.0)))
        case CostName.OUTAGE:
            return _outage(mean, sigma, budget)
        case CostName.NEG_RSSI:
            return -mean
        case CostName.PAPER_INV_RSSI:
            return np.asarray(1.0 / mean)
        case CostName.ENERGY:
            return _energy(average(budget.prr, mean, sigma), budget)
        case _:
            assert_never(cost)


def _energy(prr: Array, budget: LinkBudget) -> Array:
    return np.asarray(budget.packet_energy / np.maximum(prr, 1.0 / MOST_TRIES))


def least_energy(
    mean: tuple[Array, Array], sigma: tuple[Array, Array], budget: LinkBudget
) -> Array:
    """Lower bound [mJ] of the energy over intervals of mean [dBm] and sigma [dB]."""
    return _energy(average_bounds(budget.prr, mean, sigma, decreasing=False)[1], budget)


def _outage(mean: Array, sigma: Array, budget: LinkBudget) -> Array:
    if budget.sensitivity is None:
        raise RadioError("outage needs the receiver's sensitivity: add `sensitivity -90 dBm`")
    gap = mean - budget.sensitivity
    spread = np.maximum(sigma, 1e-12)
    return q_function(gap / spread)


def _notes(cost: CostName, clamped: int) -> tuple[str, ...]:
    notes: list[str] = []
    if clamped:
        notes.append(f"{clamped} values of {cost.value} were clamped to {CLAMP:g}")
    if cost is CostName.PAPER_INV_RSSI:
        notes.append(
            "paper_inv_rssi divides by a level in dB: it changes sign at 0 dBm, is singular "
            "there and has no physical scale; inv_snr is the expected energy for each bit"
        )
    return tuple(notes)


def normalised(values: Array) -> tuple[Array, float]:
    """`values` divided by their static range max - min, and that range (1 when constant)."""
    spread = float(values.max() - values.min()) if values.size else 0.0
    scale = spread if spread > 0 else 1.0
    return values / scale, scale


def cost_interval(
    cost: CostName,
    mean: tuple[Array, Array],
    sigma: tuple[Array, Array],
    budget: LinkBudget,
) -> CostValues:
    """Highest cost for mean [dBm] and sigma [dB] anywhere in intervals (lower, upper)."""
    with np.errstate(divide="ignore", over="ignore"):
        raw = np.asarray(_highest(cost, mean, sigma, budget), dtype=np.float64)
    bad = ~np.isfinite(raw) | (np.abs(raw) > CLAMP)
    clean = np.clip(np.nan_to_num(raw, nan=CLAMP, posinf=CLAMP, neginf=-CLAMP), -CLAMP, CLAMP)
    return CostValues(clean, int(bad.sum()), _notes(cost, int(bad.sum())))


def _highest(
    cost: CostName,
    mean: tuple[Array, Array],
    sigma: tuple[Array, Array],
    budget: LinkBudget,
) -> Array:
    """Upper bound of a cost over intervals of mean and sigma [dB], by what it grows with."""
    match cost:
        case CostName.INV_SNR | CostName.NEG_RSSI:
            return _raw_cost(cost, mean[0], sigma[1], budget)
        case CostName.ETX:
            least, _ = average_bounds(budget.prr, mean, sigma, decreasing=False)
            return np.asarray(1.0 / least**2)
        case CostName.NEG_LOG_PRR:
            least, _ = average_bounds(budget.prr, mean, sigma, decreasing=False)
            return np.asarray(-np.log(least))
        case CostName.ENERGY:
            least, _ = average_bounds(budget.prr, mean, sigma, decreasing=False)
            return _energy(least, budget)
        case CostName.OUTAGE:
            ends = (_outage(mean[0], s, budget) for s in sigma)
            return np.maximum(*ends)
        case CostName.PAPER_INV_RSSI:
            crosses = (mean[0] <= 0.0) & (mean[1] >= 0.0)
            return np.where(crosses, np.inf, 1.0 / mean[0])
        case _:
            assert_never(cost)
