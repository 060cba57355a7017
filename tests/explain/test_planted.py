"""Planted conflicts, one of a family: what is named is what was planted, and nothing is spare.

All sixty, with their cost: benchmarks/explain.py.
"""

from __future__ import annotations

import pytest
from conflicts.check import broken, faults, names_of, offered
from conflicts.planted import FAMILIES, everything, planted

from stlc.api import loads
from stlc.explain import oracle as oracles
from stlc.explain.conflict import Conflict, all_conflicts, explain
from stlc.explain.oracle import Oracle
from stlc.explain.whole import begin
from stlc.solve.deadline import Deadline


def test_there_are_sixty() -> None:
    assert len(everything()) == 60
    assert len({case.text for case in everything()}) == 60


@pytest.mark.parametrize("family", FAMILIES)
def test_a_planted_conflict_is_named(family: str) -> None:
    case = planted(family, 3)
    mission = loads(case.text)
    found = explain(mission)
    assert isinstance(found, Conflict)
    assert list(faults(case, mission, found)) == []


@pytest.mark.parametrize("family", ["deadline", "contradiction"])
def test_offered_changes_work(family: str) -> None:
    case = planted(family, 1)
    mission = loads(case.text)
    found = explain(mission)
    assert isinstance(found, Conflict)
    changes = offered(case, mission, found)
    assert changes
    assert list(broken(changes)) == []


def test_every_one_of_several_is_listed(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(oracles, "LEAST", 300.0)  # however busy the machine is
    case = planted("several", 0)
    oracle = Oracle(loads(case.text), "highs", Deadline.after(300.0))
    assert begin(oracle) is None
    found = {names_of(c) for c in all_conflicts(oracle)}
    assert found >= {cause for cause in case.causes}
    assert not oracle.deadline.over()
