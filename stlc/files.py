"""Writing files so that a failure leaves what was there before."""

from __future__ import annotations

import errno
import os
import secrets
import shutil
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import BinaryIO

from stlc.errors import OutputError

_REASONS = {
    errno.ENOSPC: "the disk is full",
    errno.EDQUOT: "the disk quota is used up",
    errno.EFBIG: "the file would be too large for this file system",
    errno.EACCES: "permission denied",
    errno.EPERM: "permission denied",
    errno.EROFS: "the file system is read-only",
    errno.ENAMETOOLONG: "the name is too long",
    errno.ENOTDIR: "part of its path is a file, not a folder",
    errno.EIO: "the device reported an error",
}


def write_atomic(path: str | os.PathLike[str], data: bytes | str) -> None:
    """Write `data` (text as UTF-8) to a temporary file beside `path`, then rename it.

    Raises OutputError with one clear sentence; an existing file is then unchanged.
    """
    with atomic_output(path) as stream:
        stream.write(data.encode() if isinstance(data, str) else data)


def check_writable(path: str | os.PathLike[str]) -> None:
    """OutputError when `path` cannot be written now; nothing is left behind."""
    target = Path(path)
    if target.exists() and not target.is_file() and not target.is_dir():
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


@contextmanager
def atomic_output(path: str | os.PathLike[str]) -> Iterator[BinaryIO]:
    """A binary stream whose contents become `path` when the block ends without an exception.

    Devices and pipes are written directly. Raises OutputError as `write_atomic` does.
    """
    target = Path(path)
    try:
        with _opened(target) as stream:
            yield stream
    except OSError as error:
        raise OutputError(f"cannot write {target}: {_reason(target, error)}") from error


@contextmanager
def _opened(target: Path) -> Iterator[BinaryIO]:
    if target.exists() and not target.is_file() and not target.is_dir():
        with target.open("wb") as stream:
            yield stream
        return
    final = Path(os.path.realpath(target))  # a symbolic link stays one
    if final.is_dir():
        raise IsADirectoryError(errno.EISDIR, "is a folder")
    temporary = final.with_name(f".stlc-{secrets.token_hex(8)}.tmp")
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


def _reason(target: Path, error: OSError) -> str:
    if error.errno == errno.EISDIR:
        return "it is a folder; name a file"
    if error.errno == errno.ENOENT:
        return f"the folder {target.parent} does not exist"
    return _REASONS.get(error.errno or 0, error.strerror or type(error).__name__)
