"""The properties of a channel's block, read by kind."""

from __future__ import annotations

from dataclasses import dataclass

from stlc.sema import props, units
from stlc.sema.number_errors import OutOfScale
from stlc.sema.report import Mistake
from stlc.sema.scope import Scope
from stlc.sema.units import Unit
from stlc.syntax import ast

_LEVEL = (-1000.0, 1000.0)  # dB; 10^(x/10) overflows at 3082
_LENGTH = (1e-6, 1e9)  # m; quotients of a distance and a length, and their squares, stay finite
_SCALES = {
    "L0": _LEVEL, "noise_floor": _LEVEL, "noise_figure": _LEVEL, "sensitivity": _LEVEL,
    "power": _LEVEL, "frequency": (1e3, 1e15), "n": (-100.0, 100.0),
    "length": _LENGTH, "d0": _LENGTH,
    "fading": (0.0, 1e4), "shadowing": (0.0, 1e4), "deviation": (0.0, 1e3),
    "bandwidth": (1e-6, 1e15), "rate": (1e-6, 1e15), "packet": (0.125, 1e9),
}  # fmt: skip
"""Least and greatest positive value of each number, in its unit."""


@dataclass(frozen=True, slots=True)
class Reader:
    """The properties of one channel, read by kind."""

    block: props.Block
    scope: Scope

    def number(self, key: str, unit: Unit, default: float | None = None) -> float | None:
        """A number in the given unit, or the default."""
        item = self.block.get(key)
        if item is None:
            return default
        value = props.number(item, unit, f"{key} 1 {unit}".strip(), self.scope)
        return self.in_scale(item, value)

    def variance(self, key: str) -> float:
        """A variance in dB^2, or a standard deviation in dB; 0 if absent."""
        item = self.block.get(key)
        if item is None:
            return 0.0
        expr = props.only(item, f"{key} 10 dB^2")
        scalar = self.scope.constant(expr)
        if scalar.constant < 0:
            raise props.bad(item, "can't be negative", f"{key} 10 dB^2")
        squared = scalar.unit == units.DB
        value = scalar.constant if squared else self.scope.number(expr, units.DB2)
        value = self.in_scale(item, value)
        return value**2 if squared else value

    def in_scale(self, item: ast.Property, value: float) -> float:
        """The value. Raises Mistake where it is none that the formulas of radio can bear."""
        least, most = _SCALES[item.key.text]
        if (value > 0 and not least <= value <= most) or value < -most:
            name = item.key.text
            raise Mistake(
                OutOfScale(span=item.span, name=name, value=value, least=least, most=most)
            )
        return value

    def word(self, key: str, choices: tuple[str, ...], default: str) -> str:
        """One of the words, or the default."""
        item = self.block.get(key)
        return default if item is None else props.word(item, choices, f"{key} {choices[0]}")

    def positive(self, key: str, unit: Unit) -> float | None:
        """A number above 0, or None."""
        value = self.number(key, unit)
        if value is not None and value <= 0:
            raise props.bad(self.block.by_key[key], "must be above 0", f"{key} 1")
        return value
