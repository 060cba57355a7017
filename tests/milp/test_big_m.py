"""Big-Ms that solvers' arithmetic cannot carry, and where they come from."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from support.command import inside as stlc
from support.outside import solvers

from stlc.api import loads
from stlc.errors import MissionError
from stlc.milp.big_m import leaky_big_ms
from stlc.milp.builder import ModelBuilder
from stlc.milp.compile import CompileOptions, compile_mission
from stlc.mission import Mission
from stlc.render import render

MISSION = """step 1 s
horizon 4
workspace box [0, {size}] x [0, 10]
agent a : single_integrator {{ start (1, 1); control |u| <= {size} }}
region far = box [{size} - 2, {size} - 1] x [1, 2]
require visit{margin}: eventually[1, 4] a in far
minimize effort
"""


def _mission(size: float, margin: str = "") -> Mission:
    return loads(MISSION.format(size=size, margin=margin), name="wide.stl")


ERROR = """error[E0802]: `a.px` in requirement `visit` can differ by 2e+06
 --> wide.stl:6:1
  |
6 | require visit: eventually[1, 4] a in far
  | ~~~~~~~~~~~~~~~~~~~~~~~~~~~~~~~~~~~~~~~~ too wide for a solver's arithmetic, which ends at 1e+06
  = help: declare a smaller workspace or bounds, or choose a larger unit of length"""

WARNING = """warning[W1101]: `require visit` makes a big-M of 2e+03 in 4 rows
 --> wide.stl:6:1
  |
6 | require visit: eventually[1, 4] a in far
  | ~~~~~~~~~~~~~~~~~~~~~~~~~~~~~~~~~~~~~~~~ a solver's tolerance of 1e-06 is worth 0.002 here, \
more than 0.001
  = help: declare tighter bounds, or ask for a larger margin"""


@pytest.mark.parametrize("encoding", ["auto", "hull", "bigm"])
def test_too_wide_a_range_is_an_error_at_its_requirement(encoding: str) -> None:
    with pytest.raises(MissionError) as caught:
        compile_mission(_mission(2e6), CompileOptions(stl=encoding))
    assert caught.value.exit_status == 1
    assert render(caught.value.diagnostics).replace("^", "~") == ERROR


def test_a_big_m_that_could_leak_is_warned_about_at_its_requirement() -> None:
    assert render(compile_mission(_mission(2e3)).warnings).replace("^", "~") == WARNING


@pytest.mark.parametrize(
    ("size", "margin", "told"),
    [(900, "", False), (2e3, " margin 0.1", False), (900, " margin 0.0001", True)],
)
def test_the_margin_decides(size: float, margin: str, told: bool) -> None:
    assert bool(compile_mission(_mission(size, margin)).warnings) is told


def test_only_rows_with_continuous_columns_have_a_big_m() -> None:
    b = ModelBuilder()
    n, x = b.binary("n", (2,)), b.add_columns("x", (1,))
    b.add_dense_rows("big", np.array([[n[0], x[0]]]), [-5e5, 1], 0, np.inf)
    b.add_dense_rows("count", n[None, :], [1e9, 1], 0, np.inf)
    (warning,) = leaky_big_ms(b.build(), {})
    assert (warning.rows, warning.size, warning.span) == (1, 5e5, None)


def test_commands_tell_it(tmp_path: Path) -> None:
    (tmp_path / "wide.stl").write_text(MISSION.format(size=2e3, margin=""))
    done = stlc("compile", "wide.stl", "-o", "m.mps", folder=tmp_path)
    assert done.returncode == 0
    assert "W1101" in done.stderr
    told = "wide.stl:6:1: warning[W1101]: `require visit` makes a big-M"
    done = stlc("solve", "wide.stl", folder=tmp_path)
    assert done.returncode == 0
    assert told in done.stderr
    words = ("race", "wide.stl", "--with", "highs:auto,scipy:auto")
    done = stlc(*words, folder=tmp_path)
    assert done.returncode == 0
    assert done.stderr.count(told) == 1
    solvers()["HiGHS"](tmp_path / "m.mps", tmp_path / "m.sol")
    done = stlc("read-solution", "wide.stl", "m.sol", folder=tmp_path)
    assert done.returncode == 0
    assert "W1101" in done.stderr
    (tmp_path / "wider.stl").write_text(MISSION.format(size=2e6, margin=""))
    assert stlc("solve", "wider.stl", folder=tmp_path).returncode == 1
