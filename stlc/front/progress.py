"""Progress of a solve in a notebook: one line that moves."""

from __future__ import annotations

import sys
import time
from dataclasses import dataclass
from typing import Any

from stlc.solve.events import (
    DiagnosticEvent,
    Event,
    Listener,
    ProgressEvent,
    SolutionEvent,
    ignore,
    words,
)

_EVERY = 0.2
"""Seconds between two looks of the line: as often as an eye follows."""


def listener(wanted: bool) -> Listener:
    """Shows progress in a notebook, if it is wanted; nothing elsewhere."""
    return _Line() if wanted and _notebook() else ignore


def _notebook() -> bool:
    """Whether this is a kernel of Jupyter, whose outputs may change."""
    shell = sys.modules.get("IPython")
    session = shell.get_ipython() if shell is not None else None
    return getattr(session, "kernel", None) is not None


@dataclass(slots=True)
class _Line:
    """The latest event; what a person should know stays, above it."""

    handle: Any = None
    shown: float = -_EVERY

    def __call__(self, event: Event, /) -> None:
        if isinstance(event, DiagnosticEvent):
            print(words(event))
            return
        now = time.monotonic()
        frequent = isinstance(event, ProgressEvent | SolutionEvent)
        if frequent and now < self.shown + _EVERY:
            return
        self.shown = now
        self._show(words(event))

    def _show(self, text: str) -> None:
        from IPython.display import display

        content = {"text/plain": text}
        if self.handle is None:
            self.handle = display(content, raw=True, display_id=True)
        else:
            self.handle.update(content, raw=True)
