"""Unit words that may follow a number. What they mean is up to semantic analysis."""

from __future__ import annotations

from difflib import get_close_matches
from typing import Final

UNITS: Final[frozenset[str]] = frozenset(
    {
        *("m", "km", "cm", "mm"),
        *("s", "ms", "us", "min", "h"),
        *("kg", "g", "N", "mN", "kN"),
        *("rad", "mrad", "deg"),
        *("dB", "dBm", "dBW", "dBi"),
        *("Hz", "kHz", "MHz", "GHz"),
        *("W", "mW", "uW", "J", "mJ", "uJ"),
        *("bit", "kbit", "Mbit", "byte", "bytes", "percent"),
        "%",
    }
)
_LONG: Final = {
    "m": ("meter", "meters", "metre", "metres", "mtr"),
    "s": ("sec", "secs", "second", "seconds"),
    "min": ("mins", "minute", "minutes"),
    "h": ("hr", "hrs", "hour", "hours"),
    "kg": ("kilo", "kilos", "kilogram", "kilograms"),
    "N": ("newton", "newtons"),
    "rad": ("radian", "radians"),
    "deg": ("degree", "degrees"),
}


def nearest_unit(word: str) -> str | None:
    """The unit that a person means by `sec`, `metres`, `db` or `dbmm`; None for other words."""
    lower = word.lower()
    names = {unit.lower(): unit for unit in sorted(UNITS)}
    names |= {long: unit for unit, words in _LONG.items() for long in words}
    if word in UNITS:
        return word
    near = [lower] if lower in names else get_close_matches(lower, names, 1, 0.7)
    return names[near[0]] if near else None
