"""CBC by its command line takes a start: it says so, and never ends with less."""

from __future__ import annotations

from pathlib import Path

import pytest
from support.outside import bundled_cbc, cbc_devel

from stlc.arrays import Floats
from stlc.backends import get
from stlc.backends.base import SolveOptions
from stlc.backends.command import run
from stlc.backends.conformance_models import knapsack
from stlc.backends.external import _write, external
from stlc.backends.templates import TEMPLATES, Files
from stlc.solve.certify import certify

HARD = knapsack(200, 30)


@pytest.fixture(scope="module")
def start() -> Floats:
    """A point that is far from the optimum."""
    found = get("highs").solve(HARD, SolveOptions(time_limit=0.2)).x
    assert found is not None
    return found


@pytest.mark.parametrize("binary", [bundled_cbc(), cbc_devel()], ids=["2.10", "devel"])
def test_cbc_starts_from_the_point(binary: str, start: Floats, tmp_path: Path) -> None:
    options = SolveOptions(time_limit=0.5, start=start)
    files = Files.inside(tmp_path)
    _write(HARD, files, options)
    log = run([binary, *TEMPLATES["cbc"].arguments(files, options, ())], options, tmp_path)
    assert "MIPStart provided solution with cost" in log
    found = certify(HARD, external("cbc", binary).solve(HARD, options), options=options)
    assert found.objective is not None
    assert found.objective <= HARD.objective(start) + 1e-6
