"""Every expected backend is installed and conforms; none is skipped silently."""

import shutil

import pytest

from stlc.backends import get
from stlc.backends.base import Backend
from stlc.backends.conformance import CASES, Case
from stlc.backends.external import external
from stlc.backends.pulp_cbc import bundled_cbc

EXPECTED = ("highs", "mip", "pulp", "cvxpy", "scipy", "scip", "gurobi")


def _backends() -> list[Backend]:
    found = [get(name) for name in EXPECTED]
    found.append(external("cbc", bundled_cbc()))
    if shutil.which("glpsol"):  # a Debian package that CI installs
        found.append(external("glpsol"))
    return found


@pytest.mark.parametrize("backend", _backends(), ids=lambda b: b.name)
def test_expected_backend_is_available(backend: Backend) -> None:
    assert backend.available() is None
    assert any(ch.isdigit() or ch == "d" for ch in backend.version())


@pytest.mark.parametrize("case", CASES, ids=str)
@pytest.mark.parametrize("backend", _backends(), ids=lambda b: b.name)
def test_conforms(backend: Backend, case: Case) -> None:
    case.check(backend)
