"""SCIP and FiberSCIP by their command lines are kept from the presolve that loses integrality."""

from __future__ import annotations

from pathlib import Path

import pyscipopt
import pytest

from stlc.backends.base import SolveOptions, Status
from stlc.backends.conformance_models import knapsack
from stlc.backends.external import external

# Leaves its arguments and the settings among them behind, then claims that there is no point.
_FAKE = """#!/bin/sh
for word in "$@"; do
  echo "$word" >> {folder}/words
  case $word in *.set|*.txt) cp "$word" {folder}/ ;; esac
done
echo "SCIP Status        : problem is solved [infeasible]"
"""


def _words(name: str, folder: Path, options: SolveOptions) -> list[str]:
    """What the command of that name is called with."""
    fake = folder / name
    fake.write_text(_FAKE.format(folder=folder))
    fake.chmod(0o755)
    assert external(name, str(fake)).solve(knapsack(), options).status is Status.INFEASIBLE
    return (folder / "words").read_text().splitlines()


@pytest.mark.parametrize("more", ["", "-q -isol first.sol"])
def test_fscip_reads_it_from_a_settings_file(more: str, tmp_path: Path) -> None:
    options = SolveOptions(time_limit=7.0, threads=2, extra={"arguments": more})
    words = _words("fscip", tmp_path, options)
    parameters, model, *flags = words
    assert parameters.endswith("settings.txt")
    assert "TimeLimit = 7.0\n" in (tmp_path / "settings.txt").read_text()
    assert model.endswith("model.mps")
    given = dict(zip(flags[:10:2], flags[1:10:2], strict=True))
    assert given["-sth"] == "2"
    assert given["-fsol"].endswith("model.sol")
    assert flags[10:] == more.split()
    (settings,) = {given[role] for role in ("-sl", "-sr", "-s")}
    scip = pyscipopt.Model()
    scip.readParams(str(tmp_path / Path(settings).name))
    assert scip.getParam("presolving/donotmultaggr") is True


def test_scip_is_told_before_it_optimises(tmp_path: Path) -> None:
    words = _words("scip", tmp_path, SolveOptions(time_limit=7.0, seed=3))
    commands = words[words.index("-c") + 1 :: 2]
    assert "set presolving donotmultaggr TRUE" in commands[: commands.index("optimize")]
    assert "set limits time 7.0" in commands
