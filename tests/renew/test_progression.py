"""What is left of a formula has, on what comes, the robustness of the formula on the whole."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from support.formulas import LENGTH, Naive, at_least, formulas, signal, traces

from stlc.ir.networks import Count
from stlc.ir.nodes import Always, And, Eventually, Linear, Node, Until
from stlc.passes.horizon import last_steps
from stlc.renew.progression import Progression


def _left(node: Node, values: dict[str, np.ndarray], now: int) -> Node:
    """The formula after `now` steps of a run."""
    naive = Naive(values)

    def known(part: Node, step: int) -> float | None:
        late = max((s.shift for s, _ in part.terms), default=0) if isinstance(part, Linear) else 0
        return naive.at(part, step) if step + late <= now else None

    last = last_steps((node,), LENGTH - 1)
    return Progression(now, known, lambda s, t: float(values[s.owner][t]), last).of(node)


def _agree(node: Node, values: dict[str, np.ndarray], now: int) -> None:
    whole = Naive(values).at(node, 0)
    if whole is None:
        return
    rest = {name: value[now:] for name, value in values.items()}
    left = Naive(rest).at(_left(node, values, now), 0)
    assert left is not None
    assert left == pytest.approx(whole)


@given(formulas(until=True, unbounded=True, timed=True), traces, st.integers(1, 10))
def test_robustness_of_what_is_left_is_that_of_the_whole(
    node: Node, values: dict[str, np.ndarray], now: int
) -> None:
    _agree(node, values, now)


@given(traces, st.integers(1, 10))
def test_predicates_that_look_ahead_and_counts(values: dict[str, np.ndarray], now: int) -> None:
    ahead = Linear(((signal("x"), -1.0), (signal("x", 2), 1.0), (signal("y", 1), 0.5)), 0.25)
    _agree(Always(ahead, 0, 8), values, now)
    some = Count((at_least("x", 0.5), at_least("y", 0.0), ahead), 2)
    _agree(Eventually(Always(some, 0, 2), 1, 9), values, now)


def test_what_is_fulfilled_asks_for_nothing_more() -> None:
    values = {"x": np.array([0.0, 2.0, *[0.0] * (LENGTH - 2)]), "y": np.zeros(LENGTH)}
    reach = Until(at_least("y", 0.0), at_least("x", 1.0), 0, None)
    left = _left(reach, values, 3)
    assert Naive({n: v[3:] for n, v in values.items()}).at(left, 0) == 0.0
    both = _left(And((at_least("x", -1.0), at_least("y", -0.5))), values, 1)
    assert both == Linear((), 0.5)
