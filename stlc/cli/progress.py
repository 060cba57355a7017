"""How `stlc solve` shows long work: one live line at a terminal, plain lines elsewhere, NDJSON."""

from __future__ import annotations

import shutil
import sys
from dataclasses import dataclass

import click

from stlc.cli.common import debugging
from stlc.solve.events import (
    DiagnosticEvent,
    Event,
    Listener,
    ProgressEvent,
    StatisticsEvent,
    StatusEvent,
    ignore,
    to_ndjson,
    words,
)

_CLEAR = "\r\x1b[K"


EVERY = 10.0  # s between lines of progress in a log: an hour's solve is a few pages


def listener(style: str) -> Listener:
    """`auto`, `line`, `text`, `ndjson` or `none`; everything goes to standard error.

    With STLC_DEBUG it is NDJSON, whatever was asked: a log of every event.
    """
    if debugging():
        return _ndjson
    if style == "auto":
        style = "line" if sys.stderr.isatty() else "text"
    if style == "text":
        return _Log()
    return {"line": _line, "ndjson": _ndjson, "none": ignore}[style]


def _ndjson(event: Event, /) -> None:
    click.echo(to_ndjson(event), err=True)


def _line(event: Event, /) -> None:
    """Shows an event on one line of the terminal, which the next event writes over."""
    if isinstance(event, DiagnosticEvent):
        click.echo(_CLEAR + words(event), err=True)
        return
    width = shutil.get_terminal_size().columns - 1
    last = isinstance(event, StatusEvent) and event.stage in ("done", "explain", "stop")
    click.echo(
        _CLEAR + words(event)[:width], err=True, nl=last or isinstance(event, StatisticsEvent)
    )


@dataclass(slots=True)
class _Log:
    """A line for each event, of the solver's progress one in `EVERY` seconds."""

    told: float = 0.0

    def __call__(self, event: Event, /) -> None:
        if isinstance(event, ProgressEvent):
            if event.seconds < self.told + EVERY:
                return
            self.told = event.seconds
        click.echo(words(event), err=True)
