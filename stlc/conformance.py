"""What every encoding has to hold, built in or from a package: optima, and receipts.

    from stlc.conformance import check_formula_encoding, check_table_encoding

    check_formula_encoding("mine")  # registered under the entry-point group stlc.encodings

The searches around a model believe the receipts of `stlc.milp.layout`; an encoding that hands over
wrong ones would make them wrong, one that hands over none makes them slow. AssertionError says
what is amiss.
"""

from __future__ import annotations

import numpy as np

from stlc.api import loads
from stlc.arrays import Floats
from stlc.backends import get
from stlc.backends.base import SolveOptions, Status
from stlc.milp.compile import Compiled, CompileOptions, compile_mission
from stlc.milp.layout import PairColumns
from stlc.solve.heuristics.dive import find_start
from stlc.solve.strategies import run_strategy

_STONES = """step 1 s
horizon 7
workspace box [0, 8] x [0, 4]
agent r : double_integrator { start (1, 1); control |u| <= 1; speed <= 2 }
region goal = box [6, 7.5] x [1, 3]
obstacle low = box [3, 4] x [0, 2.5]
obstacle late = box [5, 5.5] x [1.5, 4]
require reach: eventually[3, 7] r in goal
require clear: always r outside low and r outside late
maximize robustness
"""

_PAIR = """step 1 s
horizon 3
workspace box [0, 6] x [0, 6]
agent a : single_integrator { start (1, 1); control |u| <= 2 }
agent b : single_integrator { start (5, 1); control |u| <= 2 }
channel radio {
  path_loss L0 = -40 dBm, n = 3; fading 1 dB^2, shadowing 1 dB^2, length 2 m
  noise_floor -90 dBm; partition 3 x 3
}
region far = box [4.5, 6] x [4.5, 6]
require go: eventually[2, 3] a in far
minimize 0.2 * effort + link_cost(radio, (a, b))
"""

_EXACT = SolveOptions(gap=1e-7, threads=1)
_CLOSE = 1e-5  # of optima and indicators: an order above what solvers promise


def check_formula_encoding(name: str) -> None:
    """One optimum with one-hot; every integer column is accounted for; searches get along."""
    compiled = _compiled(_STONES, CompileOptions(stl=name))
    assert abs(_optimum(compiled) - _optimum(_compiled(_STONES, CompileOptions(stl="onehot")))) <= (
        _CLOSE
    ), "another optimum than one-hot"
    _check_integers(compiled)
    _check_derived(compiled)
    assert find_start(compiled) is not None, "the start search finds no plan"


def check_table_encoding(name: str) -> None:
    """One optimum with the hull of cells, by the solver and by the search; sound cell pairs."""
    compiled = _compiled(_PAIR, CompileOptions(link=name))
    optimum = _optimum(_compiled(_PAIR, CompileOptions(link="hull")))
    assert abs(_optimum(compiled) - optimum) <= _CLOSE * (1 + optimum), "another optimum than hull"
    found = run_strategy("links", compiled, get("highs"), _EXACT)
    assert found.status is Status.OPTIMAL
    assert found.objective is not None
    assert abs(found.objective - optimum) <= _CLOSE * (1 + optimum), "the search goes astray"
    for pair in compiled.layout.pairs:
        assert found.x is not None
        _check_pair(compiled, pair, found.x)


def _compiled(text: str, options: CompileOptions) -> Compiled:
    return compile_mission(loads(text), options)


def _optimum(compiled: Compiled) -> float:
    found = get("highs").solve(compiled.model, _EXACT)
    assert found.status is Status.OPTIMAL, found.status
    assert found.objective is not None
    return found.objective


def _check_integers(compiled: Compiled) -> None:
    """Integer columns are literals of nodes, alternatives of choices, or derived from those."""
    known = set(map(int, compiled.layout.derived))
    for one in compiled.layout.encoded:
        known.update(one.literals.values())
        known.update(column for _, pairs in one.choices for _, column in pairs)
    integers = set(map(int, np.flatnonzero(compiled.model.integrality)))
    missing = [compiled.model.col_name(c) for c in sorted(integers - known)]
    assert not missing, f"no receipt speaks of the integer columns {missing}"


def _check_derived(compiled: Compiled) -> None:
    """With the literals at 0 or 1, what is derived from them is whole by itself."""
    model = compiled.model
    best = get("highs").solve(model, _EXACT)
    assert best.x is not None
    lower, upper = model.col_lower.copy(), model.col_upper.copy()
    for one in compiled.layout.encoded:
        columns = [*one.literals.values(), *(c for _, pairs in one.choices for _, c in pairs)]
        lower[columns] = upper[columns] = np.round(best.x[columns])
    relaxed = _relaxed(compiled, lower, upper)
    derived = relaxed[compiled.layout.derived]
    assert np.abs(derived - np.round(derived)).max(initial=0.0) <= _CLOSE, "derived, yet not whole"


def _relaxed(compiled: Compiled, lower: Floats, upper: Floats) -> Floats:
    from dataclasses import replace

    model = replace(
        compiled.model, col_lower=lower, col_upper=upper,
        integrality=np.zeros_like(compiled.model.integrality),
    )  # fmt: skip
    found = get("highs").solve(model, _EXACT)
    assert found.x is not None, "the literals of an optimum allow no point"
    return found.x


def _check_pair(compiled: Compiled, pair: PairColumns, x: Floats) -> None:
    """Exactly one pair of cells, and both agents are in theirs."""
    share = x[pair.columns]
    assert share.shape == tuple(map(len, pair.cells)), "columns and cells differ in shape"
    assert abs(share.sum() - 1.0) <= _CLOSE, "cell pairs do not add up to 1"
    place = np.unravel_index(int(np.argmax(share)), share.shape)
    boxes = compiled.mission.channels["radio"].partition.boxes
    runs = compiled.decode(x)
    for name, cells, k in zip(pair.ends, pair.cells, place, strict=True):
        x_low, x_high, y_low, y_high = boxes[cells[int(k)]]
        px, py = runs.states[name][pair.step, :2]
        inside = x_low - _CLOSE <= px <= x_high + _CLOSE and y_low - _CLOSE <= py <= y_high + _CLOSE
        assert inside, f"{name} at step {pair.step} is not in the cell that its columns say"
