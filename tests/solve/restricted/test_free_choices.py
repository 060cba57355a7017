"""A choice is fixed only where one alternative asks for nothing: no point is lost by that."""

from __future__ import annotations

import numpy as np
import pytest

from stlc.api import loads
from stlc.milp.compile import CompileOptions, compile_mission
from stlc.solve.restricted.free_choices import fix_free_choices, groups_of

TEXT = """step 1 s
horizon 4
workspace box [0, 10] x [0, 10]
agent r : single_integrator { start (1, 1); control |u| <= 3 }
region a = box [2, 4] x [0, 2]
region b = box [6, 8] x [0, 2]
require reach: eventually[1, 4] r in a or eventually[1, 4] r in b
minimize effort
"""


@pytest.mark.parametrize("inside", [True, False])
def test_a_choice_is_fixed_where_its_alternative_holds_anyway(inside: bool) -> None:
    compiled = compile_mission(loads(TEXT), CompileOptions(stl="onehot"))
    model = compiled.model
    (group,) = groups_of(compiled, model.A.tocsc())
    lower, upper = model.col_lower.copy(), model.col_upper.copy()
    if inside:  # at step 1 the agent is kept within region a
        x = compiled.layout.states["r"][1]
        lower[x], upper[x] = [2.5, 0.5], [3.5, 1.5]
    fix_free_choices(model, [group], lower, upper)
    fixed = lower[group.columns] == upper[group.columns]
    assert fixed.all() == inside
    if inside:
        assert lower[group.columns].sum() == 1.0


def test_a_choice_that_is_made_is_left_alone() -> None:
    compiled = compile_mission(loads(TEXT), CompileOptions(stl="onehot"))
    model = compiled.model
    (group,) = groups_of(compiled, model.A.tocsc())
    lower, upper = model.col_lower.copy(), model.col_upper.copy()
    lower[group.columns[0]] = 1.0
    before = np.stack([lower, upper])
    fix_free_choices(model, [group], lower, upper)
    assert (np.stack([lower, upper]) == before).all()
