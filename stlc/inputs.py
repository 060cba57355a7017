"""Reading files that people name: quickly, within limits, whatever they are; and what was read."""

from __future__ import annotations

import os
import select
import stat
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from contextvars import ContextVar
from pathlib import Path

from stlc.errors import UsageError

MOST_BYTES = 256 * 2**20
"""Of any input. Measured channels of 10^6 samples take 60 MB."""

STANDARD = "-"
"""The name of standard input."""

_PATIENCE = 10.0  # s without a byte from a pipe: nobody writes to it
_CHUNK = 1 << 20


class InputError(Exception):
    """A file that can't be read; `str(error)` says why, for people: 'there is no such file'."""


class TooLargeError(InputError):
    """It is larger than allowed: `size` [bytes], as far as it was read."""

    def __init__(self, size: int, most: int) -> None:
        super().__init__(f"is larger than {most // 2**20} MiB")
        self.size = size


def read_input(
    path: str | os.PathLike[str], most: int = MOST_BYTES, regular: bool = False
) -> bytes:
    """Content of a file of at most `most` bytes, or of what comes through a pipe; `-` is standard
    input, as often as it is asked for.

    Raises InputError within seconds for what is missing, unreadable, a folder, endless, too large
    or a pipe that nobody writes to; with `regular`, for all that is no ordinary file.
    """
    if os.fspath(path) == STANDARD:
        return _standard(most)
    try:
        descriptor = os.open(path, os.O_RDONLY | getattr(os, "O_NONBLOCK", 0))
    except FileNotFoundError:
        raise InputError("there is no such file") from None
    except (OSError, ValueError) as error:
        raise InputError(_text(error)) from None
    try:
        kind = os.fstat(descriptor)
        _check(kind, most, regular)
        _note(path, kind)
        return _read(descriptor, most)
    except OSError as error:
        raise InputError(_text(error)) from None
    finally:
        os.close(descriptor)


def check_input(path: str | os.PathLike[str]) -> None:
    """UsageError for a file that isn't there, or is a folder: a slip of the call, not the data."""
    if os.path.isdir(path):
        raise UsageError(f"{os.fspath(path)}: is a folder, not a file")
    if not os.path.exists(path):
        raise UsageError(f"{os.fspath(path)}: there is no such file")


def _standard(most: int) -> bytes:
    """Standard input, read once within `recorded_inputs`."""
    kept = _STANDARD.get()
    if kept:
        return kept[0]
    data = b"" if sys.stdin is None else sys.stdin.buffer.read(most + 1)
    if len(data) > most:
        raise TooLargeError(len(data), most)
    if kept is not None:
        kept.append(data)
    return data


def _check(kind: os.stat_result, most: int, regular: bool) -> None:
    if stat.S_ISDIR(kind.st_mode):
        raise InputError("is a folder, not a file")
    if regular and not stat.S_ISREG(kind.st_mode):
        raise InputError("is a pipe or a device, not a file")
    if kind.st_size > most:
        raise TooLargeError(kind.st_size, most)


def _read(descriptor: int, most: int) -> bytes:
    """Everything that comes, up to `most` bytes; a pipe may be silent for `_PATIENCE` seconds."""
    parts: list[bytes] = []
    size, heard = 0, time.monotonic()
    while True:
        try:
            part = os.read(descriptor, min(_CHUNK, most + 1 - size))
        except BlockingIOError:  # a pipe whose writer is at work
            part = None
        if part == b"" and (parts or not _may_come(descriptor)):
            return b"".join(parts)
        if part:
            parts.append(part)
            size, heard = size + len(part), time.monotonic()
        if size > most:
            raise TooLargeError(size, most)
        if not part:
            if time.monotonic() - heard > _PATIENCE:
                raise InputError("is a pipe that nobody writes to")
            select.select([descriptor], [], [], 0.1)
            time.sleep(0.01)


def _may_come(descriptor: int) -> bool:
    """Is it a named pipe that nobody has opened for writing yet? It reads as if at its end."""
    if not stat.S_ISFIFO(os.fstat(descriptor).st_mode):
        return False
    poll = select.poll()
    poll.register(descriptor, select.POLLIN)
    return not any(event & select.POLLHUP for _, event in poll.poll(0))


def _text(error: OSError | ValueError) -> str:
    return (error.strerror or str(error)) if isinstance(error, OSError) else str(error)


_STANDARD: ContextVar[list[bytes] | None] = ContextVar("standard", default=None)
_KNOWN: ContextVar[dict[tuple[int, int], str] | None] = ContextVar("inputs", default=None)


@contextmanager
def recorded_inputs() -> Iterator[None]:
    """Within the block, no output may take the place of a file that was read."""
    token, standard = _KNOWN.set({}), _STANDARD.set([])
    try:
        yield
    finally:
        _KNOWN.reset(token)
        _STANDARD.reset(standard)


def inputs_so_far() -> tuple[str, ...]:
    """Paths of the ordinary files read within `recorded_inputs`."""
    return tuple((_KNOWN.get() or {}).values())


def note_input(path: str | os.PathLike[str]) -> None:
    """Say that `path` is read, for readers that open files themselves."""
    if _KNOWN.get() is not None:
        with suppress(OSError, ValueError):
            _note(path, os.stat(path))


def _note(path: str | os.PathLike[str], kind: os.stat_result) -> None:
    known = _KNOWN.get()
    if known is not None and stat.S_ISREG(kind.st_mode):
        known[kind.st_dev, kind.st_ino] = os.fspath(path)


def refuse_input(target: Path) -> None:
    """UsageError when `target` is a file that was read, whatever path or link names it."""
    known = _KNOWN.get()
    if not known:
        return
    try:
        kind = target.stat()
    except (OSError, ValueError):  # it isn't there: nothing to overwrite
        return
    name = known.get((kind.st_dev, kind.st_ino))
    if name is not None:
        same = "" if name == str(target) else f" (as {name})"
        raise UsageError(f"{target} is an input{same}, which this would overwrite; name another")
