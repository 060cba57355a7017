"""What predicates on disturbed agents become."""

from __future__ import annotations

import numpy as np
import pytest

from stlc import api
from stlc.analysis.reach import reach
from stlc.ir.nodes import Linear, walk
from stlc.passes import tubes, unroll
from stlc.passes.base import Program

TEXT = """step 1 s
horizon 3
dynamics rail = single_integrator { dimensions 1 }
agent a : rail { start 0; control |u| <= 2; disturbance 0.25 }
agent b : rail { start 4; control |u| <= 2 }
require far: always[2, 2] (b.px - 2 * a.px >= 1 and a.ux <= 1)
"""


def test_predicates_give_way_to_the_worst_that_their_signals_may_be() -> None:
    mission = api.loads(TEXT)
    tube = mission.agents["a"].tube
    assert tube is not None
    closed = 1.0 + float(tube.gain[0, 0])
    width = 0.25 * (1.0 + abs(closed))  # two pushes, the first of them fed back once
    program = unroll.PASS.run(Program(mission.requirements, mission, reach(mission)))
    strict = tubes.PASS.run(program)
    before, after = (
        [n for n in walk(p.formulas[0]) if isinstance(n, Linear)] for p in (program, strict)
    )
    assert [n.terms for n in before] == [n.terms for n in after]
    lost = [b.constant - a.constant for b, a in zip(before, after, strict=True)]
    pushed = float(np.abs(tube.gain[0, 0])) * width + 0.25
    assert lost == pytest.approx([2 * width, pushed])
