"""The link budget of a channel: noise, modulation, packets, rates."""

from __future__ import annotations

from math import inf, log10, nan
from typing import TYPE_CHECKING

from stlc.sema import props, units
from stlc.sema.channel_reader import Reader
from stlc.syntax import ast

if TYPE_CHECKING:
    from stlc.radio.link_budget import LinkBudget

MODULATIONS = (
    "bpsk", "qpsk", "dbpsk", "coherent_fsk", "noncoherent_fsk", "oqpsk_802_15_4",
    "rayleigh_bpsk", "rayleigh_dbpsk", "rayleigh_noncoherent_fsk",
)  # fmt: skip
_FASTEST = 1e15  # bit/s


def link_budget(reader: Reader) -> LinkBudget:
    """The link budget; a noise floor of NaN is one that nobody gave."""
    from stlc.radio.link_budget import LinkBudget, Modulation, noise_floor_dbm

    floor = reader.number("noise_floor", units.DBM)
    bandwidth = reader.positive("bandwidth", units.HERTZ)
    figure = reader.number("noise_figure", units.DB)
    rate = reader.positive("rate", units.BIT_RATE)
    if floor is None and bandwidth is not None and figure is not None:
        floor = noise_floor_dbm(bandwidth, figure)
    if rate is not None and bandwidth is None:
        raise props.bad(reader.block.by_key["rate"], "needs a bandwidth too", "bandwidth 2 MHz")
    word = reader.word("modulation", MODULATIONS, "")
    return LinkBudget(
        noise_floor=nan if floor is None else floor,
        modulation=Modulation(word) if word else None,
        bandwidth=bandwidth if rate is not None else None,
        rate=rate,
        packet=_packet(reader),
        sensitivity=reader.number("sensitivity", units.DBM),
        rates=_rates(reader),
        power=transmit_power(reader),
    )


def transmit_power(reader: Reader) -> float | None:
    """What the transmitter sends [dBm]; watts will do."""
    item = reader.block.get("power")
    if item is None:
        return None
    expr = props.only(item, "power 20 dBm")
    if reader.scope.constant(expr).unit != units.WATT:
        return reader.number("power", units.DBM)
    watts = reader.scope.number(expr, units.WATT)
    if watts <= 0:
        raise props.bad(item, "must be above 0 W", "power 100 mW")
    return reader.in_scale(item, 10.0 * log10(watts) + 30.0)


def _rates(reader: Reader) -> tuple[tuple[float, float], ...]:
    """`rates (5 dB, 1 Mbit/s) (15 dB, 6 Mbit/s)`: from which SNR on each rate can be sent."""
    item, usage = reader.block.get("rates"), "rates (5 dB, 1 Mbit/s) (15 dB, 6 Mbit/s)"
    if item is None:
        return ()
    found: list[tuple[float, float]] = []
    for expr in item.args:
        if not (isinstance(expr, ast.Tuple) and len(expr.items) == 2):
            raise props.bad(item, "needs pairs of an SNR and a rate", usage, expr.span)
        level = reader.scope.number(expr.items[0], units.DB)
        speed = reader.scope.number(expr.items[1], units.BIT_RATE)
        before = found[-1] if found else (-inf, 0.0)
        if not (level > before[0] and before[1] < speed <= _FASTEST):
            raise props.bad(item, "must rise, SNR and rate alike", usage, expr.span)
        found.append((level, speed))
    return tuple(found)


def _packet(reader: Reader) -> float | None:
    """Packet size in bytes; a bare number counts bytes."""
    item = reader.block.get("packet")
    if item is None:
        return None
    expr = props.only(item, "packet 32 bytes")
    scalar = reader.scope.constant(expr)
    size = scalar.constant if scalar.unit is None else reader.scope.number(expr, units.BIT) / 8.0
    if size <= 0:
        raise props.bad(item, "must be above 0", "packet 32 bytes")
    return reader.in_scale(item, size)
