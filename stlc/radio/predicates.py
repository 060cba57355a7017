"""Communication predicates on cells: where they surely hold, where they surely fail.

| quantity   | value                                             | sigma |
|------------|---------------------------------------------------|-------|
| rssi       | posterior mean [dBm]                              | -     |
| snr        | posterior mean - noise floor [dB]                 | -     |
| ber        | BER averaged over the posterior   | one packet's |
| ber_at_mean| BER at the posterior mean                         | -     |
| prr        | packet reception averaged over the posterior      | one packet's |
| chance     | mean - z_p sigma [dBm]: P(rssi >= g) >= p <=> value >= g | one packet's |
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum
from typing import assert_never

import numpy as np
from numpy.typing import NDArray

from stlc.radio.averages import average, average_bounds
from stlc.radio.bounds import EVERYWHERE
from stlc.radio.errors import RadioError
from stlc.radio.gp import ChannelModel
from stlc.radio.link_budget import LinkBudget, check_fading, z_quantile
from stlc.radio.link_ends import LinkEnds
from stlc.radio.table import BoundName, LinkTable, bound_ends, make_table, tabulate

Array = NDArray[np.float64]
Interval = tuple[Array, Array]


class Quantity(StrEnum):
    """What a communication predicate measures."""

    RSSI = "rssi"
    SNR = "snr"
    BER = "ber"
    BER_AT_MEAN = "ber_at_mean"
    PRR = "prr"
    CHANCE = "chance"


SPREAD_QUANTITIES = (Quantity.BER, Quantity.PRR, Quantity.CHANCE)


@dataclass(frozen=True, slots=True)
class LinkPredicate:
    """`quantity >= threshold` (at_least) or `quantity <= threshold`.

    threshold in dBm (rssi, chance), dB (snr) or none (ber, prr); probability p of `chance`,
    which reads P(rssi >= threshold) >= p for at_least and P(rssi <= threshold) >= p else.
    """

    quantity: Quantity
    threshold: float
    at_least: bool
    probability: float | None = None

    def __post_init__(self) -> None:
        if (self.quantity is Quantity.CHANCE) != (self.probability is not None):
            raise RadioError(
                "a probability belongs to the chance form P(rssi >= g) >= p, and to it"
            )

    @property
    def z(self) -> float:
        """The quantile that turns `chance` into mean - z sigma, 0 for the others."""
        if self.probability is None:
            return 0.0
        return z_quantile(self.probability) * (1.0 if self.at_least else -1.0)

    def robustness(self, value: Array) -> Array:
        """Signed distance to the threshold in the quantity's unit, >= 0 where it holds."""
        return value - self.threshold if self.at_least else self.threshold - value


@dataclass(frozen=True, slots=True, eq=False)
class ThresholdTable:
    """Robustness of a predicate on cell pairs.

    low, high  bounds of the robustness in each closed cell pair; equal for centre and mean
    """

    predicate: LinkPredicate
    low: LinkTable
    high: LinkTable

    def allowed(self, positive: bool = True) -> NDArray[np.bool_]:
        """Cell pairs (na, nb) where the predicate (or, not positive, its negation) surely holds."""
        return self.low.matrix() >= 0.0 if positive else self.high.matrix() <= 0.0


def quantity_value(
    predicate: LinkPredicate, mean: Array, sigma: Array, budget: LinkBudget
) -> Array:
    """The predicate's quantity at mean [dBm] and one packet's sigma [dB] (same shapes)."""
    match predicate.quantity:
        case Quantity.RSSI:
            return np.asarray(mean, dtype=np.float64)
        case Quantity.SNR:
            return budget.snr(mean)
        case Quantity.BER:
            return average(budget.ber, mean, sigma)
        case Quantity.BER_AT_MEAN:
            return budget.ber(mean)
        case Quantity.PRR:
            return average(budget.prr, mean, sigma)
        case Quantity.CHANCE:
            return mean - predicate.z * sigma
        case _:
            assert_never(predicate.quantity)


def quantity_interval(
    predicate: LinkPredicate, mean: Interval, sigma: Interval, level: Interval, budget: LinkBudget
) -> Interval:
    """Bounds of the quantity when mean, sigma and mean - z sigma lie in intervals."""
    match predicate.quantity:
        case Quantity.RSSI:
            return mean
        case Quantity.SNR:
            return budget.snr(mean[0]), budget.snr(mean[1])
        case Quantity.BER:
            return average_bounds(budget.ber, mean, sigma, decreasing=True)
        case Quantity.BER_AT_MEAN:
            return budget.ber(mean[1]), budget.ber(mean[0])
        case Quantity.PRR:
            return average_bounds(budget.prr, mean, sigma, decreasing=False)
        case Quantity.CHANCE:
            return level
        case _:
            assert_never(predicate.quantity)


def check_predicate(model: ChannelModel, predicate: LinkPredicate, budget: LinkBudget) -> None:
    """Raise RadioError when the budget lacks something or fading would count twice."""
    check_fading(budget.modulation, model.fading)
    quantity_value(predicate, np.zeros(1), np.zeros(1), budget)


def _deciding(
    model: ChannelModel, ends: LinkEnds, predicate: LinkPredicate, budget: LinkBudget
) -> tuple[float, float]:
    """Levels mean - z sigma [dBm], before calibration, among which the predicate turns true.

    For averages over sigma a decibel more on both sides: its bounds are loose as well.
    """
    offset, floor = model.offset(ends.receiver), budget.noise_floor
    if predicate.quantity in (Quantity.RSSI, Quantity.CHANCE):
        return predicate.threshold - offset, predicate.threshold - offset
    if predicate.quantity is Quantity.SNR:
        return predicate.threshold + floor - offset, predicate.threshold + floor - offset
    level = np.arange(floor - 100.0, floor + 200.0, 0.1)
    ends_at = []
    own = model.own_variance(True)
    for spread in (own, own + model.shadowing):
        sigma = np.full_like(level, np.sqrt(spread))
        value = predicate.robustness(quantity_value(predicate, level, sigma, budget))
        ends_at.append(int(np.argmax((value >= 0) != (value[0] >= 0))))
    if min(ends_at) == 0:  # never turns within 300 dB
        return EVERYWHERE
    return float(level[min(ends_at)] - 1.0 - offset), float(level[max(ends_at)] + 1.0 - offset)


def threshold_table(
    model: ChannelModel,
    ends: LinkEnds,
    predicate: LinkPredicate,
    budget: LinkBudget,
    bound: BoundName = "worst",
    everywhere: bool = False,
) -> ThresholdTable:
    """The robustness of a predicate on cells; `worst` is rigorous for both polarities.

    `worst` is tight where it decides; beyond the threshold it may be looser, unless it is wanted
    tight `everywhere`.
    Raises RadioError (see `check_predicate`), and for `worst` with the kernel paper_min.
    """
    check_predicate(model, predicate, budget)
    cells = (ends.first, ends.second_cells)
    unit = {"rssi": "dB", "snr": "dB", "chance": "dB"}.get(predicate.quantity.value, "1")
    if bound != "worst":
        value = tabulate(model, ends, lambda m, s: quantity_value(predicate, m, s, budget), bound)
        table = make_table(predicate.robustness(value), *cells, unit)
        return ThresholdTable(predicate, table, table)
    focus = EVERYWHERE if everywhere else _deciding(model, ends, predicate, budget)
    found = bound_ends(model, ends, predicate.z, predicate.quantity in SPREAD_QUANTITIES, focus)
    value_low, value_high = quantity_interval(
        predicate, found.mean, found.sigma, found.level, budget
    )
    ends_of = predicate.robustness(value_low), predicate.robustness(value_high)
    low, high = ends_of if predicate.at_least else (ends_of[1], ends_of[0])
    return ThresholdTable(predicate, make_table(low, *cells, unit), make_table(high, *cells, unit))
