"""Values of JSON and where they stand: what is missing or of another type is named."""

from __future__ import annotations

import sys
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from stlc.errors import UsageError

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class Place:
    """A JSON value and where it stands, for messages."""

    file: str
    path: str
    value: Any

    def fail(self, wanted: str) -> UsageError:
        """The error that names this place and what was expected there."""
        where = f" at {self.path.lstrip('.')}" if self.path else ""
        return UsageError(f"{self.file}: not a valid plan{where}: expected {wanted}")

    def has(self, key: str) -> bool:
        """Whether it is an object with this key."""
        return isinstance(self.value, dict) and key in self.value

    def __getitem__(self, key: str) -> Place:
        if not isinstance(self.value, dict):
            raise self.fail("an object")
        if key not in self.value:
            raise self.fail(f"a field {key!r}")
        return Place(self.file, f"{self.path}.{key}", self.value[key])

    def fields(self) -> dict[str, Place]:
        """The places of an object, by key."""
        if not isinstance(self.value, dict):
            raise self.fail("an object")
        return {key: self[key] for key in self.value}

    def items(self) -> list[Place]:
        """The places of a list."""
        if not isinstance(self.value, list):
            raise self.fail("a list")
        return [Place(self.file, f"{self.path}[{i}]", v) for i, v in enumerate(self.value)]

    def text(self) -> str:
        """A text."""
        if not isinstance(self.value, str):
            raise self.fail("a text")
        return self.value

    def texts(self) -> tuple[str, ...]:
        """A list of texts."""
        return tuple(item.text() for item in self.items())

    def truth(self) -> bool:
        """True or false."""
        if not isinstance(self.value, bool):
            raise self.fail("true or false")
        return self.value

    def number(self) -> float:
        """A finite number."""
        value = self.value
        if isinstance(value, bool) or not isinstance(value, int | float):
            raise self.fail("a number")
        if abs(value) > sys.float_info.max:
            raise self.fail("a finite number")
        return float(value)

    def optional(self) -> float | None:
        """A number, "inf", "-inf" or null."""
        if self.value is None:
            return None
        return float(self.value) if self.value in ("inf", "-inf") else self.number()

    def array(self, rows: int, columns: int) -> Array:
        """Finite numbers (rows, columns)."""
        lines = self.items()
        if len(lines) != rows:
            raise self.fail(f"{rows} rows, not {len(lines)}")
        out = np.empty((rows, columns))
        for i, line in enumerate(lines):
            cells = line.items()
            if len(cells) != columns:
                raise line.fail(f"{columns} numbers, not {len(cells)}")
            out[i] = [cell.number() for cell in cells]
        return out
