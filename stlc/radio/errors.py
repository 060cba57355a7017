"""Errors of the radio package: each one says what is wrong and what would be right."""

from __future__ import annotations

from dataclasses import dataclass

from stlc.errors import StlcError


class RadioError(StlcError, ValueError):
    """A channel, a sample file or a link question that has no sound answer."""


class KernelError(RadioError):
    """A kernel that is not a covariance on the given positions."""


class FitError(RadioError):
    """Samples from which the channel cannot be estimated."""


@dataclass(frozen=True, slots=True)
class DataLocation:
    """Place in a data file; `line` and `column` count from one, None when unknown."""

    path: str
    line: int | None = None
    column: int | None = None

    def __str__(self) -> str:
        parts = [self.path]
        if self.line is not None:
            parts.append(str(self.line))
        if self.line is not None and self.column is not None:
            parts.append(str(self.column))
        return ":".join(parts)


class DataError(RadioError):
    """A data file that cannot be read; `location` is where, `help` what would be right."""

    def __init__(self, message: str, location: DataLocation, help: str = "") -> None:
        self.message = message
        self.location = location
        self.help = help
        tail = f" ({help})" if help else ""
        super().__init__(f"{location}: {message}{tail}")
