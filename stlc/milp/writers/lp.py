"""CPLEX LP in the dialect that HiGHS, CBC, GLPK, SCIP, lp_solve and Gurobi read alike.

Always minimised; two-sided rows are split; every bound is written; `Binaries` and `Generals` in
full (other readers take the `bin` of HiGHS's own writer for a column); a space between
coefficient and name; coefficients that read back bit for bit.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
from numpy.typing import NDArray

from stlc.arrays import Floats, Ints
from stlc.milp.model import Model
from stlc.milp.writers.form import FileForm, file_form, lines, number_texts
from stlc.milp.writers.names import Texts

_PER_LINE = 3  # terms: 3 x (100 + 25) characters stay below the limits of all readers
_CHUNK = 1 << 15  # rows formatted at a time


def lp_chunks(model: Model, columns: Texts, rows: Texts) -> Iterator[bytes]:
    """The file piece by piece. Raises OutputError when a coefficient is not finite."""
    low, high = model.row_lower, model.row_upper
    form = file_form(model, columns, rows, np.isfinite(low) & np.isfinite(high) & (low != high))
    yield f"\\ {form.name}\nMinimize\n".encode()
    yield _objective(form)
    yield b"Subject To\n"
    # GLPK wants a row; a zero coefficient is the only one that says nothing.
    yield from _rows(form) if len(form.rows) else [b" no.rows: 0 " + form.columns[0] + b" <= 0\n"]
    yield b"Bounds\n"
    yield from _bounds(form)
    binary = form.integer & (form.col_lower == 0) & (form.col_upper == 1)
    yield from _section(b"Binaries\n", form.columns[binary])
    yield from _section(b"Generals\n", form.columns[form.integer & ~binary])
    yield b"End\n"


def _objective(form: FileForm) -> bytes:
    """Every column, those that cost nothing too: readers number them as they meet them, and the
    solution files of GLPK and HiGHS that have numbers for names then count as the model does."""
    label = np.array([b" COST:\n", *[b""] * (len(form.c) - 1)])
    tail = np.array([*[b"\n"] * len(form.c)])
    return lines(label, b" ", number_texts(form.c, signed=True), b" ", form.columns, tail)


def _rows(form: FileForm) -> Iterator[bytes]:
    """Lines of all rows, a chunk at a time."""
    A = form.A
    side = np.where(np.isfinite(form.row_lower), form.row_lower, form.row_upper)
    sense = np.where(np.isfinite(form.row_lower), b" >= ", b" <= ").astype("S4")
    sense[form.row_lower == form.row_upper] = b" = "
    right = number_texts(side)
    for a in range(0, len(side), _CHUNK):
        part = slice(a, min(a + _CHUNK, len(side)))
        starts = A.indptr[part.start : part.stop + 1].astype(np.int64)
        inner = slice(starts[0], starts[-1])
        yield _block(
            form, form.rows[part], sense[part], right[part],
            starts - starts[0], A.indices[inner], A.data[inner],
        )  # fmt: skip


def _block(
    form: FileForm,
    names: Texts,
    sense: Texts,
    right: Texts,
    starts: Ints,
    indices: NDArray[np.integer[Any]],
    data: Floats,
) -> bytes:
    """Rows with at least one term each: an empty one gets a zero term."""
    counts = np.diff(starts)
    empty = counts == 0
    if empty.any():
        at = starts[:-1][empty]
        indices, data = np.insert(indices, at, 0), np.insert(data, at, 0.0)
        counts = np.where(empty, 1, counts)
        starts = np.concatenate([[0], np.cumsum(counts)])
    size = int(starts[-1])
    first, last = starts[:-1], starts[1:] - 1
    label = np.zeros(size, dtype=names.dtype)
    label[first] = names
    open_, colon = np.zeros(size, dtype="S1"), np.zeros(size, dtype="S1")
    open_[first], colon[first] = b" ", b":"
    relation, value = np.zeros(size, dtype="S4"), np.zeros(size, dtype=right.dtype)
    relation[last], value[last] = sense, right
    place = np.arange(size) - np.repeat(first, counts)
    broken = place % _PER_LINE == _PER_LINE - 1
    broken[last] = True
    ends = np.where(broken, b"\n", b"").astype("S1")
    return lines(
        open_, label, colon, b" ", number_texts(data, signed=True), b" ",
        form.columns[indices], relation, value, ends,
    )  # fmt: skip


def _bounds(form: FileForm) -> Iterator[bytes]:
    """Lines of all bounds: fixed, free, or both ends, infinite ones spelt out."""
    low, high = form.col_lower, form.col_upper
    below, above = np.isfinite(low), np.isfinite(high)
    first = number_texts(np.where(below, low, 0.0)).astype("S25")
    first[~below] = b"-inf"
    second = number_texts(np.where(above, high, 0.0)).astype("S25")
    second[~above] = b"+inf"
    fixed, free = low == high, ~below & ~above
    first[fixed | free] = b""
    second[free] = b""
    left = np.where(fixed | free, b"", b" <= ").astype("S4")
    middle = np.where(fixed, b" = ", np.where(free, b" free", b" <= ")).astype("S5")
    yield lines(b" ", first, left, form.columns, middle, second, b"\n")


def _section(heading: bytes, names: Texts) -> Iterator[bytes]:
    if len(names):
        yield heading
        yield lines(b" ", names, b"\n")
