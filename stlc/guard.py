"""A process that cleans up after this one where it is killed and can't (SIGKILL, out of memory).

The guard reads from a pipe which temporary folders we have. When our end closes it kills every
process that has one of them in its command line or works in it, such as a solver's command, and
removes them. It needs to see who works where, so there is one on Linux only. It is this very file,
run by itself with nothing but the standard library.
"""

from __future__ import annotations

import os
import signal
import sys
from contextlib import suppress
from pathlib import Path
from typing import BinaryIO

_pipes: dict[int, int] = {}  # process id -> our end; a fork has to have its own


def watch(folder: Path) -> None:
    """From now on the folder doesn't outlive this process, nor does a command that works in it."""
    _tell(b"+", folder, start=True)


def release(folder: Path) -> None:
    """The folder is gone."""
    _tell(b"-", folder, start=False)


def _tell(what: bytes, folder: Path, start: bool) -> None:
    if sys.platform != "linux" or not sys.executable:
        return
    with suppress(OSError):  # no process to spare, or the guard was killed: do without
        if start and os.getpid() not in _pipes:
            _pipes[os.getpid()] = _guard()
        if os.getpid() in _pipes:
            os.write(_pipes[os.getpid()], what + os.fsencode(folder) + b"\n")


def _guard() -> int:
    """Our end of the pipe to a new guard."""
    theirs, ours = os.pipe()
    null = os.open(os.devnull, os.O_WRONLY)
    ends = [(os.POSIX_SPAWN_DUP2, f, to) for f, to in ((theirs, 0), (null, 1), (null, 2))]
    words = [sys.executable, "-I", "-S", __file__]
    try:
        os.posix_spawn(sys.executable, words, os.environ, file_actions=ends, setsid=True)
    except OSError:
        os.close(ours)
        raise
    finally:
        os.close(theirs)
        os.close(null)
    return ours


def main(pipe: BinaryIO) -> None:
    """The guard: wait for the end of the pipe, then clean up."""
    for number in (signal.SIGHUP, signal.SIGINT, signal.SIGTERM):
        signal.signal(number, signal.SIG_IGN)
    folders: set[bytes] = set()
    for line in pipe:
        (folders.add if line.startswith(b"+") else folders.discard)(line[1:].rstrip(b"\n"))
    if folders:
        _end(folders)


def _end(folders: set[bytes]) -> None:
    import shutil

    for place in Path("/proc").glob("[0-9]*"):
        with suppress(OSError):
            words = (place / "cmdline").read_bytes() + os.fsencode((place / "cwd").readlink())
            if int(place.name) != os.getpid() and any(folder in words for folder in folders):
                os.kill(int(place.name), signal.SIGKILL)
    for folder in folders:
        shutil.rmtree(folder, ignore_errors=True)


if __name__ == "__main__":
    main(sys.stdin.buffer)
