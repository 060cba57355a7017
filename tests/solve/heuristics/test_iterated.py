"""Iterated descents, against what the whole model says of the same runs."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from support.link_missions import Variant, compiled_mission

from stlc import backends
from stlc.arrays import Floats
from stlc.backends.base import SolveOptions
from stlc.milp.compile import Compiled
from stlc.solve.heuristics.descent import Descent
from stlc.solve.heuristics.iterated import cost_of, iterated
from stlc.solve.link_search import plan_links
from stlc.solve.relaxation.recognise import recognise
from stlc.solve.restricted.frame import Frame
from stlc.solve.restricted.session import Session
from stlc.solve.strategies import STRATEGIES
from stlc.solve.strategy import Work

THREE = Variant(agents=3, steps=3, cells=4)
STATION = Variant(agents=2, steps=3, cells=4, station=True)
EXACT = SolveOptions(gap=1e-6)


def _session(compiled: Compiled) -> Session:
    problem = recognise(compiled)
    assert problem is not None
    work = Work.of(compiled, backends.get("highs"), EXACT)
    return Session(Frame(compiled, problem), work)


def _best(compiled: Compiled, session: Session) -> tuple[float, list[Floats]]:
    """Value and positions of the optimum; the session has no plan of its own after it."""
    found = backends.get("highs").solve(compiled.model, EXACT)
    assert found.x is not None
    session.offer(found.x)
    value, paths = session.value, session.paths()
    session.x, session.value = None, np.inf
    return value, paths


@pytest.mark.parametrize("variant", [THREE, STATION])
def test_runs_cost_what_the_model_says(variant: Variant, tmp_path: Path) -> None:
    """Tables take their own touching cells; states of the relaxation count with the least."""
    below = 0
    for seed in range(2):
        compiled = compiled_mission(tmp_path, seed, variant)
        session = _session(compiled)
        value, paths = _best(compiled, session)
        assert cost_of(session.guide, dict(enumerate(paths))) == pytest.approx(value, abs=1e-4)
        below += cost_of(session.problem, dict(enumerate(paths))) < value - 1e-3
    assert below > 0


def test_a_plan_along_runs_costs_no_more(tmp_path: Path) -> None:
    """On a border too, where every pair takes its own cell."""
    for seed in range(4):
        compiled = compiled_mission(tmp_path, seed, THREE)
        session = _session(compiled)
        value, paths = _best(compiled, session)
        assert session.follow(paths, 10.0)
        assert session.value == pytest.approx(value, abs=2e-3 * value)


def test_later_runs_are_cheaper_and_the_same_every_time(tmp_path: Path) -> None:
    session = _session(compiled_mission(tmp_path, 3, THREE))
    found = [
        [cost_of(session.guide, runs)
         for runs in iterated(Descent(session.guide, session.stopped), session.stopped, seed=1)]
        for _ in range(2)
    ]  # fmt: skip
    assert found[0] == found[1]
    assert found[0] == sorted(found[0], reverse=True)


def test_the_first_plan_of_a_team_that_pays_for_links_is_one_of_descents(tmp_path: Path) -> None:
    compiled = compiled_mission(tmp_path, 0, THREE)
    work = Work.of(compiled, backends.get("highs"), EXACT)
    strategies = [s.name for s in STRATEGIES if s.applies(work)]
    assert strategies.index("descents") < strategies.index("turns")
    found, session = plan_links(work), _session(compiled)
    least = min(
        cost_of(session.guide, runs)
        for runs in iterated(Descent(session.guide, session.stopped), session.stopped)
    )
    assert np.isfinite(least)
    assert found.value <= least + 1e-4
