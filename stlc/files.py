"""Writing files so that a failure leaves what was there before."""

from __future__ import annotations

import errno
import os
import secrets
import shutil
import sys
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import BinaryIO

from stlc import guard
from stlc.errors import OutputError
from stlc.inputs import refuse_input

_REASONS = {
    errno.ENOSPC: "the disk is full",
    errno.EDQUOT: "the disk quota is used up",
    errno.EFBIG: "the file would be too large for this file system",
    errno.EACCES: "permission denied",
    errno.EPERM: "permission denied",
    errno.EROFS: "the file system is read-only",
    errno.ENAMETOOLONG: "the name is too long",
    errno.ENOTDIR: "part of its path is a file, not a folder",
    errno.EBADF: "it is closed",
    errno.EIO: "the device reported an error",
}


_STDOUT = ("/dev/stdout", "/dev/fd/1", "/proc/self/fd/1")


def real(path: str | os.PathLike[str]) -> Path:
    """The absolute path without symbolic links; one in a circle stays, and can't be read."""
    return Path(os.path.realpath(path))


def is_stream(path: str | os.PathLike[str]) -> bool:
    """Whether an output is a pipe or a device: what is written goes on, nothing takes its place."""
    target = Path(path)
    return target.exists() and not target.is_file() and not target.is_dir()


def write_atomic(
    path: str | os.PathLike[str], data: bytes | str, *, in_place: bool = False
) -> None:
    """Write `data` (text as UTF-8) to a temporary file beside `path`, then rename it.

    Raises OutputError with one clear sentence; an existing file is then unchanged. UsageError for
    a file that was read (`stlc.inputs.recorded_inputs`), unless it is changed `in_place`.
    """
    with atomic_output(path, in_place=in_place) as stream:
        stream.write(data.encode() if isinstance(data, str) else data)


def check_writable(path: str | os.PathLike[str]) -> None:
    """OutputError when `path` cannot be written now; nothing is left behind.

    UsageError for a file that was read (`stlc.inputs.recorded_inputs`).
    """
    target = Path(path)
    refuse_input(target)
    if is_stream(target):
        return
    final = Path(os.path.realpath(target))
    try:
        if final.is_dir():
            raise IsADirectoryError(errno.EISDIR, "is a folder")
        temporary = final.with_name(f".stlc-{secrets.token_hex(8)}.tmp")
        temporary.touch(exist_ok=False)
        temporary.unlink()
    except OSError as error:
        raise OutputError(f"cannot write {target}: {_reason(target, error)}") from error


_SCRATCH: set[Path] = set()  # temporary files and folders that are in use


@contextmanager
def scratch_folder() -> Iterator[Path]:
    """A temporary folder, gone when the block ends, the process leaves by `clear_scratch`, or (on
    Linux) it is killed; processes that work in it end then too."""
    folder = Path(tempfile.mkdtemp(prefix="stlc-"))
    _SCRATCH.add(folder)
    guard.watch(folder)
    try:
        yield folder
    finally:
        shutil.rmtree(folder, ignore_errors=True)
        guard.release(folder)
        _SCRATCH.discard(folder)


def clear_scratch() -> None:
    """Remove what is temporary, for a process that ends without unwinding."""
    for path in tuple(_SCRATCH):
        if path.is_dir():
            shutil.rmtree(path, ignore_errors=True)
        else:
            with suppress(OSError):
                path.unlink(missing_ok=True)


@contextmanager
def atomic_output(path: str | os.PathLike[str], *, in_place: bool = False) -> Iterator[BinaryIO]:
    """A binary stream whose contents become `path` when the block ends without an exception.

    Devices and pipes are written directly. Raises as `write_atomic` does.
    """
    target = Path(path)
    if not in_place:
        refuse_input(target)
    try:
        with _opened(target) as stream:
            yield stream
    except OSError as error:
        raise OutputError(f"cannot write {target}: {_reason(target, error)}") from error


@contextmanager
def _opened(target: Path) -> Iterator[BinaryIO]:
    """A stream whose bytes become `target` all at once at the end, or never.

    Standard output and devices are written as they come. The file keeps its permissions.
    """
    if str(target) in _STDOUT and hasattr(sys.stdout, "buffer"):
        yield sys.stdout.buffer  # descriptor 1 may be muted: a solver's library prints there
        sys.stdout.buffer.flush()
        return
    if is_stream(target):
        with target.open("wb") as stream:
            yield stream
        return
    final = Path(os.path.realpath(target))  # a symbolic link stays one
    if final.is_dir():
        raise IsADirectoryError(errno.EISDIR, "is a folder")
    temporary = final.with_name(f".stlc-{secrets.token_hex(8)}.tmp")
    _SCRATCH.add(temporary)
    try:
        with temporary.open("xb") as stream:
            yield stream
            stream.flush()
            os.fsync(stream.fileno())
        if final.exists():
            shutil.copymode(final, temporary)
        os.replace(temporary, final)
    finally:
        with suppress(OSError):
            temporary.unlink(missing_ok=True)
        _SCRATCH.discard(temporary)


def _reason(target: Path, error: OSError) -> str:
    if error.errno == errno.EISDIR:
        return "it is a folder; name a file"
    if error.errno == errno.ENOENT:
        return f"the folder {target.parent} does not exist"
    return reason(error)


def reason(error: OSError) -> str:
    """Why something could not be written, for people."""
    return _REASONS.get(error.errno or 0, error.strerror or type(error).__name__)
