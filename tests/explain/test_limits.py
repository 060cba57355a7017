"""Time limits: an explanation ends by them, with what is known by then, whatever takes long."""

from __future__ import annotations

import threading

import pytest

from stlc.api import loads
from stlc.errors import InterruptedSolveError
from stlc.explain import oracle as oracles
from stlc.explain.conflict import Conflict, explain
from stlc.explain.oracle import Oracle, Verdict
from stlc.explain.whole import begin, undecided
from stlc.milp.compile import Compiled, CompileOptions, compile_mission
from stlc.mission import Mission
from stlc.solve.deadline import Deadline

TEXT = """horizon 8
workspace box [0, 10] x [0, 10]
agent a : single_integrator { start (1, 1); control |u| <= 1 }
agent b : single_integrator { start (1, 8); control |u| <= 1 }
region goal = box [8, 10] x [0, 3]
require go: eventually[0, 5] a in goal
require low: always b.y <= 9
require apart: always separation(a, b) >= 1 m
"""
FINE = TEXT.replace("[0, 5]", "[0, 8]")


@pytest.fixture
def hard(monkeypatch: pytest.MonkeyPatch) -> None:
    """What speaks of `go` takes too long to compile, as it says at once."""

    def compiled(mission: Mission, options: CompileOptions) -> Compiled:
        if any(r.name.startswith("go") for r in mission.requirements):
            raise InterruptedSolveError("it would take too long")
        return compile_mission(mission, options)

    monkeypatch.setattr(oracles, "compile_mission", compiled)


@pytest.mark.usefixtures("hard")
def test_what_could_not_be_decided_is_named_with_its_place() -> None:
    oracle = Oracle(loads(FINE, name="m.stl"), "highs", Deadline.after(60.0))
    assert begin(oracle) is Verdict.UNKNOWN
    assert [r.name for r in oracle.together] == ["low", "apart"]
    assert undecided(oracle) == (
        "`apart` and `low` can hold together; whether `go` (line 6) can beside them is open"
    )


@pytest.mark.usefixtures("hard")
def test_one_requirement_that_can_hold_is_one() -> None:
    text = "\n".join(line for line in FINE.splitlines() if not line.startswith("require low"))
    oracle = Oracle(loads(text), "highs", Deadline.after(60.0))
    assert begin(oracle) is Verdict.UNKNOWN
    assert undecided(oracle) == "`apart` can hold; whether `go` (line 6) can beside it is open"


@pytest.mark.usefixtures("hard")
def test_a_conflict_is_found_beside_what_takes_too_long() -> None:
    found = explain(loads(TEXT.replace("b.y <= 9", "b.y <= 7")))
    assert isinstance(found, Conflict)
    assert [c.name for c in found.clauses] == ["low"]


@pytest.mark.parametrize("hears", [True, False])
def test_compiling_ends_with_the_time(monkeypatch: pytest.MonkeyPatch, hears: bool) -> None:
    over = threading.Event()

    def endless(mission: Mission, options: CompileOptions) -> Compiled:
        while not over.wait(0.01) and not (hears and options.should_stop()):
            pass
        raise InterruptedSolveError("told to")

    monkeypatch.setattr(oracles, "compile_mission", endless)
    grace = None if hears else 0.05
    assert explain(loads(FINE), time_limit=0.5, grace=grace) is Verdict.UNKNOWN
    over.set()


def test_without_time_a_proven_conflict_is_all_there_is_and_says_so() -> None:
    found = explain(loads(TEXT), time_limit=0.0, proven=True)
    assert isinstance(found, Conflict)
    assert {c.name for c in found.clauses} == {"go", "low", "apart"}
    assert all(found.spans)
    assert not found.minimal
    assert found.cause.earliest is None
    assert found.cause.short is None
    assert "for want of time" in found.confirmation


def test_a_deadline_that_is_not_found_out_is_not_told() -> None:
    """A lone `eventually`, and no time to ask about later steps."""
    text = "\n".join(line for line in TEXT.splitlines() if not line.startswith("require low"))
    text = "\n".join(line for line in text.splitlines() if not line.startswith("require apart"))
    found = explain(loads(text), time_limit=0.0, proven=True)
    assert isinstance(found, Conflict)
    assert [c.name for c in found.clauses] == ["go"]
    assert found.cause.earliest is None
    assert "cannot" not in found.cause.text
