"""How `stlc solve` shows long work: one live line at a terminal, NDJSON elsewhere."""

from __future__ import annotations

import shutil
import sys

import click

from stlc.cli.common import debugging
from stlc.solve.events import (
    DiagnosticEvent,
    Event,
    Listener,
    ProgressEvent,
    SolutionEvent,
    StatisticsEvent,
    StatusEvent,
    ignore,
    to_ndjson,
)

_CLEAR = "\r\x1b[K"


def listener(style: str) -> Listener:
    """`auto`, `line`, `ndjson` or `none`; everything goes to standard error.

    With STLC_DEBUG it is NDJSON, whatever was asked: a log of every event.
    """
    if debugging():
        return _ndjson
    if style == "auto":
        style = "line" if sys.stderr.isatty() else "ndjson"
    return {"line": _line, "ndjson": _ndjson, "none": ignore}[style]


def _ndjson(event: Event, /) -> None:
    click.echo(to_ndjson(event), err=True)


def _line(event: Event, /) -> None:
    """Shows an event on one line of the terminal, which the next event writes over."""
    match event:
        case ProgressEvent():
            text = _progress_text(event)
        case SolutionEvent():
            where = f" -> {event.path}" if event.path else ""
            text = f"{event.seconds:6.1f} s  certified plan, objective {event.objective:.6g}{where}"
        case StatusEvent():
            text = f"{event.stage}: {event.message}"
        case StatisticsEvent():
            text = (
                f"{event.columns} columns ({event.binaries} binary), {event.rows} rows, "
                f"{event.nonzeros} nonzeros, encoding {event.encoding}"
            )
        case DiagnosticEvent():
            click.echo(f"{_CLEAR}{event.severity}: {event.message}", err=True)
            return
    width = shutil.get_terminal_size().columns - 1
    last = isinstance(event, StatusEvent) and event.stage in ("done", "explain", "stop")
    click.echo(_CLEAR + text[:width], err=True, nl=last or isinstance(event, StatisticsEvent))


def _progress_text(event: ProgressEvent) -> str:
    def show(value: float | None, style: str) -> str:
        return "-" if value is None else format(value, style)

    return (
        f"{event.seconds:6.1f} s  incumbent {show(event.objective, '.6g')}  "
        f"bound {show(event.bound, '.6g')}  gap {show(event.gap, '.2%')}  "
        f"nodes {show(event.nodes, 'd')}"
    )
