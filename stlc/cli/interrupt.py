"""Ctrl-C, SIGTERM and SIGHUP: the first is a wish, the second an order."""

from __future__ import annotations

import _thread
import os
import signal
import sys
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from types import FrameType
from typing import NoReturn

from stlc.files import clear_scratch

INTERRUPTED = 130
_WATCHED = 0.5  # s since the last look at the flag: then somebody waits for it
_LATER = 0.01  # s until a signal that came at a lock is sent again: locks are taken in microseconds
_LOCKING = {"__enter__", "__exit__", "_acquire_restore", "_release_save"}
_IMPORTS = "<frozen importlib._bootstrap>"
_SIGNALS = tuple(
    getattr(signal, name) for name in ("SIGINT", "SIGTERM", "SIGHUP") if hasattr(signal, name)
)


class _Asker:
    """The handler. On the first signal it raises KeyboardInterrupt where nobody looks at the flag
    (reading, compiling), though never in the midst of taking or leaving a lock; the second ends
    the process at once: an exception more, thrown while the first unwinds, would break locks."""

    def __init__(self) -> None:
        self.asked = False
        self._looked = -_WATCHED
        self._late = False  # the signal is the first one again, by our own hand
        self._hears = signal.getsignal(signal.SIGINT) is not signal.SIG_IGN

    def __call__(self, number: int, frame: FrameType | None) -> None:
        if self.asked and not self._late:
            with suppress(OSError):
                os.write(2, b"\nerror: interrupted again: ended at once\n")
            end_at_once(INTERRUPTED)
        self.asked, self._late = True, False
        if time.monotonic() - self._looked <= _WATCHED:
            return
        if _at_a_lock(frame):
            _thread.start_new_thread(self._again, (number,))
            return
        raise KeyboardInterrupt

    def _again(self, number: int) -> None:
        """Send the signal once more, from a thread of its own."""
        time.sleep(_LATER)
        self._late = True
        if hasattr(signal, "pthread_kill"):
            signal.pthread_kill(threading.main_thread().ident or 0, number)
        else:
            _thread.interrupt_main(signal.Signals(number))

    def look(self) -> bool:
        self._looked = time.monotonic()
        if self._hears:
            signal.signal(signal.SIGINT, self)  # CBC puts its own, deaf one in its place
        return self.asked


def _at_a_lock(frame: FrameType | None) -> bool:
    """Whether Python code that takes or leaves a lock was interrupted.

    An exception there would leave the lock taken for ever, or have the `with` around it release a
    lock that it hasn't: `threading.Condition`, the base of events, queues and thread starts, takes
    its lock again in `_acquire_restore` after it has waited; imports have locks in Python too.
    """
    if frame is None:
        return False
    code = frame.f_code
    return code.co_name in _LOCKING or code.co_filename == _IMPORTS


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
