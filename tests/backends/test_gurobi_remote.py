"""Gurobi's remote parameters reach its environment, the others the model."""

from __future__ import annotations

from typing import Any

import gurobipy
import pytest

from stlc.backends import get
from stlc.backends.base import SolveOptions
from stlc.backends.conformance_models import knapsack
from stlc.errors import SolverError


def test_remote_parameters_go_to_the_environment(monkeypatch: pytest.MonkeyPatch) -> None:
    seen: list[dict[str, Any]] = []

    def refuse(params: dict[str, Any]) -> None:
        seen.append(params)
        raise gurobipy.GurobiError(10022, "no server there")

    monkeypatch.setattr(gurobipy, "Env", refuse)
    extra: dict[str, object] = {"ComputeServer": "host:61000", "CSPriority": 5, "MIPFocus": 1}
    with pytest.raises(SolverError, match="no server there"):
        get("gurobi").solve(knapsack(), SolveOptions(extra=extra))
    assert seen[0]["ComputeServer"] == "host:61000"
    assert seen[0]["CSPriority"] == 5
    assert "MIPFocus" not in seen[0]


def test_an_unknown_parameter_is_named() -> None:
    with pytest.raises(SolverError, match="NoSuchThing"):
        get("gurobi").solve(knapsack(), SolveOptions(extra={"NoSuchThing": 1}))
