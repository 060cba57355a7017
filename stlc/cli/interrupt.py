"""Ctrl-C, SIGTERM and SIGHUP: the first is a wish, the second an order."""

from __future__ import annotations

import os
import signal
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import NoReturn

from stlc.files import clear_scratch

INTERRUPTED = 130
_WATCHED = 0.5  # s since the last look at the flag: then somebody waits for it
_SIGNALS = tuple(
    getattr(signal, name) for name in ("SIGINT", "SIGTERM", "SIGHUP") if hasattr(signal, name)
)


class _Asker:
    """The handler. On the first signal it raises KeyboardInterrupt where nobody looks at the flag
    (reading, compiling); the second ends the process at once: an exception more, thrown while the
    first unwinds, would break locks in the midst of their own code."""

    def __init__(self) -> None:
        self.asked = False
        self._looked = -_WATCHED

    def __call__(self, number: int, frame: object) -> None:
        if self.asked:
            with suppress(OSError):
                os.write(2, b"\nerror: interrupted again: ended at once\n")
            end_at_once(INTERRUPTED)
        self.asked = True
        if time.monotonic() - self._looked > _WATCHED:
            raise KeyboardInterrupt

    def look(self) -> bool:
        self._looked = time.monotonic()
        signal.signal(signal.SIGINT, self)  # CBC puts its own, deaf one in its place
        return self.asked


@contextmanager
def interruptible() -> Iterator[Callable[[], bool]]:
    """A flag that the first signal sets, for those who look at it while a solver works."""
    asker = _Asker()
    before = _install(asker)
    try:
        yield asker.look
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)


def heed_signals() -> None:
    """For the whole of a command: interrupted, it unwinds and leaves nothing half-written."""
    _install(_Asker())


def _install(asker: _Asker) -> dict[int, signal.Handlers | Callable[..., object] | int | None]:
    """The handlers that were there; what is ignored (by `nohup`) stays so."""
    heard = [n for n in _SIGNALS if signal.getsignal(n) is not signal.SIG_IGN]
    return {n: signal.signal(n, asker) for n in heard}


def leave(status: int) -> NoReturn:
    """End the process; at once, with its children, when a solver was left behind in its thread."""
    for number in _SIGNALS:  # the status stands: it is what was told
        signal.signal(number, signal.SIG_IGN)
    supervise = sys.modules.get("stlc.solve.supervise")  # not imported: nothing was solved
    if supervise is not None and supervise.left_behind():
        end_at_once(status)
    clear_scratch()
    sys.exit(status)


def end_at_once(status: int) -> NoReturn:
    """End without unwinding, but with our children and without temporary files."""
    for number in _SIGNALS:
        signal.signal(number, signal.SIG_IGN)
    for child in _children():
        with suppress(OSError):
            leads = os.getpgid(child) == child
            (os.killpg if leads else os.kill)(child, signal.SIGKILL)
    clear_scratch()
    os._exit(status)


def _children() -> list[int]:
    """Process ids of our children, where the system tells (Linux)."""
    lists = Path("/proc/self/task").glob("*/children")
    return [int(word) for path in lists for word in path.read_text().split()]
