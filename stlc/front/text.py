"""Python values as the language writes them."""

from __future__ import annotations

import math
from collections.abc import Iterable
from numbers import Real
from typing import Any, Protocol, runtime_checkable

import numpy as np


@runtime_checkable
class Written(Protocol):
    """Whatever has a text in the language."""

    @property
    def text(self) -> str:
        """The text."""
        ...


def written(value: Any) -> str:
    """A number, a text such as "2 m/s", or an object with a text of its own.

    Numbers keep every digit. Raises ValueError for NaN and infinities, TypeError for what the
    language has no word for.
    """
    if isinstance(value, str):
        return value
    if isinstance(value, Written):
        return value.text
    if isinstance(value, Real) or (isinstance(value, np.ndarray) and value.ndim == 0):
        return number(float(value))
    raise TypeError(f"a number, a text or a quantity is needed, not {type(value).__name__}")


def number(value: float) -> str:
    """The shortest digits that read back as the same double."""
    if not math.isfinite(value):
        raise ValueError(f"{value} is no number that a mission can hold")
    return str(int(value)) if value == int(value) and abs(value) < 1e15 else repr(value)


def point(values: Any) -> str:
    """`(1, 2)`; a text is taken as it is, a lone number without brackets."""
    if isinstance(values, str | Real | Written):
        return written(values)
    return f"({', '.join(written(v) for v in np.asarray(values, dtype=object).ravel())})"


def matrix(values: Any) -> str:
    """`[[1, 0], [0, 1]]`, or `[1, 0]` for a vector; a text is taken as it is."""
    if isinstance(values, str):
        return values
    return _nested(np.asarray(values, dtype=np.float64).tolist())


def _nested(values: Any) -> str:
    if isinstance(values, list):
        return f"[{', '.join(map(_nested, values))}]"
    return number(values)


def interval(start: Any, end: Any) -> str:
    """`[2, 8]` or nothing; one end alone is the last (`[0, 8]`), None is open."""
    if start is None and end is None:
        return ""
    low = "0" if start is None else written(start)
    return f"[{low}, {'end' if end is None else written(end)}]"


def words(values: str | Iterable[str]) -> str:
    """Names one after the other."""
    return values if isinstance(values, str) else " ".join(values)
