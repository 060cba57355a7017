"""Rows and columns of a given table: cells numbered ix * ny + iy."""

import numpy as np
import pytest

from stlc.api import load
from stlc.solve.driver import solve_mission

TEXT = """
horizon 1
workspace box [0, 4] x [0, 3]
agent r : single_integrator { start (2.5, 0.5); control |u| <= 0.1 }
station base at (0.5, 2.5)
channel c { partition 2 x 3; table "cost.csv" }
minimize link_cost(c, (r, base))
"""


def test_cells_of_a_table_are_numbered_along_y_first(tmp_path):
    table = np.arange(36.0).reshape(6, 6)
    np.savetxt(tmp_path / "cost.csv", table, delimiter=",", fmt="%g")
    mission = tmp_path / "mission.stl"
    mission.write_text(TEXT)
    found = solve_mission(load(mission)).plan.solve.objective
    assert found == pytest.approx(table[1 * 3 + 0, 0 * 3 + 2])
