"""Units and their algebra."""

from __future__ import annotations

import math

import pytest

from stlc.api import loads
from stlc.errors import MissionError
from stlc.grammar.units import UNITS
from stlc.sema import units
from stlc.sema.units import Unit, UnknownUnitName, parse_unit


@pytest.mark.parametrize(
    ("text", "value", "unit"),
    [
        ("m", 1.0, "m"),
        ("cm", 0.01, "m"),
        ("km", 1000.0, "m"),
        ("ms", 1e-3, "s"),
        ("min", 60.0, "s"),
        ("m/s", 1.0, "m/s"),
        ("km/h", 1 / 3.6, "m/s"),
        ("m/s^2", 1.0, "m/s^2"),
        ("kg*m/s^2", 1.0, "N"),
        ("N", 1.0, "N"),
        ("deg", math.pi / 180, "rad"),
        ("dB", 1.0, "dB"),
        ("dBm", 1.0, "dBm"),
        ("dB^2", 1.0, "dB^2"),
        ("MHz", 1e6, "Hz"),
        ("bytes", 8.0, "bit"),
        ("kbit/s", 1e3, "bit/s"),
        ("percent", 0.01, ""),
        ("mW", 1e-3, "kg*m^2/s^3"),
        ("1/s", 1.0, "Hz"),
    ],
)
def test_units_as_written(text: str, value: float, unit: str) -> None:
    scaled = parse_unit(text)
    assert scaled.scale == pytest.approx(value)
    assert str(scaled.unit) == unit
    assert not unit or parse_unit(unit).unit == scaled.unit


@pytest.mark.parametrize("text", ["furlong", "m/", "m s", "dBm^2", "m//s", "m^x", "1/s^"])
def test_unknown_units(text: str) -> None:
    with pytest.raises(UnknownUnitName):
        parse_unit(text)


@pytest.mark.parametrize(
    "text", ["h^400", "m^-400", "ms^99", "GHz^9*GHz^9*GHz^9*GHz^9", "m^" + "9" * 9000]
)
def test_powers_beyond_doubles_are_no_units(text: str) -> None:
    with pytest.raises(UnknownUnitName):
        parse_unit(text)


def test_products_and_powers() -> None:
    assert units.times(units.SPEED, units.SECOND) == units.METRE
    assert units.over(units.METRE, units.SECOND) == units.SPEED
    assert units.power(units.DB, 2) == units.DB2
    assert units.over(units.METRE, units.METRE) == Unit()


def verdict(comparison: str) -> str:
    """The code of the first mistake in a comparison over signals of several units, or `ok`."""
    text = (
        "signal p [dBm]\nsignal q [dBm]\nsignal g [dB]\nsignal x [m]\nsignal t [s]\n"
        f"signal n\nrequire: always[0, 3] {comparison}\n"
    )
    try:
        loads(text)
    except MissionError as error:
        return error.diagnostics[0].code
    return "ok"


@pytest.mark.parametrize(
    ("comparison", "expected"),
    [
        ("p - q >= 3 dB", "ok"),
        ("p + g >= -70 dBm", "ok"),
        ("p - g >= -70 dBm", "ok"),
        ("p >= -40 dBW", "ok"),
        ("p >= -70", "ok"),
        ("p + 3 >= q", "ok"),
        ("p + q >= -70 dBm", "E0302"),
        ("g - p >= 3 dB", "E0302"),
        ("p >= -70 dB", "E0304"),
        ("p - q >= 3 dBm", "E0304"),
        ("2 * p >= 3 dBm", "E0305"),
        ("-p <= 70 dBm", "E0305"),
        ("x >= 3 dB", "E0303"),
        ("x + t >= 3", "E0303"),
        ("x / 2 s >= 3 m/s", "ok"),
        ("x * 3 >= 50 cm", "ok"),
        ("max(x, 2 m) >= 3 km", "ok"),
        ("max(x, 2 s) >= 3", "E0303"),
        ("n >= 3 m", "ok"),
        ("n >= 30 percent", "ok"),
        ("x in [1 m, 2 m]", "ok"),
        ("x in [1 s, 2 s]", "E0303"),
    ],
)
def test_the_algebra_of_levels_and_dimensions(comparison: str, expected: str) -> None:
    assert verdict(comparison) == expected


def test_every_unit_of_the_syntax_is_known() -> None:
    for name in UNITS:
        parse_unit(name)
