"""What interval analysis says of requirements that cannot hold."""

from __future__ import annotations

import math
from typing import Any

import pytest
from support.worlds import agent, mission

from stlc.api import loads
from stlc.errors import InfeasibleError
from stlc.explain.conflict import Conflict, explain
from stlc.ir.nodes import Always, And, Eventually, Linear, Node, Role, Signal
from stlc.ir.requirement import Requirement
from stlc.mission import Bound, Mission
from stlc.sema.warnings import NeverFromStart
from stlc.solve import blame
from stlc.solve.blame import Blamed, compile_or_blame
from stlc.source import Source

TEXT = Source("m.stl", "eventually[0,3] far")
FAR = Linear(((Signal("a", Role.STATE, 0), 1.0),), -6.0, span=TEXT.span(16, 19))


def world(formula: Node, limit: float = 50.0) -> Mission:
    one = agent("a", "single", 0.0, limit)
    return mission((one,), 4, (Requirement("far", formula, span=TEXT.span(0, 19)),))


def test_deadline_before_the_earliest_step() -> None:
    with pytest.raises(Blamed) as found:
        compile_or_blame(world(Eventually(FAR, 0, 3, span=TEXT.span(0, 19))))
    assert found.value.exit_status == 3
    assert found.value.blame.earliest == 6
    assert found.value.blame.deadline == 3
    assert str(found.value) == (
        "requirement 'far' cannot hold: m.stl:1:1: `eventually[0,3] far` is not possible "
        "before step 6, the deadline is step 3"
    )


def test_blame_goes_into_conjuncts_and_steps() -> None:
    near = Linear(((Signal("a", Role.STATE, 0), 1.0),), 9.0)
    with pytest.raises(Blamed) as found:
        compile_or_blame(world(And((Always(near, 0, 4), Always(FAR, 2, 4)))))
    assert found.value.blame.span == FAR.span
    assert (found.value.blame.deadline, found.value.blame.earliest) == (2, 6)


def test_bounds_can_put_it_out_of_reach_for_good() -> None:
    with pytest.raises(Blamed, match="out of reach at every step"):
        compile_or_blame(world(Eventually(FAR, 0, 3), limit=5.0))


def test_contradictory_bounds_name_the_agent() -> None:
    one = agent("a", "single", 9.0, 5.0)
    with pytest.raises(InfeasibleError, match="agent 'a' cannot keep its bounds"):
        compile_or_blame(mission((one,), 4, ()))


LINKED = """
workspace box [0, 10] x [0, 10]
agent a : single_integrator { start (1, 1); control |u| <= 1 }
station base at (5, 5)
channel radio { path_loss L0 = -40 dBm, n = 2; partition 2 x 2; bound {bound} }
require talk: eventually[0, 8] rssi(a, base) >= -41 dBm
"""


COARSE = """
workspace box [0, 20] x [0, 20]
agent b : single_integrator { start (2, 10); control |u| <= 1 }
station base at (10, 10)
channel radio {
  path_loss L0 = -40 dBm, n = 3; fading 4 dB^2, shadowing 4 dB^2, length 2 m
  partition 5 x 5
}
require link: always[0, 5] rssi(b, base) >= {level} dBm
"""


def test_cells_that_reach_too_far_are_blamed_with_finer_ones() -> None:
    """-67.1 dBm where the agent stands, -70.4 dBm at the far corner of its cell."""
    with pytest.raises(Blamed, match=r"whole cells: .* \(`partition 10 x 10`\), or"):
        compile_or_blame(loads(COARSE.replace("{level}", "-70")))
    with pytest.raises(Blamed, match=r"at every step$") as found:
        compile_or_blame(loads(COARSE.replace("{level}", "-50")))
    assert found.value.blame.by_cells is None


def test_a_link_that_no_whole_cell_offers_says_so() -> None:
    with pytest.raises(Blamed, match="for whole cells: try a finer `partition`"):
        compile_or_blame(loads(LINKED.replace("{bound}", "worst")))
    with pytest.raises(Blamed, match="by the means of cells: try a finer `partition`"):
        compile_or_blame(loads(LINKED.replace("{bound}", "mean")))
    with pytest.raises(Blamed, match="at the centres of cells: try a finer `partition`"):
        compile_or_blame(loads(LINKED.replace("{bound}", "centre")))
    with pytest.raises(Blamed, match=r"at every step$"):
        compile_or_blame(loads(LINKED.replace("{bound}", "mean").replace("-41", "-39")))


def conflict(requirements: str, bound: Bound = Bound.WORST) -> Conflict:
    world = COARSE[: COARSE.index("require")]
    world = world.replace("partition", f"bound {bound.value}; partition")
    found = explain(loads(world + requirements))
    assert isinstance(found, Conflict)
    return found


def test_a_conflict_that_only_whole_cells_have_is_told_from_a_true_one() -> None:
    assert conflict("require link: always[0, 5] rssi(b, base) >= -70 dBm").by_cells is Bound.WORST
    both = "require far: always[0, 5] b.x <= 3 m\nrequire link: eventually[0, 5] rssi(b, base) >= "
    assert conflict(f"{both}-68 dBm").by_cells is Bound.WORST
    assert conflict(f"{both}-45 dBm").by_cells is None


@pytest.mark.parametrize("bound", [Bound.MEAN, Bound.CENTRE])
def test_means_and_centres_are_told_from_true_conflicts_too(bound: Bound) -> None:
    """-67.1 dBm in the middle of the first cell, -63.3 dBm where it is nearest."""
    link = "require link: always[0, 5] rssi(b, base) >= "
    assert conflict(f"{link}-65 dBm", bound).by_cells is bound
    assert conflict(f"{link}-60 dBm", bound).by_cells is None


def test_conjunctions_within_conjunctions_are_judged_at_once(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """As deep as they are, down to the part that fails."""
    near = Linear(((Signal("a", Role.STATE, 0), 1.0),), 9.0)
    node: Node = And((near, Always(FAR, 1, 4)))
    for _ in range(60):
        node = And((near, node))
    asked: list[int] = []
    possible = blame._Analysis._possible

    def counted(*args: Any, **options: Any) -> list[bool]:
        asked.append(len(args[1]))
        return possible(*args, **options)

    monkeypatch.setattr(blame._Analysis, "_possible", counted)
    with pytest.raises(Blamed) as found:
        compile_or_blame(world(node))
    assert found.value.blame.span == FAR.span
    assert len(asked) < 8


LENGTH = """
step 1 s
horizon 3
workspace box [0, 10] x [0, 10]
agent r : single_integrator { start (2.95, 0.6); control |u| <= 0.01 }
require: always {what}
"""


@pytest.mark.parametrize(
    "what",
    ["distance(r, (0, 0)) >= 3.005", "distance(r, (4.02, 3.9)) <= 3.5", "norm(r.x, r.y) >= 3.005"],
)
def test_a_length_that_only_its_polygon_rules_out_is_told_from_a_true_one(what: str) -> None:
    mission = loads(LENGTH.replace("{what}", what))
    assert not [w.code for w in mission.warnings if w.code == "W1010"]
    with pytest.raises(Blamed, match="by the polygon that stands for the length"):
        compile_or_blame(mission)
    found = explain(mission)
    assert isinstance(found, Conflict)
    assert found.by_faces


def test_a_true_conflict_speaks_of_no_polygon() -> None:
    mission = loads(LENGTH.replace("{what}", "r.x >= 4"))
    found = explain(mission)
    assert isinstance(found, Conflict)
    assert not found.by_faces


def test_a_length_that_is_out_of_reach_is_warned_of_by_its_true_value() -> None:
    mission = loads(LENGTH.replace("{what}", "distance(r, (0, 0)) >= 3.2"))
    assert [w.best for w in mission.warnings if isinstance(w, NeverFromStart)] == [
        pytest.approx(math.hypot(2.95, 0.6) - 3.2)
    ]


def test_a_conflict_with_a_speed_by_a_polygon_says_so() -> None:
    """8 m at 1 m/s within 8 steps, which the polygon of 16 sides misses by 2 %."""
    text = LENGTH.replace("horizon 3", "horizon 8").replace("control |u| <= 0.01", "speed <= 1")
    text = text.replace("(2.95, 0.6)", "(1, 1)").replace("always {what}", "eventually r.x >= 9")
    found = explain(loads(text))
    assert isinstance(found, Conflict)
    assert found.by_faces


def test_an_amount_out_of_reach_is_told_without_a_deadline() -> None:
    text = (
        LENGTH.replace("{what}", "r.x <= 9")
        + """
station base at (9, 9)
channel wifi {
  path_loss L0 = -40 dBm, n = 2.5; noise_floor -90 dBm; partition 40 x 40
  rates (5 dB, 6 Mbit/s) (28 dB, 54 Mbit/s)
}
require film: delivered(r, base) >= 215 Mbit
"""
    )
    with pytest.raises(Blamed, match=r"`delivered\(r, base\) >= 215 Mbit` is out of reach$"):
        compile_or_blame(loads(text))


CORNER = """
step 1 s
horizon 1
workspace box [0, 10] x [0, 10]
agent a : single_integrator { start (3.5, 4.6); control |u| <= 3 }
obstacle o = box [4, 6] x [4, 5]
require c: always a outside o {swept}
require r: always[end] (|a.x - {x}| <= 0.01 and |a.y - 5.6| <= 0.01)
"""


def test_a_corner_that_a_run_might_round_within_a_step_is_told_of() -> None:
    """(3.5, 4.6) to (4.6, 5.6) is 4 cm clear of the corner (4, 5), but behind no face all along."""
    found = explain(loads(CORNER.replace("{swept}", "swept").replace("{x}", "4.6")))
    assert isinstance(found, Conflict)
    assert found.by_steps


def test_a_conflict_at_the_steps_speaks_of_no_corner() -> None:
    found = explain(loads(CORNER.replace("{swept}", "").replace("{x}", "7.5")))
    assert isinstance(found, Conflict)
    assert not found.by_steps
