"""Unequal shares of a risk: what the plan may choose, that it is sound, and what it gains."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise, product
from math import log10

import numpy as np
import pytest
from scipy.stats import norm

from stlc import api
from stlc.errors import InfeasibleError
from stlc.ir.networks import Count
from stlc.ir.nodes import Always, And, Link, Node, Quantity, Relation, walk
from stlc.mission import Mission
from stlc.sema.allocation import MOST, _levels
from stlc.simulate import simulate

SIGMA = 10**0.5  # dB, of one packet
TEXT = """step 1 s
horizon {steps}
workspace box [0, 20] x [0, 2]
agent a : single_integrator {{ start (3.5, 1); control |u| <= 1 }}
station mast at (0, 1)
channel radio {{
  path_loss L0 = -10 dBm, n = 2
  fading 10 dB^2
  partition 20 x 1
}}
require sure: P({inner}) >= {p:g}
require far: always[{steps}, {steps}] a.x >= {end:g} m
minimize effort
"""


def mission(inner: str, p: float, end: float, steps: int) -> Mission:
    return api.loads(TEXT.format(inner=inner, p=p, end=end, steps=steps))


def _level(cell: int) -> float:
    """dBm at the far end of a cell [cell, cell + 1]."""
    return -10.0 - 20.0 * log10(max(1.0, float(np.hypot(cell + 1, 1.0))))


def _risk(cell: int, level: float) -> float:
    return float(norm.cdf((level - _level(cell)) / SIGMA))


@pytest.mark.parametrize("count", [2, 3, 5, 17, MOST])
def test_every_choice_of_levels_that_is_allowed_keeps_the_risk(count: int) -> None:
    levels = _levels(count)
    assert levels[:2] == (1, 4)
    assert list(levels) == sorted(set(levels))
    assert (count - 1) * levels[0] + levels[-1] <= 4 * count  # one packet may take the most
    assert count * levels[1] <= 4 * count  # equal shares are among the choices


def test_the_formula_allows_just_what_the_shares_add_up_to() -> None:
    formula = mission("always[0, 2] rssi(a, mast) >= -40 dBm", 0.9, 5, 4).requirements[0].formula
    assert isinstance(formula, And)
    (count,) = (n for n in walk(formula) if isinstance(n, Count))
    unit = 0.1 / 12
    risks = sorted({1.0 - _link(a).probability for a in count.args})  # type: ignore[operator]
    levels = [round(r / unit) for r in risks] + [10]
    assert levels == [1, 4, 10]
    for chosen in product(range(len(levels)), repeat=3):  # the level that each packet reaches
        reached = [levels[k] for k in chosen]
        weighed = sum(
            w for a, w in zip(count.args, count.weights, strict=True)
            if reached[_step(a)] <= round((1.0 - (_link(a).probability or 0.0)) / unit)
        )  # fmt: skip
        assert (weighed >= count.least) is (sum(reached) <= 12)


def _link(node: Node) -> Link:
    (found,) = (n for n in walk(node) if isinstance(n, Link))
    return found


def _step(node: Node) -> int:
    return node.start if isinstance(node, Always) else 0


def test_a_mission_that_equal_shares_rule_out_has_a_plan() -> None:
    """The agent has to be far at the last of its packets: that one needs most of the risk."""
    steps, end, p = 6, 9.0, 0.9
    level = _level(9) + SIGMA * float(norm.ppf(0.06))  # the last packet fails with 6 %
    given = mission(f"always[2, 6] rssi(a, mast) >= {level} dBm", p, end, steps)
    assert _risk(9, level) > (1 - p) / 5  # more than an equal share
    outcome = api.solve(given)
    assert outcome.report.ok
    (sure, _) = simulate(given, outcome.plan, draws=40_000).requirements
    assert sure.low >= p
    fixed = given.requirements[0]
    equal = Always(Link("radio", _quantity(fixed.formula), "a", "mast", Relation.AT_LEAST, level,
                        1 - (1 - p) / 5), 2, 6)  # fmt: skip
    with pytest.raises(InfeasibleError):
        api.solve(
            replace(given, requirements=(replace(fixed, formula=equal), *given.requirements[1:]))
        )


def _quantity(formula: Node) -> Quantity:
    return next(n for n in walk(formula) if isinstance(n, Link)).quantity


@pytest.mark.parametrize("seed", range(6))
def test_a_plan_is_found_where_some_way_keeps_allowed_shares(seed: int) -> None:
    rng = np.random.default_rng(seed)
    end, p = float(rng.integers(6, 9)) - 0.3, float(rng.choice([0.8, 0.9, 0.95]))
    level = _level(int(end)) - SIGMA * float(rng.uniform(1.2, 2.6))
    given = mission(f"always[3, 6] rssi(a, mast) >= {level} dBm", p, end, 6)
    if not _allowed(level, p, end):
        with pytest.raises(InfeasibleError):
            api.solve(given)
        return
    outcome = api.solve(given)
    (sure, _) = simulate(given, outcome.plan, draws=20_000).requirements
    assert sure.high >= p  # by Boole it is at least p
    assert sure.probability >= p - 0.005


def _ways(end: float) -> list[tuple[int, ...]]:
    """Cells at steps 3 to 6 of an agent that moves one cell a step at most."""
    found = []
    for way in product(range(1, 10), repeat=4):
        slow = all(abs(a - b) <= 1 for a, b in pairwise(way))
        if slow and 0 <= way[0] <= 6 and way[-1] + 1 >= end:
            found.append(way)
    return found


def _allowed(level: float, p: float, end: float) -> bool:
    """Whether some way keeps levels that may be chosen."""
    unit, levels = (1 - p) / 16, _levels(4)
    for way in _ways(end):
        taken = [next((m for m in levels if _risk(c, level) <= m * unit), 99) for c in way]
        if sum(taken) <= 16:
            return True
    return False
