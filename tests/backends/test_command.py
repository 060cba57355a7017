"""Commands of solvers that end badly: said, and never taken for a limit."""

from dataclasses import replace
from pathlib import Path

import pytest

from stlc.backends import pulp_cbc
from stlc.backends.base import SolveOptions, Status
from stlc.backends.conformance_models import knapsack
from stlc.backends.external import external
from stlc.errors import SolverError, UsageError


def _command(folder: Path, *lines: str) -> SolveOptions:
    script = folder / "solver.sh"
    script.write_text("\n".join(("#!/bin/sh", *lines)))
    script.chmod(0o755)
    return SolveOptions(time_limit=60.0, extra={"command": f"{script} {{mps}} {{sol}}"})


@pytest.mark.parametrize("name", ["SEGV", "KILL", "ABRT"])
def test_a_solver_that_is_killed(name: str, tmp_path: Path) -> None:
    with pytest.raises(SolverError, match=f"solver.sh was killed by SIG{name}"):
        external("").solve(knapsack(), _command(tmp_path, f"kill -{name} $$"))


def test_a_solver_that_we_end_was_not_killed(tmp_path: Path) -> None:
    options = _command(tmp_path, "sleep 60")
    stopped = SolveOptions(extra=options.extra, should_stop=lambda: True)
    assert external("").solve(knapsack(), stopped).status is Status.NO_SOLUTION


@pytest.mark.parametrize(
    ("command", "said"),
    [
        (False, r"'false' lacks \{mps\} and \{solution\}"),
        ("mysolver {mps}", r"lacks \{solution\}"),
        ("mysolver {sol}", r"lacks \{mps\}"),
        ("mysolver {mps} {sol} {log}", "other than"),
        ("mysolver {mps} {sol} {}", "can't be read"),
        ("mysolver {mps} {sol} {", "can't be read"),
        ("mysolver {mps} {sol} {sol[0]}", "can't be read"),
        ("mysolver {mps} '{sol}", "can't be read"),
    ],
)
def test_a_command_that_cannot_work_is_a_slip_of_the_call(command: object, said: str) -> None:
    with pytest.raises(UsageError, match=said):
        external("").solve(knapsack(), SolveOptions(extra={"command": command}))


def test_a_killed_cbc_of_pulp_is_told(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    options = _command(tmp_path, "kill -KILL $$")
    monkeypatch.setattr(pulp_cbc, "bundled_cbc", lambda: str(tmp_path / "solver.sh"))
    with pytest.raises(SolverError, match=r"solver.sh was killed by SIGKILL"):
        pulp_cbc.PulpCbc().solve(knapsack(), replace(options, extra={}))
