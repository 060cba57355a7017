"""Models of a peer made over: the same rows, effort instead of robustness."""

from __future__ import annotations

from importlib import import_module
from pathlib import Path

import numpy as np
import pytest
from scipy.sparse import csr_matrix

from stlc.backends import get
from stlc.backends.base import SolveOptions
from stlc.bench.peer import model_of
from stlc.milp.model import Block, Model, Origin
from stlc.milp.writers import write_model

BENCHMARKS = Path(__file__).resolve().parents[2] / "benchmarks"


def peer(limit: float) -> Model:
    """Two inputs, one bound by rows: u - v = 0.7, and robustness -u - v to maximise."""
    rows = csr_matrix([[1.0, -1.0, 0.0], [0.0, 2.0, 0.0], [0.0, -1.0, 0.0], [1.0, 1.0, 1.0]])
    inf, origin = np.inf, Origin("peer")
    return Model(
        np.array([0.0, 0.0, -1.0]), 0.0, rows,
        np.array([0.7, -2 * limit, -limit, -inf]), np.array([0.7, inf, inf, 0.0]),
        np.array([-limit, -inf, -inf]), np.array([limit, inf, inf]), np.zeros(3, np.uint8),
        (Block("x", 0, (3,), origin),), (Block("row", 0, (4,), origin),), "peer",
    )  # fmt: skip


def made_over(tmp_path: Path, limit: float) -> Model:
    (tmp_path / "from").mkdir()
    write_model(peer(limit), tmp_path / "from" / "two__bigM.mps.gz", sidecar=False)
    with pytest.MonkeyPatch.context() as patch:
        patch.syspath_prepend(BENCHMARKS)
        import_module("peer_effort").convert(tmp_path / "from", tmp_path / "to")
    path = tmp_path / "to" / "frugal_two__bigM.mps.gz"
    return model_of(path.read_bytes(), path.name)


def test_least_effort_with_robustness_at_least_zero(tmp_path: Path) -> None:
    """At the greatest robustness u = 0.2, v = -0.5; so far from 0 need neither be."""
    best = get("highs").solve(peer(0.5), SolveOptions())
    assert best.objective == pytest.approx(-0.3)
    found = get("highs").solve(made_over(tmp_path, 0.5), SolveOptions())
    assert found.objective == pytest.approx(0.7)
    assert found.x is not None
    assert -found.x[0] - found.x[1] >= -1e-9


def test_other_models_are_refused(tmp_path: Path) -> None:
    with pytest.raises(SystemExit, match="no inputs"):
        made_over(tmp_path, 2.0)
