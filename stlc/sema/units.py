"""Units: a small dimension algebra over m, s, kg, rad, bit and dB, with dBm as a level.

Every unit has a scale to the SI base. Decibels are a dimension of their own; a dBm is an absolute
level in it, counted by `level`, so that dBm - dBm is dB, dBm + dB is dBm, and dBm + dBm is nothing.
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from functools import lru_cache
from math import pi

Dims = tuple[tuple[str, int], ...]


@dataclass(frozen=True, slots=True)
class Unit:
    """Exponents of the base units, sorted; `level` 1 marks an absolute level (dBm)."""

    dims: Dims = ()
    level: int = 0

    def __str__(self) -> str:
        if self.level:
            return "dBm"
        return _NAMED.get(self.dims) or _spell(self.dims)


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

_PREFIXED = {"m": METRE, "s": SECOND, "N": NEWTON, "Hz": HERTZ, "bit": BIT}
_PREFIXES = {"": 1.0, "n": 1e-9, "u": 1e-6, "µ": 1e-6, "m": 1e-3, "k": 1e3, "M": 1e6, "G": 1e9}

_TABLE: dict[str, Scaled] = {
    **{p + n: Scaled(u, f) for n, u in _PREFIXED.items() for p, f in _PREFIXES.items()},
    "cm": Scaled(METRE, 1e-2),
    "dm": Scaled(METRE, 1e-1),
    "meter": Scaled(METRE),
    "metre": Scaled(METRE),
    "min": Scaled(SECOND, 60.0),
    "h": Scaled(SECOND, 3600.0),
    "sec": Scaled(SECOND),
    "kg": Scaled(KILOGRAM),
    "g": Scaled(KILOGRAM, 1e-3),
    "rad": Scaled(Unit((("rad", 1),))),
    "deg": Scaled(Unit((("rad", 1),)), pi / 180.0),
    "byte": Scaled(BIT, 8.0),
    "bytes": Scaled(BIT, 8.0),
    "B": Scaled(BIT, 8.0),
    "kB": Scaled(BIT, 8e3),
    "bits": Scaled(BIT),
    "bps": Scaled(BIT_RATE),
    "kbps": Scaled(BIT_RATE, 1e3),
    "Mbps": Scaled(BIT_RATE, 1e6),
    "dB": Scaled(DB),
    "dBm": Scaled(DBM),
    "dBW": Scaled(DBM, 1.0, 30.0),
    "1": Scaled(PURE),
    "percent": Scaled(PURE, 1e-2),
    "%": Scaled(PURE, 1e-2),
}

KNOWN = tuple(sorted(n for n in _TABLE if n != "1"))
"""Every unit name, for suggestions."""

_FACTOR = re.compile(r"\s*([*/·]?)\s*([A-Za-zµ%1]+)(?:\s*\^\s*(-?\d+))?")


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
        if match is None or match[2] not in _TABLE:
            raise UnknownUnitName(match[2] if match else text)
        part = _TABLE[match[2]]
        exponent = int(match[3] or 1) * (-1 if match[1] == "/" else 1)
        if part.unit.level:
            raise UnknownUnitName(text)
        unit = times(unit, power(part.unit, exponent))
        scale *= part.scale**exponent
        at = match.end()
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
