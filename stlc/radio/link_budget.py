"""From received strength to SNR, bit error rate and packet reception.

gamma is the linear Eb/N0 (802.15.4: the SINR of the standard's annex E). Formulas: Proakis,
Digital Communications; IEEE Std 802.15.4-2006, annex E.4.1.8.
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum
from functools import lru_cache
from math import comb, log, log10, pi
from typing import assert_never

import numpy as np
from numpy.typing import NDArray

from stlc.radio.errors import RadioError

Array = NDArray[np.float64]

THERMAL_NOISE_DBM_HZ = -174.0

LIGHT = 299_792_458.0
"""Its speed [m/s]."""


class Modulation(StrEnum):
    """Bit-error models a channel may name."""

    BPSK = "bpsk"
    QPSK = "qpsk"
    DBPSK = "dbpsk"
    COHERENT_FSK = "coherent_fsk"
    NONCOHERENT_FSK = "noncoherent_fsk"
    OQPSK_802_15_4 = "oqpsk_802_15_4"
    RAYLEIGH_BPSK = "rayleigh_bpsk"
    RAYLEIGH_DBPSK = "rayleigh_dbpsk"
    RAYLEIGH_NONCOHERENT_FSK = "rayleigh_noncoherent_fsk"

    @property
    def rayleigh(self) -> bool:
        """True when the formula is already averaged over Rayleigh fading."""
        return self.value.startswith("rayleigh")


def q_function(x: Array) -> Array:
    """Tail probability of the standard normal distribution."""
    from scipy.special import ndtr

    return np.asarray(ndtr(-x), dtype=np.float64)


def z_quantile(p: float) -> float:
    """z_p with Phi(z_p) = p; P(rssi >= g) >= p holds exactly when mu - z_p sigma >= g.

    Raises RadioError unless 0 < p < 1.
    """
    from scipy.special import ndtri

    if not 0.0 < p < 1.0:
        raise RadioError(f"a probability threshold lies strictly between 0 and 1, not {p}")
    return float(ndtri(p))


def _oqpsk(gamma: Array) -> Array:
    total = np.zeros_like(gamma)
    for k in range(2, 17):
        total += (-1.0) ** k * comb(16, k) * np.exp(20.0 * gamma * (1.0 / k - 1.0))
    return np.clip(total * (8.0 / 15.0) / 16.0, 0.0, 0.5)


def bit_error_rate(modulation: Modulation, gamma: Array) -> Array:
    """BER [-] at linear Eb/N0 `gamma` (any shape, >= 0); falls as gamma grows."""
    gamma = np.asarray(gamma, dtype=np.float64)
    match modulation:
        case Modulation.BPSK | Modulation.QPSK:
            return q_function(np.sqrt(2.0 * gamma))
        case Modulation.DBPSK:
            return np.asarray(np.exp(-gamma) / 2.0)
        case Modulation.COHERENT_FSK:
            return q_function(np.sqrt(gamma))
        case Modulation.NONCOHERENT_FSK:
            return np.asarray(np.exp(-gamma / 2.0) / 2.0)
        case Modulation.OQPSK_802_15_4:
            return _oqpsk(gamma)
        case Modulation.RAYLEIGH_BPSK:
            # (1 - sqrt(g/(1+g)))/2 without the cancellation at large gamma
            root = np.sqrt(gamma / (1.0 + gamma))
            return np.asarray(0.5 / ((1.0 + gamma) * (1.0 + root)))
        case Modulation.RAYLEIGH_DBPSK:
            return np.asarray(0.5 / (1.0 + gamma))
        case Modulation.RAYLEIGH_NONCOHERENT_FSK:
            return np.asarray(1.0 / (2.0 + gamma))
        case _:
            assert_never(modulation)


@lru_cache(maxsize=256)
def required_ebn0_db(modulation: Modulation, ber: float) -> float:
    """Eb/N0 [dB] at which the BER equals `ber` (the BER is monotone, so it is unique).

    Raises RadioError unless 0 < ber < 1/2, or when no Eb/N0 below 150 dB reaches it.
    """
    from scipy.optimize import brentq

    if not 0.0 < ber < 0.5:
        raise RadioError(f"a bit error rate threshold lies strictly between 0 and 0.5, not {ber}")

    def excess(level: float) -> float:
        """log BER at a level [dB] less the one wanted; falls with the level."""
        value = float(bit_error_rate(modulation, np.array([10.0 ** (level / 10.0)]))[0])
        return log(max(value, 1e-300)) - log(ber)

    if excess(150.0) > 0.0 or excess(-100.0) < 0.0:
        raise RadioError(f"{modulation.value} reaches no bit error rate of {ber} within 150 dB")
    return float(brentq(excess, -100.0, 150.0, xtol=1e-10))


def noise_floor_dbm(bandwidth_hz: float, noise_figure_db: float) -> float:
    """Thermal noise -174 + 10 log10(bandwidth) + noise figure [dBm]."""
    if bandwidth_hz <= 0:
        raise RadioError(f"bandwidth must be above 0 Hz, not {bandwidth_hz}")
    return THERMAL_NOISE_DBM_HZ + 10.0 * log10(bandwidth_hz) + noise_figure_db


def free_space_loss(distance: float, frequency: float) -> float:
    """20 log10(4 pi d f / c) [dB] of a distance [m] at a frequency [Hz] (Friis, 1946)."""
    return 20.0 * log10(4.0 * pi * distance * frequency / LIGHT)


@dataclass(frozen=True, slots=True)
class LinkBudget:
    """What turns a received strength into link quality.

    noise_floor      [dBm]
    modulation       bit-error model
    bandwidth, rate  [Hz], [bit/s]: Eb/N0 = SNR + 10 log10(bandwidth / rate); both or neither
    packet           [bytes], for PRR
    sensitivity      [dBm], for `outage`
    power            of the transmitter [dBm], for `energy`
    rates            (SNR [dB], bit rate [bit/s]) from which each rate can be sent, both rising
    """

    noise_floor: float
    modulation: Modulation | None = None
    bandwidth: float | None = None
    rate: float | None = None
    packet: float | None = None
    sensitivity: float | None = None
    rates: tuple[tuple[float, float], ...] = ()
    power: float | None = None

    def __post_init__(self) -> None:
        if (self.bandwidth is None) != (self.rate is None):
            raise RadioError("Eb/N0 needs both bandwidth and bit rate, or neither")
        for name in ("bandwidth", "rate", "packet"):
            value = getattr(self, name)
            if value is not None and value <= 0:
                raise RadioError(f"{name} must be above 0, not {value}")

    @property
    def processing_gain_db(self) -> float:
        """Eb/N0 minus SNR [dB]; 0 when bandwidth and rate are not given."""
        if self.bandwidth is None or self.rate is None:
            return 0.0
        return 10.0 * log10(self.bandwidth / self.rate)

    @property
    def packet_energy(self) -> float:
        """What one packet takes on the air [mJ]: power [mW] x bits / rate. Raises RadioError where
        the channel doesn't say one of them."""
        if self.power is None or self.packet is None or self.rate is None:
            raise RadioError("energy needs `power 20 dBm`, `packet 32 bytes` and `rate 250 kbit/s`")
        return float(10.0 ** (self.power / 10.0) * 8.0 * self.packet / self.rate)

    def snr(self, rssi: Array) -> Array:
        """SNR [dB] at received strength [dBm]."""
        return np.asarray(rssi - self.noise_floor, dtype=np.float64)

    def throughput(self, rssi: Array) -> Array:
        """Bit rate [bit/s] at received strength [dBm]: the best that the SNR allows, or 0."""
        levels = np.array([level for level, _ in self.rates])
        speeds = np.array([0.0, *(speed for _, speed in self.rates)])
        return np.asarray(speeds[np.searchsorted(levels, self.snr(rssi), side="right")])

    def ber(self, rssi: Array) -> Array:
        """BER at received strength [dBm]. Raises RadioError without a modulation."""
        level = self.snr(rssi) + self.processing_gain_db
        gamma = 10.0 ** (np.minimum(level, 300.0) / 10.0)
        return bit_error_rate(self._modulation(), gamma)

    def prr(self, rssi: Array) -> Array:
        """Packet reception ratio (1 - BER)^(8 packet). Raises RadioError without a packet size."""
        if self.packet is None:
            raise RadioError("packet reception needs a packet size: add `packet 32 bytes`")
        return np.asarray(np.exp(8.0 * self.packet * np.log1p(-self.ber(rssi))))

    def rssi_for_ber(self, ber: float) -> float:
        """Strength [dBm] from which `ber_at_mean` is at most `ber`."""
        level = required_ebn0_db(self._modulation(), ber)
        return level - self.processing_gain_db + self.noise_floor

    def rssi_for_prr(self, prr: float) -> float:
        """Strength [dBm] from which the PRR at the mean is at least `prr`."""
        if self.packet is None:
            raise RadioError("packet reception needs a packet size: add `packet 32 bytes`")
        if not 0.0 < prr < 1.0:
            raise RadioError(f"a packet reception threshold lies between 0 and 1, not {prr}")
        ber = -np.expm1(np.log(prr) / (8.0 * self.packet))
        return self.rssi_for_ber(min(float(ber), 0.4999999))

    def _modulation(self) -> Modulation:
        if self.modulation is None:
            known = ", ".join(m.value for m in Modulation)
            raise RadioError(f"bit error rates need a modulation: one of {known}")
        return self.modulation


def check_fading(modulation: Modulation | None, fading: float) -> None:
    """Raise RadioError when fading would count twice: Rayleigh-averaged BER and sigma_F^2."""
    if modulation is not None and modulation.rayleigh and fading > 0:
        raise RadioError(
            f"{modulation.value} already averages over fading, and the channel has a fading "
            f"variance of {fading:g} dB^2: use one of them (fading 0 dB^2, or "
            f"{modulation.value.removeprefix('rayleigh_')})"
        )
