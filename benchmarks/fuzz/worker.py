"""Runs commands in this process, one input after the other, and says how each went.

Lives in a process of its own (`pool.py`): memory peaks and CPU seconds are its own, and a crash
or a hang costs only this process.
"""

from __future__ import annotations

import os
import resource
import sys
import tempfile
import threading
import time
import traceback
from collections.abc import Iterator, Sequence
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass, field
from multiprocessing.connection import Connection
from pathlib import Path

MEMORY = 6 << 30  # bytes of address space: a monster ends as MemoryError, not with the machine
GROWN = 400 << 20  # bytes that a process may keep; the next input's peak would hold them too
CRASH = 70


@dataclass(frozen=True, slots=True)
class Ran:
    """One command's end: exit status, output, CPU seconds, peak memory [bytes]."""

    command: str
    status: int
    stdout: str = ""
    stderr: str = ""
    seconds: float = 0.0
    peak: int = 0
    where: str = ""  # innermost frame of ours, of an exception that came through
    words: tuple[str, ...] = field(default=())


def serve(pipe: Connection) -> None:
    """Folders and command lines in, `Ran` out, until the pipe closes. 'stale' asks for the end."""
    resource.setrlimit(resource.RLIMIT_AS, (MEMORY, MEMORY))
    os.environ["STLC_DEBUG"] = "1"
    while True:
        try:
            folder, words = pipe.recv()
        except EOFError:
            return
        os.chdir(folder)
        ran = run(tuple(words))
        left = threading.active_count() > 1  # a solver that was left behind
        pipe.send((ran, left or _memory("VmRSS") > GROWN))


def run(words: tuple[str, ...]) -> Ran:
    """One command line of `stlc`, its output caught at the file descriptors."""
    from stlc.cli import cli
    from stlc.cli.common import run_guarded

    _forget_peak()
    began, where = time.process_time(), ""
    sys.argv = ["stlc", *words]
    with tempfile.TemporaryDirectory() as folder:
        paths = [Path(folder) / name for name in ("stdout", "stderr")]
        with _caught(paths):
            try:
                status = run_guarded(cli)
            except Exception as error:
                status, where = CRASH, _place(error)
        texts = [path.read_bytes().decode("utf-8", "replace") for path in paths]
    spent = time.process_time() - began
    return Ran(words[0], status, *texts, spent, _memory("VmHWM"), where, words)


def _place(error: Exception) -> str:
    """`Type at stlc/file.py:function: message`."""
    frames = [f for f in traceback.extract_tb(error.__traceback__) if "stlc" in f.filename]
    last = frames[-1] if frames else None
    where = "?" if last is None else f"{'/'.join(last.filename.split('/')[-2:])}:{last.name}"
    return f"{type(error).__name__} at {where}: {str(error)[:200]}"


@contextmanager
def _caught(paths: Sequence[Path]) -> Iterator[None]:
    """Standard output and error go to files, of whatever writes to their descriptors too."""
    saved = [os.dup(fd) for fd in (1, 2)]
    with ExitStack() as stack:
        for fd, path in zip((1, 2), paths, strict=True):
            os.dup2(stack.enter_context(path.open("wb")).fileno(), fd)
        try:
            yield
        finally:
            sys.stdout.flush()
            sys.stderr.flush()
            for fd, kept in zip((1, 2), saved, strict=True):
                os.dup2(kept, fd)
                os.close(kept)


def _forget_peak() -> None:
    """From here on VmHWM counts anew (Linux)."""
    with open("/proc/self/clear_refs", "w") as file:
        file.write("5")


def _memory(what: str) -> int:
    """One of the kernel's counts of this process's memory [bytes]."""
    with open("/proc/self/status") as file:
        line = next(x for x in file if x.startswith(what))
    return int(line.split()[1]) * 1024
