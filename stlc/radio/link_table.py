"""Reader of link tables: one value for each pair of cells, from CSV or NPZ."""

from __future__ import annotations

import io
import math
import zipfile
import zlib
from collections.abc import Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from stlc.radio.content import read_content, read_packed
from stlc.radio.errors import DataError, DataLocation
from stlc.radio.sheet import read_sheet

Array = NDArray[np.float64]


def read_table(path: str | Path, name: str | None = None) -> Array:
    """Values (na, nb) from a CSV without header, or from one array of an NPZ (never pickled).

    Raises DataError with file, line and column; `name` picks the array when there are several.
    """
    location = Path(path)
    if location.suffix.lower() == ".npz":
        return _read_npz(location, name)
    sheet = read_sheet(location)
    if not sheet.rows:
        raise DataError("the file is empty", DataLocation(str(path)))
    sheet.check_width(len(sheet.rows[0][1]), "first line has")
    return np.array(
        [[sheet.number(cell, line, c) for c, cell in enumerate(row)] for line, row in sheet.rows]
    )


def _read_npz(path: Path, name: str | None) -> Array:
    """One array of an archive, finite numbers in one or two axes; DataError otherwise."""
    where, values = DataLocation(str(path)), read_array(path, name)
    if values.ndim not in (1, 2):
        text = f"array of shape {values.shape} and type {values.dtype}"
        raise DataError(text, where, "expected one or two axes of numbers")
    return np.asarray(np.atleast_2d(values))


def names_in(path: Path) -> tuple[str, ...]:
    """Names of the arrays in an archive. Raises DataError."""
    where = DataLocation(str(path))
    try:
        with zipfile.ZipFile(io.BytesIO(read_content(path))) as archive:
            return tuple(m.removesuffix(".npy") for m in archive.namelist())
    except (OSError, ValueError, NotImplementedError, zipfile.BadZipFile) as error:
        raise DataError(f"cannot read the file: {error}", where) from error


def read_array(path: Path, name: str | None = None) -> Array:
    """One array of an NPZ (never pickled): finite numbers in any number of axes. Raises
    DataError."""
    where = DataLocation(str(path))
    data = read_content(path)
    if data[:6] == b"\x93NUMPY":
        raise DataError("this is one array (.npy), not an archive", where, "use numpy.savez")
    try:
        with zipfile.ZipFile(io.BytesIO(data)) as archive:
            values = _member(archive, _choice(archive.namelist(), name, where), where)
    except DataError:
        raise
    except (OSError, EOFError, ValueError, KeyError, NotImplementedError, RuntimeError,
            zipfile.BadZipFile, zlib.error) as error:  # fmt: skip
        raise DataError(f"cannot read the file: {error}", where) from error
    if values.dtype.kind not in "fiu":
        text = f"array of shape {values.shape} and type {values.dtype}"
        raise DataError(text, where, "expected one or two axes of numbers")
    found = np.asarray(values.astype(np.float64))
    if not np.isfinite(found).all():
        raise DataError("the table holds values that are not finite", where)
    return found


def _choice(members: Sequence[str], name: str | None, where: DataLocation) -> str:
    """The member that is meant; `name` goes without the ending .npy."""
    names = [m.removesuffix(".npy") for m in members]
    if name is None and len(names) != 1:
        raise DataError(f"{len(names)} arrays in the file: {', '.join(names)}", where)
    if name is not None and name not in names:
        raise DataError(f"no array {name!r}; there are: {', '.join(names)}", where)
    return members[0 if name is None else names.index(name)]


def _member(archive: zipfile.ZipFile, member: str, where: DataLocation) -> Array:
    """One array, unpacked only as far as it may go: a header can claim any size."""
    with archive.open(member) as packed:
        data = read_packed(packed, member, where)
    stream = io.BytesIO(data)
    version = np.lib.format.read_magic(stream)
    read = (
        np.lib.format.read_array_header_1_0
        if version == (1, 0)
        else (np.lib.format.read_array_header_2_0)
    )
    shape, _, kind = read(stream)
    if kind.hasobject:
        raise DataError("the array holds pickled objects, which are never read", where)
    claimed = math.prod(shape) * kind.itemsize
    if claimed > len(data) - stream.tell():
        problem = f"the array claims {claimed} bytes, the file holds {len(data) - stream.tell()}"
        raise DataError(problem, where)
    stream.seek(0)
    return np.lib.format.read_array(stream, allow_pickle=False)
