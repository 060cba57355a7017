"""Quantities and formulas, built by Python's operators; each is a text of the language.

Brackets are written wherever one part joins another; the printer takes out those that say nothing.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, NoReturn

from stlc.front.text import interval, written


def _bracketed(value: Any) -> str:
    text = written(value)
    return text if text.replace("_", "").replace(".", "").isalnum() else f"({text})"


@dataclass(frozen=True, slots=True, eq=False)
class Quantity:
    """A number that depends on the run, a constant with a unit, or a cost."""

    text: str

    def __add__(self, other: Any) -> Quantity:
        return Quantity(f"{self.text} + {_bracketed(other)}")

    def __radd__(self, other: Any) -> Quantity:
        # `sum` begins with 0
        return self if isinstance(other, int) and other == 0 else Quantity(
            f"{_bracketed(other)} + {_bracketed(self)}"
        )  # fmt: skip

    def __sub__(self, other: Any) -> Quantity:
        return Quantity(f"{self.text} - {_bracketed(other)}")

    def __rsub__(self, other: Any) -> Quantity:
        return Quantity(f"{_bracketed(other)} - {_bracketed(self)}")

    def __mul__(self, other: Any) -> Quantity:
        return Quantity(f"{_bracketed(self)} * {_bracketed(other)}")

    def __rmul__(self, other: Any) -> Quantity:
        return Quantity(f"{_bracketed(other)} * {_bracketed(self)}")

    def __truediv__(self, other: Any) -> Quantity:
        return Quantity(f"{_bracketed(self)} / {_bracketed(other)}")

    def __neg__(self) -> Quantity:
        return Quantity(f"-{_bracketed(self)}")

    def __abs__(self) -> Quantity:
        return Quantity(f"abs({self.text})")

    def __getitem__(self, index: int) -> Quantity:
        return Quantity(f"{self.text}[{index}]")

    def __ge__(self, other: Any) -> Formula:
        return Formula(f"{self.text} >= {_compared(other)}")

    def __le__(self, other: Any) -> Formula:
        return Formula(f"{self.text} <= {_compared(other)}")

    def __gt__(self, other: Any) -> Formula:
        return Formula(f"{self.text} > {_compared(other)}")

    def __lt__(self, other: Any) -> Formula:
        return Formula(f"{self.text} < {_compared(other)}")

    def __repr__(self) -> str:
        return f"<Quantity {self.text}>"


def _compared(value: Any) -> str:
    """A bound; of two numbers one for each axis."""
    if isinstance(value, tuple | list):
        return f"({', '.join(written(v) for v in value)})"
    return written(value)


@dataclass(frozen=True, slots=True, eq=False)
class Formula:
    """A formula: `&` and, `|` or, `~` not, `>>` implies; `until` and `release` take an interval."""

    text: str

    def __and__(self, other: Formula | str) -> Formula:
        return Formula(f"({self.text}) and ({written(other)})")

    def __rand__(self, other: str) -> Formula:
        return Formula(f"({other}) and ({self.text})")

    def __or__(self, other: Formula | str) -> Formula:
        return Formula(f"({self.text}) or ({written(other)})")

    def __ror__(self, other: str) -> Formula:
        return Formula(f"({other}) or ({self.text})")

    def __rshift__(self, other: Formula | str) -> Formula:
        return Formula(f"({self.text}) implies ({written(other)})")

    def __invert__(self) -> Formula:
        return Formula(f"not ({self.text})")

    def iff(self, other: Formula | str) -> Formula:
        """Both or neither."""
        return Formula(f"({self.text}) iff ({written(other)})")

    def until(self, other: Formula | str, start: Any = None, end: Any = None) -> Formula:
        """This holds until `other` does, at a step of the interval."""
        return self._joined("until", other, start, end)

    def release(self, other: Formula | str, start: Any = None, end: Any = None) -> Formula:
        """The dual of `until`."""
        return self._joined("release", other, start, end)

    def _joined(self, word: str, other: Formula | str, start: Any, end: Any) -> Formula:
        return Formula(f"({self.text}) {word}{interval(start, end)} ({written(other)})")

    def swept(self) -> Formula:
        """The same between the steps too."""
        return Formula(f"{self.text} swept")

    def __bool__(self) -> NoReturn:
        raise TypeError(
            "a formula is neither true nor false before there is a plan: join formulas with "
            "& | ~ >>, and write a chain a <= x <= b as (a <= x) & (x <= b)"
        )

    def __repr__(self) -> str:
        return f"<Formula {self.text}>"
