"""Unit words that may follow a number. What they mean is up to semantic analysis."""

from __future__ import annotations

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
