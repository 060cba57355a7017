"""Standard streams of the command: what it prints arrives whole, or its exit status says not.

A reader that leaves early (`| head`) is no error: the status stays that of the command. Any other
failure to write standard output (disk full, closed) is exit 74. Descriptor 1 itself is given away,
so that whatever a solver's library prints there, at any time, in any thread, is not in the output.
"""

from __future__ import annotations

import io
import os
import sys
from contextlib import suppress
from dataclasses import dataclass
from typing import TYPE_CHECKING, TextIO

from stlc.errors import OutputError
from stlc.files import reason

if TYPE_CHECKING:
    from _typeshed import ReadableBuffer


class _Descriptor(io.RawIOBase):
    """Writes to a descriptor until that fails; after that, what is written is dropped."""

    def __init__(self, descriptor: int, aloud: bool) -> None:
        self._descriptor = descriptor
        self._aloud = aloud
        self.error: OutputError | None = None
        self._gone = False

    def writable(self) -> bool:
        return True

    def fileno(self) -> int:
        return self._descriptor

    def isatty(self) -> bool:
        return os.isatty(self._descriptor)

    def write(self, data: ReadableBuffer, /) -> int:
        """Writes, or drops what nobody can read any more: a reader that left is no error."""
        size = memoryview(data).nbytes
        if self._gone:
            return size
        try:
            return os.write(self._descriptor, data)
        except OSError as error:
            self._gone = True
            if self._aloud and not isinstance(error, BrokenPipeError):
                self.error = OutputError(f"cannot write standard output: {reason(error)}")
                raise self.error from error
            return size


@dataclass(frozen=True, slots=True)
class Streams:
    """Our own standard output and error."""

    out: _Descriptor

    def close(self, status: int) -> int:
        """Flush; the exit status, which says so when output was lost."""
        from stlc.cli.common import complain

        with suppress(OutputError):
            sys.stdout.flush()
        if self.out.error is not None and status != OutputError.exit_status:
            complain(str(self.out.error))
            status = OutputError.exit_status
        sys.stderr.flush()
        return status


def claim_streams() -> Streams:
    """Take standard output and error over; descriptor 1 goes to nowhere from now on."""
    _open_closed()
    out = _Descriptor(os.dup(1), aloud=True)
    nowhere = os.open(os.devnull, os.O_WRONLY)
    os.dup2(nowhere, 1)
    os.close(nowhere)
    sys.stdout = _text(out)
    sys.stderr = _text(_Descriptor(2, aloud=False))
    return Streams(out)


def _open_closed() -> None:
    """Give closed standard descriptors a stand-in, or the next file opened would become one.

    Reading ends at once; writing standard output fails, as it should.
    """
    for number, mode in ((0, os.O_RDONLY), (1, os.O_RDONLY), (2, os.O_WRONLY)):
        try:
            os.fstat(number)
        except OSError:
            os.open(os.devnull, mode)  # takes the lowest number that is free: this one
    if sys.stdin is None:
        sys.stdin = io.TextIOWrapper(io.FileIO(0, closefd=False))


def _text(raw: _Descriptor) -> TextIO:
    """UTF-8, with what it can't hold (names of files that aren't UTF-8) in escapes."""
    buffered = io.BufferedWriter(raw)
    return io.TextIOWrapper(
        buffered, encoding="utf-8", errors="backslashreplace", line_buffering=raw.isatty()
    )
