"""Ctrl-C and SIGTERM for commands that solve."""

from __future__ import annotations

import os
import signal
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

_WATCHED = 0.5  # s since the last look at the flag: then somebody waits for it


@contextmanager
def interruptible() -> Iterator[Callable[[], bool]]:
    """A flag that the first signal sets, for those who look at it while a solver works.

    Where nobody looks (reading, compiling), and from the second signal on, KeyboardInterrupt.
    """
    asked, looked = False, -_WATCHED

    def ask(number: int, frame: object) -> None:
        nonlocal asked
        again, asked = asked, True
        if again or time.monotonic() - looked > _WATCHED:
            raise KeyboardInterrupt

    def look() -> bool:
        nonlocal looked
        looked = time.monotonic()
        signal.signal(signal.SIGINT, ask)  # CBC puts its own, deaf one in its place
        return asked

    before = {n: signal.signal(n, ask) for n in (signal.SIGINT, signal.SIGTERM)}
    kept = os.dup(1)  # CBC's output is muted by redirecting it, perhaps for ever
    try:
        yield look
    finally:
        os.dup2(kept, 1)
        os.close(kept)
        for number, handler in before.items():
            signal.signal(number, handler)


def leave(status: int) -> None:
    """End the process; at once, with its children, when a solver was left behind in its thread."""
    for number in (signal.SIGINT, signal.SIGTERM):  # the status stands: it is what was told
        signal.signal(number, signal.SIG_IGN)
    supervise = sys.modules.get("stlc.solve.supervise")  # not imported: nothing was solved
    if supervise is None or not supervise.left_behind():
        sys.exit(status)
    sys.stdout.flush()
    sys.stderr.flush()
    for child in _children():
        with suppress(ProcessLookupError):
            os.kill(child, signal.SIGKILL)
    os._exit(status)


def _children() -> list[int]:
    """Process ids of our children, where the system tells (Linux)."""
    lists = Path("/proc/self/task").glob("*/children")
    return [int(word) for path in lists for word in path.read_text().split()]
