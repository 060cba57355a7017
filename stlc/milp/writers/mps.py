"""Free MPS in the dialect that HiGHS, CBC, GLPK, SCIP, lp_solve and Gurobi read alike.

`NAME x FREE`, no OBJSENSE (always minimised), integers between MARKERs with every bound written,
RANGES for two-sided rows, infinite bounds by keyword, coefficients that read back bit for bit.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from stlc.arrays import Ints
from stlc.milp.model import Model
from stlc.milp.writers.form import FileForm, Mask, file_form, lines, number_texts
from stlc.milp.writers.names import Texts

_COST = "COST"
_CHUNK = 1 << 17  # entries formatted at a time


def mps_bytes(model: Model, columns: Texts, rows: Texts) -> bytes:
    """The whole file."""
    return b"".join(mps_chunks(model, columns, rows))


def mps_chunks(model: Model, columns: Texts, rows: Texts) -> Iterator[bytes]:
    """The file piece by piece. Raises OutputError when a coefficient is not finite."""
    form = file_form(model, columns, rows, ~_exact_range(model))
    yield f"NAME {form.name} FREE\nROWS\n N {_COST}\n".encode()
    yield lines(b" ", _kinds(form), b" ", form.rows, b"\n")
    yield b"COLUMNS\n"
    yield from _columns(form)
    yield b"RHS\n"
    yield from _right_hand_sides(form)
    yield from _ranges(form)
    yield b"BOUNDS\n"
    yield from _bounds(form)
    yield b"ENDATA\n"


def _exact_range(model: Model) -> Mask:
    """Rows that one right-hand side and one range state exactly (most of them)."""
    low, high = model.row_lower, model.row_upper
    with np.errstate(invalid="ignore"):
        exact = low + (high - low) == high
    whole: Mask = exact | ~np.isfinite(low) | ~np.isfinite(high) | (low == high)
    return whole


def _kinds(form: FileForm) -> Texts:
    kinds = np.where(np.isfinite(form.row_lower), b"G", b"L").astype("S1")
    kinds[form.row_lower == form.row_upper] = b"E"
    return kinds


def _columns(form: FileForm) -> Iterator[bytes]:
    """Lines of all entries by column, runs of integers between their markers, a chunk at a time."""
    starts, row, column, value = _entries(form)
    names = np.concatenate([np.array([_COST], dtype=bytes), form.rows])
    edges = np.flatnonzero(np.diff(form.integer.astype(np.int8), prepend=0, append=0))
    cuts = np.concatenate([[0], edges, [len(form.c)]])
    for run, (first, last) in enumerate(zip(cuts[:-1].tolist(), cuts[1:].tolist(), strict=True)):
        if first == last:
            continue
        integer = run % 2 == 1
        if integer:
            yield f" M{run} 'MARKER' 'INTORG'\n".encode()
        for a in range(starts[first], starts[last], _CHUNK):
            part = slice(a, min(a + _CHUNK, starts[last]))
            yield lines(
                b" ", form.columns[column[part]], b" ", names[row[part]], b" ", value[part], b"\n"
            )
        if integer:
            yield f" M{run} 'MARKER' 'INTEND'\n".encode()


def _entries(form: FileForm) -> tuple[Ints, Ints, Ints, Texts]:
    """Column starts (n+1,), then row (0 is the objective), column and text of every entry.

    A column with no entry at all gets a zero cost, so that it is declared.
    """
    A = form.A.tocsc()
    counts = np.diff(A.indptr)
    stated = (form.c != 0) | (counts == 0)
    before = np.cumsum(stated)
    starts = A.indptr + np.concatenate([[0], before])
    row = np.zeros(int(starts[-1]), dtype=np.int64)
    value = np.empty(int(starts[-1]))
    column = np.repeat(np.arange(len(counts)), np.diff(starts))
    inner = np.arange(A.nnz) + np.repeat(before, counts)
    row[inner], value[inner] = A.indices + 1, A.data
    value[starts[:-1][stated]] = form.c[stated]
    return starts, row, column, number_texts(value)


def _right_hand_sides(form: FileForm) -> Iterator[bytes]:
    side = np.where(np.isfinite(form.row_lower), form.row_lower, form.row_upper)
    stated = side != 0
    yield lines(b" RHS ", form.rows[stated], b" ", number_texts(side[stated]), b"\n")


def _ranges(form: FileForm) -> Iterator[bytes]:
    low, high = form.row_lower, form.row_upper
    ranged = np.isfinite(low) & np.isfinite(high) & (low != high)
    if not ranged.any():
        return
    yield b"RANGES\n"
    width = number_texts(high[ranged] - low[ranged])
    yield lines(b" RNG ", form.rows[ranged], b" ", width, b"\n")


def _bounds(form: FileForm) -> Iterator[bytes]:
    """Both bounds of every column, in its own two lines, lower first."""
    low, high = form.col_lower, form.col_upper
    below, above = np.isfinite(low), np.isfinite(high)
    fixed = low == high
    kind = np.where(below, b"LO", b"MI").astype("S2")
    kind[fixed] = b"FX"
    kind[~below & ~above] = b"FR"
    first = number_texts(np.where(below, low, 0.0))
    first[~below] = b""
    second = number_texts(np.where(above, high, 0.0))
    second[~above] = b""
    both = ~fixed & (below | above)
    tail = np.where(above, b" UP BND ", b" PL BND ").astype("S8")
    tail[~both] = b""
    again = form.columns.copy()
    again[~both] = b""
    second[~both] = b""
    gap, end = np.where(both, b" ", b"").astype("S1"), np.where(both, b"\n", b"").astype("S1")
    yield lines(
        b" ", kind, b" BND ", form.columns, b" ", first, b"\n",
        tail, again, gap, second, end,
    )  # fmt: skip
