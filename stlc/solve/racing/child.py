"""A spawned process that takes one task and answers with messages: both ends of it.

Never forked: HiGHS does not survive a fork. The child watches its standard input, so that it ends
with whoever started it, however that one ended.
"""

from __future__ import annotations

import os
import shutil
import signal
import subprocess
import sys
import tempfile
import threading
from collections.abc import Callable
from contextlib import ExitStack, suppress
from pathlib import Path
from typing import IO, cast

from stlc.errors import SolverError
from stlc.files import scratch_folder
from stlc.solve.deadline import Stopwatch
from stlc.solve.racing.messages import read_message, write_message


class Child:
    """`python -m module` at work on `task`; `tell(message)` is called from a thread of ours.

    The last call is `tell(None)`, when the process has no more to say. `memory` [bytes] is what
    the task limits it to, for messages only.
    """

    def __init__(
        self, module: str, name: str, task: object, tell: Callable[[object | None], None],
        memory: int | None = None,
    ) -> None:  # fmt: skip
        self._memory = memory
        self._watch = Stopwatch()
        self._errors = tempfile.TemporaryFile()  # noqa: SIM115 (closed in `end`)
        self._kept = ExitStack()
        folder = self._kept.enter_context(scratch_folder())
        try:
            self._process = subprocess.Popen(
                [sys.executable, "-m", module],
                stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=self._errors,
                start_new_session=True, env={**os.environ, "TMPDIR": str(folder)},
            )  # fmt: skip
        except OSError as error:
            self._kept.close()
            raise SolverError(f"cannot start {name}: {error.strerror}") from error
        self._reader = threading.Thread(target=self._talk, args=(task, tell), daemon=True)
        self._reader.start()

    def _talk(self, task: object, tell: Callable[[object | None], None]) -> None:
        try:
            write_message(cast("IO[bytes]", self._process.stdin), task)
            output = cast("IO[bytes]", self._process.stdout)
            while (message := read_message(output)) is not None:
                tell(message)
        except (BrokenPipeError, ValueError):  # it died, or was ended while we read
            pass
        tell(None)

    @property
    def pid(self) -> int:
        """Its id."""
        return self._process.pid

    def send(self, task: object) -> None:
        """Give one more task to a process that takes several; nothing where it has died, which
        `tell` hears of."""
        with suppress(BrokenPipeError, ValueError):
            write_message(cast("IO[bytes]", self._process.stdin), task)

    def seconds(self) -> float:
        """Since its start."""
        return self._watch.seconds

    def why(self) -> str:
        """Why the process ended without an answer."""
        code = self._process.wait()
        self._errors.seek(0)
        said = self._errors.read().decode(errors="replace").strip().splitlines()
        cause = f"signal {-code}" if code < 0 else f"status {code}"
        memory = self._memory
        hint = "" if memory is None else f" (its memory was limited to {memory / 2**20:.0f} MB)"
        return f"its process ended with {cause}{hint}" + (f": {said[-1]}" if said else "")

    def end(self) -> None:
        """End the process and its children, and remove what they left in their folder."""
        if self._process.poll() is None:
            _signal(self._process, signal.SIGTERM)
            try:
                self._process.wait(1.0)
            except subprocess.TimeoutExpired:
                _signal(self._process, signal.SIGKILL)
                self._process.wait()
        with suppress(ProcessLookupError):  # children of one that died by itself
            _signal(self._process, signal.SIGKILL)
        self._reader.join(5.0)
        for stream in (self._process.stdin, self._process.stdout):
            if stream is not None:
                _close(stream)
        self._errors.close()
        self._kept.close()


def _signal(process: subprocess.Popen[bytes], number: signal.Signals) -> None:
    if hasattr(os, "killpg"):
        os.killpg(process.pid, number)
    else:
        process.terminate()


def _close(stream: IO[bytes]) -> None:
    try:
        stream.close()
    except BrokenPipeError:
        return  # it never read the rest of its task


def private_output() -> IO[bytes]:
    """In the child: the pipe to the parent; what solvers print goes to standard error instead."""
    output = os.fdopen(os.dup(1), "wb")
    os.dup2(2, 1)
    return output


def end_with_input() -> None:
    """In the child, once the task is read: when standard input ends, so do we and our children."""
    threading.Thread(target=_watch_input, daemon=True).start()


def _watch_input() -> None:
    """End this process, and all that it started, when its parent has gone: end of file on input."""
    # Not sys.stdin: its lock, held by a daemon thread, would abort an interpreter that ends.
    while os.read(0, 1 << 16):
        continue
    leave()


def leave() -> None:
    """In the child: end this process with all that it started, and remove its folder."""
    own = Path(tempfile.gettempdir())
    if own.name.startswith("stlc-"):  # made for us by one that is gone
        shutil.rmtree(own, ignore_errors=True)
    if hasattr(os, "killpg") and os.getpid() == os.getpgrp():
        with suppress(ProcessLookupError):
            os.killpg(0, signal.SIGKILL)
    os._exit(1)


def limit_memory(limit: int | None) -> None:
    """In the child: at most `limit` bytes of data."""
    if limit is None:
        return
    try:
        import resource
    except ImportError:  # no such limits on this system: whoever started us says so
        return
    resource.setrlimit(resource.RLIMIT_DATA, (limit, limit))
