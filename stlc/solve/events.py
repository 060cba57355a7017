"""What a long solve tells while it works: five kinds of events, as dataclasses and as NDJSON.

The JSON schema is `events.schema.json` beside this file; each line of NDJSON is one event.
"""

from __future__ import annotations

import json
import math
from collections.abc import Iterable
from dataclasses import asdict, dataclass
from typing import TYPE_CHECKING, ClassVar, Protocol

from stlc.diagnostics import Diagnostic
from stlc.sense import Sense

if TYPE_CHECKING:
    from stlc.backends.base import Progress


@dataclass(frozen=True, slots=True)
class ProgressEvent:
    """Where the solver stands. Seconds since the solve began; objective and bound go the way that
    the mission states; gap relative."""

    event: ClassVar[str] = "progress"
    seconds: float
    objective: float | None
    bound: float | None
    gap: float | None
    nodes: int | None

    @staticmethod
    def of(p: Progress, sense: Sense, seconds: float) -> ProgressEvent:
        """A solver's report, which is of a minimisation."""
        return ProgressEvent(seconds, sense.own(p.objective), sense.own(p.bound), p.gap, p.nodes)


@dataclass(frozen=True, slots=True)
class SolutionEvent:
    """A better certified and verified plan is in hand; `path` is where it was saved, if it was."""

    event: ClassVar[str] = "solution"
    seconds: float
    objective: float
    path: str | None


@dataclass(frozen=True, slots=True)
class StatusEvent:
    """A stage began or ended: compile, solve, explain, verify, stop, done."""

    event: ClassVar[str] = "status"
    stage: str
    message: str


@dataclass(frozen=True, slots=True)
class StatisticsEvent:
    """Size of the model."""

    event: ClassVar[str] = "statistics"
    columns: int
    binaries: int
    rows: int
    nonzeros: int
    encoding: str


@dataclass(frozen=True, slots=True)
class DiagnosticEvent:
    """Something a person should know: an ignored option, a risky big-M. `note` or `warning`."""

    event: ClassVar[str] = "diagnostic"
    severity: str
    message: str


Event = ProgressEvent | SolutionEvent | StatusEvent | StatisticsEvent | DiagnosticEvent


class Listener(Protocol):
    """Takes events as they come."""

    def __call__(self, event: Event, /) -> None:
        """Called in the thread that called `solve`."""


def ignore(event: Event, /) -> None:
    """The listener that says nothing."""


def tell_warnings(warnings: Iterable[Diagnostic], listen: Listener) -> None:
    """The warnings of a compiled mission as events, none of them twice."""
    for text in dict.fromkeys(f"{warning}; {warning.label_text}" for warning in warnings):
        listen(DiagnosticEvent("warning", text))


def words(event: Event) -> str:
    """An event in a line for people."""
    match event:
        case ProgressEvent():
            return _progress_text(event)
        case SolutionEvent():
            where = f" -> {event.path}" if event.path else ""
            return f"{event.seconds:6.1f} s  certified plan, objective {event.objective:.6g}{where}"
        case StatusEvent():
            return f"{event.stage}: {event.message}"
        case StatisticsEvent():
            return (
                f"{event.columns} columns ({event.binaries} binary), {event.rows} rows, "
                f"{event.nonzeros} nonzeros, encoding {event.encoding}"
            )
        case DiagnosticEvent():
            return f"{event.severity}: {event.message}"


def _progress_text(event: ProgressEvent) -> str:
    def show(value: float | None, style: str) -> str:
        return "-" if value is None else format(value, style)

    return (
        f"{event.seconds:6.1f} s  incumbent {show(event.objective, '.6g')}  "
        f"bound {show(event.bound, '.6g')}  gap {show(event.gap, '.2%')}  "
        f"nodes {show(event.nodes, 'd')}"
    )


def to_ndjson(event: Event) -> str:
    """One line of JSON without its line end; non-finite numbers are null."""
    fields = {k: _plain(v) for k, v in asdict(event).items()}
    return json.dumps({"event": event.event, **fields}, allow_nan=False)


def _plain(value: object) -> object:
    return None if isinstance(value, float) and not math.isfinite(value) else value
