"""What LP and MPS share: the model as a file can say it.

Free rows are left out (they constrain nothing, and readers disagree on them). The objective's
constant becomes a column fixed at 1. Rows that the format cannot state exactly are split in two,
the second named `NAME.upper`.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, TypeAlias

import numpy as np
from numpy.typing import NDArray

from stlc.arrays import Floats
from stlc.errors import OutputError
from stlc.milp.model import Model
from stlc.milp.writers.names import Texts

if TYPE_CHECKING:
    from scipy.sparse import csr_matrix

CONSTANT = "objective.constant"
UPPER = ".upper"

Mask: TypeAlias = NDArray[np.bool_]


@dataclass(frozen=True, slots=True, eq=False)
class FileForm:
    """Columns, rows and coefficients as written. n columns, m rows; A is CSR (m, n)."""

    name: str
    columns: Texts  # (n,)
    rows: Texts  # (m,)
    c: Floats
    A: csr_matrix
    row_lower: Floats
    row_upper: Floats
    col_lower: Floats
    col_upper: Floats
    integer: Mask


def file_form(model: Model, columns: Texts, rows: Texts, split: Mask) -> FileForm:
    """The model with its free rows dropped and the rows of `split` (m,) halved.

    Raises OutputError when a coefficient is not finite.
    """
    if not (np.isfinite(model.A.data).all() and np.isfinite(model.c).all()):
        raise OutputError(f"the model '{model.name}' has a coefficient that is not finite")
    free = np.isneginf(model.row_lower) & np.isposinf(model.row_upper)
    kept = np.repeat(np.arange(model.rows), np.where(free, 0, np.where(split & ~free, 2, 1)))
    second = np.concatenate([[False], kept[1:] == kept[:-1]]) if len(kept) else kept.astype(bool)
    first = np.concatenate([second[1:], [False]]) if len(kept) else second
    names = rows[kept]
    if second.any():
        names = np.char.add(names, np.where(second, UPPER.encode(), b""))
    extra = int(model.offset != 0 or model.columns == 0)
    one = np.ones(extra)
    return FileForm(
        model.name,
        np.concatenate([columns, np.array([CONSTANT.encode()] * extra, dtype=bytes)]),
        names,
        np.concatenate([model.c, one * model.offset]),
        _widened(model.A if len(kept) == model.rows and not second.any() else model.A[kept], extra),
        np.where(second, -np.inf, model.row_lower[kept]),
        np.where(first, np.inf, model.row_upper[kept]),
        np.concatenate([model.col_lower, one]),
        np.concatenate([model.col_upper, one]),
        np.concatenate([model.integrality.astype(bool), np.zeros(extra, dtype=bool)]),
    )


def _widened(A: csr_matrix, extra: int) -> csr_matrix:
    from scipy.sparse import csr_matrix

    rows, columns = A.shape
    return csr_matrix((A.data, A.indices, A.indptr), shape=(rows, columns + extra))


def number_texts(values: Floats, *, signed: bool = False) -> Texts:
    """Shortest texts that read back as the same doubles, bit for bit ('-0.0' as '0').

    `signed` puts '+' before positive ones. Few values are distinct in a compiled model, so each
    distinct one is formatted once.
    """
    if not len(values):
        return np.empty(0, dtype="S1")
    distinct, place = np.unique(values + 0.0, return_inverse=True)
    form = _signed if signed else _short
    return np.array([form(v) for v in distinct.tolist()], dtype=bytes)[place]


def _short(value: float) -> str:
    text = repr(value)
    return text[:-2] if text.endswith(".0") else text


def _signed(value: float) -> str:
    return _short(value) if value < 0 else f"+{_short(value)}"


def lines(*fields: Texts | bytes) -> bytes:
    """Rows of text, one a position of the arrays; constant fields repeat. Fields are not padded.

    Records of fixed width are filled column by column (as fast as copying), then the padding,
    which is NUL, is deleted.
    """
    size = max((len(f) for f in fields if not isinstance(f, bytes)), default=0)
    kinds = [np.dtype(f"S{len(f)}") if isinstance(f, bytes) else f.dtype for f in fields]
    records = np.empty(size, dtype=[(f"f{k}", kind) for k, kind in enumerate(kinds)])
    for k, field in enumerate(fields):
        records[f"f{k}"] = field
    return records.tobytes().translate(None, b"\0")
