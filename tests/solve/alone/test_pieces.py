"""What a mission asks of a few agents, read off its conjuncts."""

from stlc.analysis.reach import reach
from stlc.api import loads
from stlc.ir.rewrite import postorder
from stlc.passes import run_pipeline
from stlc.passes.base import Program
from stlc.solve.alone.pieces import Pieces, named

TEXT = """
horizon 6
workspace box [0, 9] x [0, 9]
agent r[1..4] : single_integrator { start (2 * i, 1); control |u| <= 1 }
region top = box [0, 9] x [7, 9]
require apart: always forall (a, b) in pairs: separation(a, b) >= 0.5 m
require mixed: always[1, 5] (r[1].x <= 8 m and (r[2].y >= 0 m or r[3].y >= 0 m))
require reach: forall a in agents: eventually a in top
"""


def test_always_of_a_conjunction_falls_apart_into_conjuncts() -> None:
    """Together they ask what the requirement asks: unrolled, they are the same formulas."""
    mission = loads(TEXT)
    pieces = Pieces.of(mission)
    assert [len(parts) for _, parts in pieces.parts] == [6, 2, 4]
    whole = tuple(pieces.about(mission.agents))
    assert [r.name for r in whole] == ["apart", "mixed", "reach"]
    plain, _ = run_pipeline(Program(mission.requirements, mission, reach(mission)))
    split, _ = run_pipeline(Program(whole, mission, reach(mission)))
    for one, other in zip(plain.formulas, split.formulas, strict=True):
        assert set(one.children) == set(other.children)


def test_an_agent_is_asked_only_what_names_it() -> None:
    mission = loads(TEXT)
    asked = {r.name: r.formula for r in Pieces.of(mission).about(["r[4]"])}
    assert asked.keys() == {"apart", "reach"}
    assert len(asked["apart"].children) == 3
    for pair in asked["apart"].children:
        assert "r[4]" in {n for node in postorder([pair]) for n in named(node)}
