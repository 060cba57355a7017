"""Which strategies run on which missions, and that no other is imported."""

from __future__ import annotations

import subprocess
import sys

import pytest

from stlc import backends
from stlc.api import loads
from stlc.backends.base import SolveOptions
from stlc.milp.compile import compile_mission
from stlc.solve.strategies import STRATEGIES
from stlc.solve.strategy import Work

ALONE = """
horizon 4
workspace box [0, 6] x [0, 6]
agent r1 : single_integrator { start (1, 1); control |u| <= 1.5 }
region goal = box [4, 6] x [0, 2]
require reach: eventually r1 in goal
"""
PAIR = ALONE + "agent r2 : single_integrator { start (1, 4); control |u| <= 1.5 }\n"
PAIR += "require apart: always separation(r1, r2) >= 1 m\n"
TEAM = PAIR + "agent r3 : single_integrator { start (5, 4); control |u| <= 1.5 }\n"
TEAM += "require apart3: always (separation(r1, r3) >= 1 m and separation(r2, r3) >= 1 m)\n"
EFFORT, LEVEL = "minimize effort", "maximize robustness"
PLACES = """station s at (0, 0)
channel radio { path_loss L0 = -40 dBm, n = 3; noise_floor -92 dBm; partition 3 x 3 }
minimize link_cost(radio) + effort
"""


@pytest.mark.parametrize(("text", "names"), [
    (ALONE + EFFORT, ["routes", "milp"]),
    (ALONE + LEVEL, ["dive", "milp"]),
    (ALONE + PLACES, ["boxes", "routes", "milp"]),
    (PAIR + EFFORT, ["brief", "grids", "lone", "milp"]),
    (TEAM + EFFORT, ["brief", "grids", "turns", "routes", "lone", "milp"]),
    (TEAM.replace("single", "double") + EFFORT, ["brief", "turns", "routes", "lone", "milp"]),
    (PAIR.replace("single", "double") + EFFORT, ["brief", "lone", "milp"]),
])  # fmt: skip
def test_structure_says_which_may_run(text: str, names: list[str]) -> None:
    compiled = compile_mission(loads(text))
    work = Work.of(compiled, backends.get("highs"), SolveOptions())
    assert [one.name for one in STRATEGIES if one.applies(work)] == names


def test_a_search_is_imported_when_it_runs() -> None:
    """A mission for one agent that maximises robustness meets neither routes nor teams."""
    code = f"""if True:
        import sys
        from stlc.api import loads, solve
        solve(loads({ALONE + LEVEL!r}))
        rooms = "routes", "teams", "alone.parts", "bounders", "relaxation"
        print([r for r in rooms if any(m.startswith("stlc.solve." + r) for m in sys.modules)])
    """
    ran = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert ran.stdout.strip() == "[]"
