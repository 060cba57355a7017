"""Units: a small dimension algebra over m, s, kg, rad, bit and dB, with dBm as a level.

Every unit has a scale to the SI base. Decibels are a dimension of their own; a dBm is an absolute
level in it, counted by `level`, so that dBm - dBm is dB, dBm + dB is dBm, and dBm + dBm is nothing.
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from functools import lru_cache
from math import inf, pi

Dims = tuple[tuple[str, int], ...]


@dataclass(frozen=True, slots=True)
class Unit:
    """Exponents of the base units, sorted; `level` 1 marks an absolute level (dBm)."""

    dims: Dims = ()
    level: int = 0

    def __str__(self) -> str:
        if self.level:
            return "dBm"
        named = _NAMED.get(self.dims)
        return _spell(self.dims) if named is None else named


@dataclass(frozen=True, slots=True)
class Scaled:
    """A unit as written: SI value = `scale` * number + `offset`."""

    unit: Unit
    scale: float = 1.0
    offset: float = 0.0


PURE = Unit()
METRE = Unit((("m", 1),))
SECOND = Unit((("s", 1),))
KILOGRAM = Unit((("kg", 1),))
SPEED = Unit((("m", 1), ("s", -1)))
ACCELERATION = Unit((("m", 1), ("s", -2)))
NEWTON = Unit((("kg", 1), ("m", 1), ("s", -2)))
DB = Unit((("dB", 1),))
DB2 = Unit((("dB", 2),))
DBM = Unit((("dB", 1),), level=1)
HERTZ = Unit((("s", -1),))
BIT = Unit((("bit", 1),))
BIT_RATE = Unit((("bit", 1), ("s", -1)))

_NAMED: dict[Dims, str] = {(): "", NEWTON.dims: "N", HERTZ.dims: "Hz"}

WATT = Unit((("kg", 1), ("m", 2), ("s", -3)))
JOULE = Unit((("kg", 1), ("m", 2), ("s", -2)))
RADIAN = Unit((("rad", 1),))

_FACTORS = {"": 1.0, "u": 1e-6, "m": 1e-3, "c": 1e-2, "k": 1e3, "M": 1e6, "G": 1e9}
_PREFIXED: tuple[tuple[str, Unit, str], ...] = (
    ("m", METRE, "mck"),
    ("s", SECOND, "um"),
    ("N", NEWTON, "mk"),
    ("rad", RADIAN, "m"),
    ("Hz", HERTZ, "kMG"),
    ("W", WATT, "umk"),
    ("J", JOULE, "umk"),
    ("bit", BIT, "kMG"),
)

_TABLE: dict[str, Scaled] = {
    **{n: Scaled(u) for n, u, _ in _PREFIXED},
    **{p + n: Scaled(u, _FACTORS[p]) for n, u, prefixes in _PREFIXED for p in prefixes},
    "min": Scaled(SECOND, 60.0),
    "h": Scaled(SECOND, 3600.0),
    "kg": Scaled(KILOGRAM),
    "g": Scaled(KILOGRAM, 1e-3),
    "deg": Scaled(RADIAN, pi / 180.0),
    "byte": Scaled(BIT, 8.0),
    "bytes": Scaled(BIT, 8.0),
    "dB": Scaled(DB),
    "dBi": Scaled(DB),
    "dBm": Scaled(DBM),
    "dBW": Scaled(DBM, 1.0, 30.0),
    "1": Scaled(PURE),
    "percent": Scaled(PURE, 1e-2),
    "%": Scaled(PURE, 1e-2),
}

KNOWN = tuple(sorted(n for n in _TABLE if n != "1"))
"""Every unit name, for suggestions."""

_FACTOR = re.compile(r"\s*([*/·]?)\s*([A-Za-z%1]+)(?:\s*\^\s*(-?\d+))?\s*")


_POWER = re.compile(r"-?\d")
"""Exponents of one digit: to such a power the factor of every prefix is a double."""


class UnknownUnitName(ValueError):
    """A unit whose part `name` isn't known."""

    def __init__(self, name: str) -> None:
        self.name = name
        super().__init__(name)


@lru_cache(maxsize=512)
def parse_unit(text: str) -> Scaled:
    """The unit that `text` spells: `m`, `dBm`, `m/s^2`, `kbit/s`. Raises UnknownUnitName."""
    if text in _TABLE:
        return _TABLE[text]
    unit, scale, at = PURE, 1.0, 0
    while at < len(text):
        match = _FACTOR.match(text, at)
        if match is None or match[2] not in _TABLE or bool(at) != bool(match[1]):
            raise UnknownUnitName(match[2] if match else text)
        part = _TABLE[match[2]]
        if part.unit.level or not _POWER.fullmatch(match[3] or "1"):
            raise UnknownUnitName(text)
        exponent = int(match[3] or 1) * (-1 if match[1] == "/" else 1)
        unit = times(unit, power(part.unit, exponent))
        scale *= part.scale**exponent
        at = match.end()
    if not 0.0 < scale < inf:
        raise UnknownUnitName(text)
    return Scaled(unit, scale)


def times(a: Unit, b: Unit) -> Unit:
    """Unit of a product of two relative quantities."""
    exponents = dict(a.dims)
    for name, exponent in b.dims:
        exponents[name] = exponents.get(name, 0) + exponent
    return Unit(tuple(sorted((n, e) for n, e in exponents.items() if e)))


def power(a: Unit, exponent: int) -> Unit:
    """Unit of a whole power."""
    return Unit(tuple((n, e * exponent) for n, e in a.dims if e * exponent))


def over(a: Unit, b: Unit) -> Unit:
    """Unit of a quotient."""
    return times(a, power(b, -1))


def _spell(dims: Dims) -> str:
    above = [_part(n, e) for n, e in dims if e > 0]
    below = [_part(n, -e) for n, e in dims if e < 0]
    top = "*".join(above) or "1"
    return "/".join([top, *below])


def _part(name: str, exponent: int) -> str:
    return name if exponent == 1 else f"{name}^{exponent}"
