"""Plugs between moving obstacles are those of each step worked out by itself."""

import numpy as np
import pytest

from stlc.api import loads
from stlc.places import Sweep
from stlc.sema import plugs
from stlc.sema.junctions import meeting, plugs_between
from stlc.sema.values import Place

TEXT = """step 1 s
horizon 30
agent r : double_integrator {{ start (1, 1); control |u| <= 1 }}
obstacle a = box [10, 12] x [10, 12] + box [12, 13] x [10, 14] {one}
obstacle b = {form} {other}
require: always (r outside a swept and r outside b swept)
"""


@pytest.mark.parametrize("swept", [True, False])
@pytest.mark.parametrize(
    ("form", "one", "other", "touches"),
    [
        ("box [13, 14] x [11, 13]", "velocity (0.1, 0.2)", "velocity (0.1, 0.2)", True),
        ("box [13, 14] x [1, 2]", "", "velocity (0, 1)", True),
        ("box [17, 18] x [11, 13]", "velocity (0.1, 0)", "velocity (-0.1, 0)", True),
        ("box [23, 24] x [11, 13]", "velocity (0.1, 0)", "velocity (0.1, 0)", False),
    ],
)
def test_steps_that_are_passed_over_have_no_plugs(form, one, other, touches, swept):
    mission = loads(TEXT.format(form=form, one=one, other=other))
    a, b = (Place(mission.obstacles[name]) for name in "ab")
    tracks = plugs.plugs_of_two(a, b, swept)
    seen = 0
    for t, (x, y) in enumerate(plugs._steps((a, b), swept)):
        made = [track[t] for track in tracks]
        alike = np.allclose(x.move, y.move, atol=1e-9)
        fresh = (
            [Sweep(plugs_between(x.pieces, y.pieces), x.move)]
            if alike
            else [plugs._carried(x, y), plugs._carried(y, x)]
        )
        seen += any(s.pieces for s in fresh)
        wanted = [piece.vertices for sweep in fresh for piece in sweep.pieces]
        found = [piece.vertices for sweep in made for piece in sweep.pieces]
        assert len(found) == len(wanted)
        for mine, his in zip(found, wanted, strict=True):
            assert mine == pytest.approx(his, abs=1e-9)
    assert bool(seen) is touches


@pytest.mark.parametrize("swept", [True, False])
def test_plugs_of_three_go_along(swept):
    """Three wedges about a point, which all move alike."""
    wedges = ["(5, 5) (9, 5) (5, 9)", "(5, 5) (5, 9) (1, 1)", "(5, 5) (1, 1) (9, 5)"]
    obstacles = "".join(
        f"obstacle o{k} = polygon {ring} velocity (0.1, 0.2)\n" for k, ring in enumerate(wedges)
    )
    head = TEXT.split("obstacle")[0].replace("{{", "{").replace("}}", "}")
    rule = "require: always forall o in obstacles: r outside o swept\n"
    mission = loads(head.replace("(1, 1)", "(30, 1)") + obstacles + rule)
    places = [Place(mission.obstacles[f"o{k}"]) for k in range(3)]
    (track,) = plugs.plugs_of_three(places, swept)
    assert len(track) == 31
    for made, sweeps in zip(track, plugs._steps(places, swept), strict=True):
        wanted = meeting(*(s.pieces for s in sweeps))
        assert len(made.pieces) == len(wanted) == 1
        assert made.pieces[0].vertices == pytest.approx(wanted[0].vertices, abs=1e-9)
