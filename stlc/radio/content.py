"""Content of data files, unpacked no further than an input may go."""

from __future__ import annotations

import gzip
import io
import zlib
from pathlib import Path
from typing import IO

from stlc.inputs import MOST_BYTES, InputError, read_input
from stlc.radio.errors import DataError, DataLocation


def read_content(path: Path) -> bytes:
    """The bytes of a file. Raises DataError."""
    try:
        return read_input(path)
    except InputError as error:
        raise DataError(f"cannot read the file: {error}", DataLocation(str(path))) from None


def read_text(path: Path) -> str:
    """A UTF-8 text, optionally gzipped. Raises DataError."""
    raw, where = read_content(path), DataLocation(str(path))
    try:
        return (_gunzip(raw, where) if raw[:2] == b"\x1f\x8b" else raw).decode("utf-8-sig")
    except UnicodeDecodeError as error:
        raise DataError("this is not a text file", where, "expected a UTF-8 CSV") from error
    except (OSError, EOFError, zlib.error) as error:
        raise DataError(f"cannot unpack the file: {error}", where) from error


def _gunzip(raw: bytes, where: DataLocation) -> bytes:
    with gzip.GzipFile(fileobj=io.BytesIO(raw)) as packed:
        return read_packed(packed, "it", where)


def read_packed(packed: IO[bytes] | gzip.GzipFile, what: str, where: DataLocation) -> bytes:
    """No more than an input may have: a few kilobytes can unpack to gigabytes."""
    data = packed.read(MOST_BYTES + 1)
    if len(data) > MOST_BYTES:
        raise DataError(f"{what} unpacks to more than {MOST_BYTES // 2**20} MiB", where)
    return data
