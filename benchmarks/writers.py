"""Time to write LP and MPS beside HiGHS's own writer, in the same run, on one model.

    python benchmarks/writers.py [--repeat N]

CPU seconds, best of N. The model has 75,000 columns, 289,000 rows and 940,000 nonzeros
(`lit_model.py`); both writers get the same names. Exactness is counted by reading each file back.
"""

from __future__ import annotations

import argparse
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from lit_model import lit_model

from stlc.milp.model import Model
from stlc.milp.writers import safe_names, write_model


def cpu_seconds(work: Callable[[], object], repeat: int) -> float:
    """Best of `repeat`."""
    times = []
    for _ in range(repeat):
        began = time.process_time()
        work()
        times.append(time.process_time() - began)
    return min(times)


def loaded(model: Model) -> Any:
    """The model in HiGHS, with our names."""
    import highspy

    h, A = highspy.Highs(), model.A
    h.setOptionValue("output_flag", False)
    h.passModel(
        model.columns, model.rows, A.nnz, int(highspy.MatrixFormat.kRowwise), 1, model.offset,
        model.c, model.col_lower, model.col_upper, model.row_lower, model.row_upper,
        A.indptr.astype(np.int32), A.indices.astype(np.int32), A.data,
        model.integrality.astype(np.int32),
    )  # fmt: skip
    columns, rows = safe_names(model)
    for j, name in enumerate(columns):
        h.passColName(j, name)
    for i, name in enumerate(rows):
        h.passRowName(i, name)
    return h


def changed_numbers(model: Model, path: Path) -> int:
    """How many coefficients and costs differ, bit for bit, after HiGHS has read the file."""
    import highspy
    from scipy.sparse import csc_matrix

    h = highspy.Highs()
    h.setOptionValue("output_flag", False)
    h.readModel(str(path))
    lp = h.getLp()
    m = lp.a_matrix_
    read = csc_matrix((m.value_, m.index_, m.start_), shape=(lp.num_row_, lp.num_col_)).tocsr()
    place = {name: j for j, name in enumerate(lp.col_names_)}
    order = [place[name] for name in safe_names(model)[0]]
    read = read[:, order]
    read.sort_indices()
    costs = np.array(lp.col_cost_)[order] != model.c
    return int((read.data != model.A.data).sum() + costs.sum())


def main() -> None:
    """Print one table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--repeat", type=int, default=5)
    repeat = parser.parse_args().repeat
    model = lit_model()
    h = loaded(model)
    print(f"{model.columns} columns, {model.rows} rows, {model.nonzeros} nonzeros")
    print(
        f"{'format':8} {'stlc s':>8} {'HiGHS s':>8} {'ratio':>6} {'changed: stlc':>14} {'HiGHS':>8}"
    )
    with tempfile.TemporaryDirectory() as folder:
        for suffix in ("mps", "lp"):
            own, other = (Path(folder) / f"{who}.{suffix}" for who in ("own", "highs"))
            a = cpu_seconds(lambda path=own: write_model(model, path), repeat)
            b = cpu_seconds(lambda path=other: h.writeModel(str(path)), repeat)
            wrong = changed_numbers(model, own), changed_numbers(model, other)
            print(f"{suffix:8} {a:8.3f} {b:8.3f} {b / a:6.2f} {wrong[0]:14d} {wrong[1]:8d}")
        packed = Path(folder) / "own.mps.gz"
        print(f"{'mps.gz':8} {cpu_seconds(lambda: write_model(model, packed), 1):8.3f}")


if __name__ == "__main__":
    main()
