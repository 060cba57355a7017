"""`-D speed=1..3:0.5`, `-D alpha=0.1,0.5,0.9`: the values that parameters take."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass
from decimal import Decimal
from itertools import product

from stlc.errors import UsageError

MOST = 100_000
"""Points of one sweep: more are a slip of the pen."""

_NUMBER = r"[+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?"
_LONE = re.compile(rf"\s*{_NUMBER}\s*")
_WITH_UNIT = re.compile(rf"\s*(?=(?P<number>{_NUMBER}))(?P=number)\s*([^\W\d].*?)\s*")
_RANGE = re.compile(rf"\s*({_NUMBER})\s*\.\.\s*({_NUMBER})\s*:\s*({_NUMBER})\s*(\S.*?)?\s*")

_RANGES = "a range goes up, FIRST..LAST:STEP with a step above 0"

Point = tuple[tuple[str, str], ...]
"""Names and values, as `-D` takes them."""


@dataclass(frozen=True, slots=True)
class Axis:
    """One parameter and its values, as `-D` takes them."""

    name: str
    values: tuple[str, ...]

    @staticmethod
    def parse(text: str) -> Axis:
        """`v=1..3:0.5 m/s` (both ends, if the steps meet the last), `v=1, 2 m/s`, or one value.

        Decimal arithmetic, so that 0.1..0.5:0.1 ends at 0.5. A unit after the last value of a list
        is that of all without one. UsageError for what is neither.
        """
        name, sign, given = text.partition("=")
        if not sign or not name.strip() or not given.strip():
            raise UsageError(f"-D takes NAME=VALUES such as v=1..3:0.5 or v=1,2,5, not {text!r}")
        found = _RANGE.fullmatch(given)
        if found is None and ".." in given:
            raise UsageError(f"-D {text}: {_RANGES}")
        if found is None:
            values = _listed([value.strip() for value in given.split(",") if value.strip()])
        else:
            first, last, step = (Decimal(found[k]) for k in (1, 2, 3))
            values = _steps(text, (first, last, step), found[4])
        if not values:
            raise UsageError(f"-D {text}: no value is given")
        if len(set(values)) != len(values):
            raise UsageError(f"-D {text}: a value stands twice")
        return Axis(name.strip(), values)


def _listed(values: list[str]) -> tuple[str, ...]:
    """The values of a list; those without a unit have that of the last."""
    found = _WITH_UNIT.fullmatch(values[-1]) if values else None
    if found is None:
        return tuple(values)
    return tuple(f"{v} {found[2]}" if _LONE.fullmatch(v) else v for v in values)


def _steps(text: str, ends: tuple[Decimal, Decimal, Decimal], unit: str | None) -> tuple[str, ...]:
    """FIRST..LAST:STEP as texts. UsageError where it goes nowhere, or on and on."""
    first, last, step = ends
    if step <= 0 or last < first:
        raise UsageError(f"-D {text}: {_RANGES}")
    count = int((last - first) / step) + 1
    if count > MOST:
        raise UsageError(f"-D {text}: {count} values are more than {MOST}")
    tail = f" {unit}" if unit else ""
    return tuple(f"{(first + k * step).normalize():f}{tail}" for k in range(count))


def points(axes: Sequence[Axis]) -> list[Point]:
    """Every combination, the last axis first. UsageError for a name given twice, or too many."""
    names = [axis.name for axis in axes]
    if len(set(names)) != len(names):
        raise UsageError(f"-D names a parameter twice: {', '.join(names)}")
    total = 1
    for axis in axes:
        total *= len(axis.values)
    if total > MOST:
        raise UsageError(f"{total} points are more than {MOST}")
    return [tuple(zip(names, values, strict=True)) for values in product(*(a.values for a in axes))]
