"""One racer in a process of its own: `python -m stlc.solve.racer`.

Reads a pickled `Task` from standard input, writes framed, pickled messages to standard output:
any number of `Progress`, then a `Certified`, or a `Failure`. When standard input ends, the race
is over (or its process gone) and so is this process with all its children.
"""

from __future__ import annotations

import os
import signal
import sys
import threading
from contextlib import suppress
from dataclasses import replace
from typing import IO

from stlc.solve.wire import Failure, Task, read_message, write_message


def main() -> None:
    """Solve one task."""
    # What solvers print on standard output must not get between the messages.
    output = os.fdopen(os.dup(1), "wb")
    os.dup2(2, 1)
    task = read_message(sys.stdin.buffer)
    if not isinstance(task, Task):
        return
    threading.Thread(target=_end_with_input, daemon=True).start()
    _limit_memory(task.memory)
    write_message(output, _answer(task, output))


def _answer(task: Task, output: IO[bytes]) -> object:
    from stlc import backends
    from stlc.errors import StlcError
    from stlc.solve.certify import certify

    def report(progress: object) -> None:
        write_message(output, progress)

    options = replace(task.options, on_progress=report)
    try:
        solution = backends.get(task.backend).solve(task.model, options)
        return certify(task.model, solution, options=options)
    except StlcError as error:
        return Failure(str(error))
    except MemoryError:
        return Failure("it ran out of memory")


def _end_with_input() -> None:
    sys.stdin.buffer.read()
    if hasattr(os, "killpg") and os.getpid() == os.getpgrp():
        with suppress(ProcessLookupError):
            os.killpg(0, signal.SIGKILL)
    os._exit(1)


def _limit_memory(limit: int | None) -> None:
    if limit is None:
        return
    try:
        import resource
    except ImportError:  # no such limits on this system: the race says so
        return
    resource.setrlimit(resource.RLIMIT_DATA, (limit, limit))


if __name__ == "__main__":
    main()
