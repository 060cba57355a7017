"""Models of stlpy that maximise robustness, made over into ones that minimise effort.

    python benchmarks/peer_effort.py FROM TO

For each `FROM/PROBLEM__NAME.mps[.xz|.gz]`, `TO/frugal_PROBLEM__NAME.mps.gz` holds the same rows
with robustness at least 0 and the least sum of |u| over all inputs instead: what the suite `long`
asks of the same scenarios, so that `stlc bench long --peer TO` solves both in one run. Inputs are
the columns between -0.5 and 0.5, which nothing else is in these scenarios; robustness is what is
maximised.
"""

from __future__ import annotations

import argparse
from dataclasses import replace
from pathlib import Path

import numpy as np

from stlc.arrays import Ints
from stlc.bench.peer import model_of
from stlc.milp.model import Block, Model, Origin
from stlc.milp.writers import write_model

_PUSH = 0.5  # every scenario's bound on inputs


def frugal(model: Model) -> Model:
    """The model with a column e >= |u| for each input u, and their sum to minimise."""
    from scipy.sparse import eye_array, hstack, vstack

    inputs, count = _inputs(model), model.columns
    lower = model.col_lower.copy()
    lower[np.flatnonzero(model.c)] = 0.0  # the robustness
    k = len(inputs)
    picked = eye_array(count, format="csr")[inputs]
    above = [hstack([sign * picked, eye_array(k)]) for sign in (-1.0, 1.0)]
    padded = hstack([model.A, np.zeros((model.rows, k))])
    origin = Origin("effort")
    return replace(
        model,
        c=np.append(np.zeros(count), np.ones(k)),
        offset=0.0,
        A=vstack([padded, *above]).tocsr(),
        row_lower=np.append(model.row_lower, np.zeros(2 * k)),
        row_upper=np.append(model.row_upper, np.full(2 * k, np.inf)),
        col_lower=np.append(lower, np.zeros(k)),
        col_upper=np.append(model.col_upper, np.full(k, np.inf)),
        integrality=np.append(model.integrality, np.zeros(k, np.uint8)),
        col_blocks=(*model.col_blocks, Block("effort", count, (k,), origin)),
        row_blocks=(*model.row_blocks, Block("effort", model.rows, (2 * k,), origin)),
    )


def _inputs(model: Model) -> Ints:
    """The columns that bounds or rows of one entry keep between -0.5 and 0.5."""
    lower, upper = model.col_lower.copy(), model.col_upper.copy()
    single = np.flatnonzero(np.diff(model.A.indptr) == 1)
    for row in single:
        entry = model.A.indptr[row]
        column, factor = model.A.indices[entry], model.A.data[entry]
        ends = sorted((model.row_lower[row] / factor, model.row_upper[row] / factor))
        lower[column] = max(lower[column], ends[0])
        upper[column] = min(upper[column], ends[1])
    found = np.flatnonzero((lower == -_PUSH) & (upper == _PUSH) & (model.integrality == 0))
    if not len(found):
        raise SystemExit("no inputs between -0.5 and 0.5: not a model of these scenarios")
    return found


def convert(source: Path, target: Path) -> None:
    """Make over every model of a folder."""
    target.mkdir(parents=True, exist_ok=True)
    for path in sorted(source.glob("*__*.mps*")):
        name = path.name.partition(".")[0]
        model = frugal(model_of(path.read_bytes(), path.name))
        write_model(model, target / f"frugal_{name}.mps.gz", sidecar=False)


def main() -> None:
    """Make over the models of a folder that is named."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("source", type=Path, metavar="FROM")
    parser.add_argument("target", type=Path, metavar="TO")
    asked = parser.parse_args()
    convert(asked.source, asked.target)


if __name__ == "__main__":
    main()
