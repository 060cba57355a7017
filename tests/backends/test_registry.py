"""Finding backends: names, aliases, plugins, missing solvers, lazy imports."""

import re
import subprocess
import sys
from importlib.metadata import EntryPoint
from pathlib import Path

import pytest
from support.command import inside as stlc

from stlc import backends
from stlc.backends.base import Backend, SolveOptions
from stlc.backends.conformance_models import knapsack
from stlc.backends.external import external
from stlc.backends.highs import Highs
from stlc.errors import SolverError, UsageError


@pytest.mark.parametrize("name", backends.names())
def test_each_name_gives_a_backend_of_that_name(name: str) -> None:
    backend = backends.get(name)
    assert isinstance(backend, Backend)
    assert backend.name == name
    problem = backend.available()
    assert problem is None or re.search(r"run: |get |comes with", problem)


def test_cbc_is_python_mip() -> None:
    assert backends.get("cbc").name == "mip"


def test_an_unknown_name_lists_the_known() -> None:
    with pytest.raises(UsageError, match=r"no backend 'nobody'; known: highs, mip"):
        backends.get("nobody")


def _plugged(monkeypatch: pytest.MonkeyPatch, value: str) -> None:
    point = EntryPoint("theirs", value, "stlc.backends")
    monkeypatch.setattr(backends, "entry_points", lambda group: [point])


def test_a_plugin_is_found(monkeypatch: pytest.MonkeyPatch) -> None:
    _plugged(monkeypatch, "stlc.backends.highs:Highs")
    assert "theirs" in backends.names()
    assert isinstance(backends.get("theirs"), Highs)


@pytest.mark.parametrize("value", ["no.such:Thing", "stlc.backends.highs:Nothing", "builtins:dict"])
def test_a_broken_plugin_is_a_clear_error(monkeypatch: pytest.MonkeyPatch, value: str) -> None:
    _plugged(monkeypatch, value)
    with pytest.raises(SolverError, match="'theirs'"):
        backends.get("theirs")


def test_plugins_are_listed_as_they_are_asked_for(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    _plugged(monkeypatch, "stlc.backends.highs:Highs")
    done = stlc("backends", folder=tmp_path)
    assert done.returncode == 0, done.stderr
    assert re.search(r"^theirs +HiGHS \d", done.stdout, re.MULTILINE)
    _plugged(monkeypatch, "no.such:Thing")
    done = stlc("backends", folder=tmp_path)
    assert done.returncode == 0, done.stderr
    assert re.search(r"^theirs +missing: backend 'theirs' could not be loaded", done.stdout, re.M)
    assert re.search(r"^highs +HiGHS \d", done.stdout, re.MULTILINE)


@pytest.mark.parametrize(
    ("name", "module", "install"),
    [
        ("mip", "mip", "stlc[mip]"), ("pulp", "pulp", "stlc[pulp]"),
        ("scip", "pyscipopt", "stlc[scip]"), ("cvxpy", "cvxpy", "stlc[cvxpy]"),
        ("gurobi", "gurobipy", "stlc[gurobi]"),
    ],
)  # fmt: skip
def test_a_missing_solver_says_how_to_install_it(
    monkeypatch: pytest.MonkeyPatch, name: str, module: str, install: str
) -> None:
    from importlib import util

    real = util.find_spec
    monkeypatch.setattr(util, "find_spec", lambda m, *a: None if m == module else real(m, *a))
    with pytest.raises(SolverError) as error:
        backends.get(name).solve(knapsack(), SolveOptions())
    assert f"pip install '{install}'" in str(error.value)


def test_a_missing_command_says_how_to_install_it() -> None:
    with pytest.raises(SolverError, match="apt-get install coinor-cbc"):
        external("cbc", "no-such-cbc").solve(knapsack(), SolveOptions())


def test_listing_backends_imports_no_solver() -> None:
    code = (
        "import sys; from stlc import backends; [backends.get(n) for n in backends.names()]\n"
        "heavy = {'highspy', 'mip', 'pulp', 'cvxpy', 'pyscipopt', 'gurobipy', 'scipy'}\n"
        "sys.exit(', '.join(heavy & set(sys.modules)) or 0)"
    )
    run = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    assert run.stderr == ""


@pytest.mark.parametrize("name", ["highs", "scip", "gurobi", "cvxpy"])
def test_an_unknown_solver_option_is_refused(name: str) -> None:
    with pytest.raises(SolverError, match="no_such_option"):
        backends.get(name).solve(knapsack(), SolveOptions(extra={"no_such_option": 1}))


@pytest.mark.parametrize(
    ("extra", "message"),
    [
        ({}, "needs a command"),
        ({"command": "no-such-program {mps} {sol}"}, "cannot run no-such-program"),
        (
            {"command": "sh -c 'echo no licence; exit 3' {mps} {sol}"},
            "status 3: no licence",
        ),
        ({"command": "cp {mps} {sol}"}, "not readable"),
    ],
)
def test_a_command_that_fails_is_a_clear_error(extra: dict[str, object], message: str) -> None:
    with pytest.raises(SolverError) as error:
        backends.get("external").solve(knapsack(), SolveOptions(extra=extra))
    assert message in str(error.value)
