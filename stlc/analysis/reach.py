"""Interval reach sets of every agent at every step, forward from the start and backward.

From the forward sets (`forward.py`), bounds propagation on the dynamics equalities in both
directions and on linear rows that must hold, to a fixed number of sweeps: each equality
sum_j a_j y_j = 0 bounds y_i by the interval of the others (Savelsbergh, Preprocessing and probing
techniques for MIP, 1994). Every interval stays sound after any number of sweeps, and under
rounding; a range that doubles can't hold is a located error, never an empty interval.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from math import fsum, inf, isfinite

import numpy as np

from stlc.analysis.doubles import finite_size
from stlc.analysis.forward import ROUNDING, SLACK, Box, image, start_box
from stlc.analysis.ranges import Ranges
from stlc.analysis.unreachable import NoState
from stlc.arrays import Floats
from stlc.errors import InfeasibleError
from stlc.ir.nodes import Linear
from stlc.mission import Mission

_SWEEPS = 3
_Known = dict[bytes, list[Floats]]  # intervals around a step, before and after they are narrowed
_DUST = 4 * SLACK
_TINY = 1e-290  # coefficients up to here may come of products that lost digits by underflow


def propagate(boxes: Mapping[str, Box], musts: Sequence[tuple[Linear, float]]) -> None:
    """Narrow by the dynamics and by `musts`: predicates whose value is at least the number.

    Raises InfeasibleError naming the agent and step where an interval becomes empty.
    """
    known: dict[str, _Known] = {name: {} for name in boxes}
    for _ in range(_SWEEPS):
        before = [_width(box) for box in boxes.values()]
        for predicate, level in musts:
            _apply(boxes, predicate, level)
        for name, box in boxes.items():
            steps = range(len(box.u_lower))
            for step in (*steps, *reversed(steps)):
                _narrow(box, step, known[name])
            _check(box, "what the requirements demand" if musts else "its bounds")
        if np.allclose(before, [_width(box) for box in boxes.values()], rtol=0.0, atol=1e-6):
            return


def _width(box: Box) -> float:
    """Total length of all intervals (infinite ones count alike, and those beyond doubles): a sweep
    that changes nothing leaves it as it is."""
    with np.errstate(over="ignore"):
        widths = np.concatenate(
            [(box.x_upper - box.x_lower).ravel(), (box.u_upper - box.u_lower).ravel()]
        )
    return float(np.where(np.isfinite(widths), widths, 1e6).sum())


def _narrow(box: Box, step: int, known: _Known) -> None:
    """`_equalities`; intervals seen at another step are not worked out again, so that a long
    horizon costs as much as the steps at which something happens."""
    parts = (
        box.x_lower[step], box.u_lower[step], box.x_lower[step + 1],
        box.x_upper[step], box.u_upper[step], box.x_upper[step + 1],
    )  # fmt: skip
    law = box.agent.dynamics.number(step).to_bytes(4, "big")
    key = b"".join((law, *(part.tobytes() for part in parts)))
    if key not in known:
        _equalities(box, step)
        known[key] = [part.copy() for part in parts]
        return
    for part, values in zip(parts, known[key], strict=True):
        part[:] = values


@np.errstate(divide="ignore", invalid="ignore", over="ignore")  # to ends that say nothing
def _equalities(box: Box, step: int) -> None:
    """x_{t+1} = [A B] [x_t; u_t] + drift, both ways, all rows at once."""
    n, law = box.x_lower.shape[1], box.agent.dynamics.law(step)
    matrix = np.hstack([law.A, law.B])
    low = np.concatenate([box.x_lower[step], box.u_lower[step]])
    high = np.concatenate([box.x_upper[step], box.u_upper[step]])
    a = np.where(matrix == 0, 0.0, matrix * low)
    b = np.where(matrix == 0, 0.0, matrix * high)
    least, most = np.minimum(a, b), np.maximum(a, b)
    least[least == np.inf], most[most == -np.inf] = -np.inf, np.inf  # overflowed
    drift = law.drift
    next_low, next_high = box.x_lower[step + 1], box.x_upper[step + 1]
    size = (finite_size(least) + finite_size(most)).sum(axis=1) + np.abs(drift)
    rounding = ROUNDING * (size + finite_size(next_low) + finite_size(next_high))
    slack = drift - SLACK - rounding, drift + SLACK + rounding
    _meet_known(next_low, next_high, least.sum(axis=1) + slack[0], most.sum(axis=1) + slack[1])
    x = ((next_low - drift - rounding)[:, None] - _without(most)) / matrix
    y = ((next_high - drift + rounding)[:, None] - _without(least)) / matrix
    lower = np.where(matrix > _TINY, x, np.where(matrix < -_TINY, y, -np.inf))
    upper = np.where(matrix > _TINY, y, np.where(matrix < -_TINY, x, np.inf))
    lower = np.where(np.isnan(lower) | (lower == np.inf), -np.inf, lower).max(axis=0) - SLACK
    upper = np.where(np.isnan(upper) | (upper == -np.inf), np.inf, upper).min(axis=0) + SLACK
    low, high = np.maximum(low, lower), np.minimum(high, upper)
    box.x_lower[step], box.u_lower[step] = low[:n], _whole(low[n:], box, np.ceil)
    box.x_upper[step], box.u_upper[step] = high[:n], _whole(high[n:], box, np.floor)


def _meet_known(lower: Floats, upper: Floats, low: Floats, high: Floats) -> None:
    """Intersect [lower, upper] with [low, high] in place, but for ends at which arithmetic broke.

    A lower end of +inf, an upper one of -inf and NaN only come of overflow: they say nothing.
    """
    np.copyto(lower, np.maximum(lower, low), where=low < np.inf)
    np.copyto(upper, np.minimum(upper, high), where=high > -np.inf)


def _whole(values: Floats, box: Box, rounding: np.ufunc) -> Floats:
    if not box.agent.integer_inputs:
        return values
    slack = 1e-6 if rounding is np.floor else -1e-6
    return np.asarray(rounding(values + slack))


def _without(parts: Floats) -> Floats:
    """Row sums with each entry left out in turn; infinite entries are counted, not subtracted."""
    infinite = np.isinf(parts)
    finite = np.where(infinite, 0.0, parts)
    total, count = finite.sum(axis=1, keepdims=True), infinite.sum(axis=1, keepdims=True)
    sign = np.where(infinite, parts, 0.0).max(axis=1, keepdims=True, initial=-np.inf)
    worst = np.where(sign > 0, np.inf, -np.inf)
    return np.where(count - infinite > 0, worst, total - finite)


def _apply(boxes: Mapping[str, Box], predicate: Linear, level: float) -> None:
    """sum c y + constant >= level: each c_i y_i is at least level - constant - max of the rest."""
    spans = []
    for signal, value in predicate.terms:
        low, high = boxes[signal.owner].interval(signal.role, signal.shift, signal.index)
        spans.append(max(value * low, value * high))
    sizes = [abs(level), abs(predicate.constant), *map(abs, spans)]
    if not isfinite(sum(sizes)):
        return
    total, rounding = fsum(spans), ROUNDING * fsum(sizes)  # other orders would add up otherwise
    for (signal, value), most in zip(predicate.terms, spans, strict=True):
        edge = (level - predicate.constant - (total - most)) / value
        slack = SLACK * max(1.0, abs(edge)) + rounding / abs(value)
        if abs(value) <= _TINY or not isfinite(edge):
            continue
        limits = (edge - slack, inf) if value > 0 else (-inf, edge + slack)
        boxes[signal.owner].narrow(signal.role, signal.shift, signal.index, *limits)


def _check(box: Box, why: str) -> None:
    """InfeasibleError where an interval is empty by more than a solver's tolerance."""
    gap = _gap(box.x_lower, box.x_upper)
    if gap.size and gap.max() > 1e-6:
        step, index = np.unravel_index(int(gap.argmax()), gap.shape)
        name = box.agent.dynamics.states[int(index)]
        raise NoState(
            box.agent.name,
            f"agent '{box.agent.name}' cannot keep {why}: no value of {name} is left at "
            f"step {int(step)}",
        )
    u_gap = _gap(box.u_lower, box.u_upper)
    if u_gap.size and u_gap.max() > 1e-6:
        raise InfeasibleError(f"agent '{box.agent.name}' has no input within its bounds")


def _gap(lower: Floats, upper: Floats) -> Floats:
    """How far intervals are from holding anything, beyond rounding; -inf where nobody knows."""
    with np.errstate(over="ignore", invalid="ignore"):
        gap = lower - upper - ROUNDING * finite_size(lower)
    return np.where(np.isnan(gap), -np.inf, gap)


def ranges_of(box: Box) -> Ranges:
    """Freeze; intervals that rounding turned over collapse to their middle."""
    x_low, x_high = _ordered(tidy(box.x_lower), tidy(box.x_upper))
    u_low, u_high = _ordered(tidy(box.u_lower), tidy(box.u_upper))
    position = position_ranges(box.agent.dynamics.space, x_low, x_high)
    return Ranges(x_low, x_high, u_low, u_high, *position)


def tidy(values: Floats) -> Floats:
    """Ends without the dust of rounding: 1.000000001 becomes 1.

    A solver's presolve that takes a column for integer must find integer ends. Moves an end by
    far less than any solver's tolerance.
    """
    with np.errstate(over="ignore", invalid="ignore"):
        near = np.round(values, 6)
        dust = np.abs(values - near) <= _DUST * np.maximum(1.0, np.abs(values))
    return np.where(dust, near, values)


def position_ranges(space: Floats | None, lower: Floats, upper: Floats) -> tuple[Floats, Floats]:
    """Intervals (T+1, 3) of the place `space` @ x of an agent; zeros for one that is nowhere."""
    if space is None:
        nowhere = np.zeros((len(lower), 3))
        return nowhere, nowhere
    ends = [image(space, low, high) for low, high in zip(lower, upper, strict=True)]
    return np.array([e[0] for e in ends]), np.array([e[1] for e in ends])


def _ordered(lower: Floats, upper: Floats) -> tuple[Floats, Floats]:
    crossed = lower > upper
    with np.errstate(over="ignore", invalid="ignore"):
        middle = (lower + upper) / 2
    return np.where(crossed, middle, lower), np.where(crossed, middle, upper)


def reach(
    mission: Mission,
    musts: Sequence[tuple[Linear, float]] = (),
    within: Mapping[str, Ranges] | None = None,
) -> dict[str, Ranges]:
    """Ranges of all agents, narrowed by predicates that must hold and by earlier ranges."""
    boxes = {name: start_box(agent, mission) for name, agent in mission.agents.items()}
    for name, known in (within or {}).items():
        box = boxes[name]
        box.x_lower = np.maximum(box.x_lower, known.state_lower)
        box.x_upper = np.minimum(box.x_upper, known.state_upper)
        box.u_lower = np.maximum(box.u_lower, known.input_lower)
        box.u_upper = np.minimum(box.u_upper, known.input_upper)
    propagate(boxes, musts)
    return {name: ranges_of(box) for name, box in boxes.items()}
