"""Random missions, from their text to verified plans: every backend comes to one objective."""

from __future__ import annotations

import importlib.util
import os
import sys
from pathlib import Path
from types import ModuleType

import pytest

SCRIPT = Path(__file__).resolve().parents[2] / "benchmarks" / "agreement.py"


FULL = os.environ.get("HYPOTHESIS_PROFILE") == "full"
SEEDS = [*range(24 if FULL else 6), 15, 37, 98]  # SCIP's presolve erred on the last three


@pytest.fixture(scope="module")
def script() -> ModuleType:
    spec = importlib.util.spec_from_file_location("agreement", SCRIPT)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    sys.modules["agreement"] = module
    spec.loader.exec_module(module)
    return module


@pytest.mark.parametrize("seed", SEEDS)
def test_one_objective(seed: int, script: ModuleType, tmp_path: Path) -> None:
    names = ["highs", "mip", "pulp", "cvxpy", "scipy", "scip", "gurobi"]
    verdict, found = script.judge_seed(seed, tmp_path, names)
    assert verdict != "differ", found
    assert {name for name, value in found.items() if value in script.ASIDE} <= {"scipy"}


def test_differences_are_seen(script: ModuleType) -> None:
    assert script.agree({"a": 1.0, "b": 1.00001, "c": "failed"})
    assert not script.agree({"a": 1.0, "b": 1.01})
    assert not script.agree({"a": 1.0, "b": "infeasible"})
    assert script.agree({"a": "infeasible", "b": "infeasible"})
