"""Every expected backend is installed and conforms; none is skipped silently."""

import pytest
from support.outside import commands

from stlc.backends import get
from stlc.backends.base import Backend
from stlc.backends.conformance import CASES, Case

EXPECTED = ("highs", "mip", "pulp", "cvxpy", "scipy", "scip", "gurobi")
BACKENDS: dict[str, Backend] = {name: get(name) for name in EXPECTED} | commands()


@pytest.mark.parametrize("name", BACKENDS)
def test_expected_backend_is_available(name: str) -> None:
    backend = BACKENDS[name]
    assert backend.available() is None
    assert any(ch.isdigit() or ch == "d" for ch in backend.version())


@pytest.mark.parametrize("case", CASES, ids=str)
@pytest.mark.parametrize("name", BACKENDS)
def test_conforms(name: str, case: Case) -> None:
    case.check(BACKENDS[name])
