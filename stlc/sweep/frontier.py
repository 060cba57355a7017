"""The trade-off curve of two costs, by the epsilon constraint (Haimes, Lasdon and Wismer, 1971).

The ends are lexicographic: the least of one cost, and with it the least of the other. Between them
the second cost is held at a level; the first is minimised there, and then the second with the first
held, so that no plan is better in one and as good in the other. Levels bisect the box in which most
of the curve is still unknown: a step of the curve takes few of them, a slope is followed evenly.
Every value is that of a certified, verified plan, and a bound says what no plan does better.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

from stlc.sweep.ask import Answer, Question

Ask = Callable[[Question, Answer | None], Answer]

SLACK = 1e-6
"""What a cap leaves above a value reached, relative above 1: the tolerance of certification."""


@dataclass(frozen=True, slots=True)
class Trade:
    """A plan: its `first` and `second` cost. No plan whose second cost is at most `level` has a
    first cost below `bound`; `proven` where that is this one's, to within the gap."""

    first: float
    second: float
    level: float
    bound: float | None
    proven: bool
    answer: Answer


@dataclass(frozen=True, slots=True)
class Frontier:
    """Trades by rising second cost; where there is none, `why` is the answer that says so."""

    trades: tuple[Trade, ...]
    why: Answer | None = None


def frontier(question: Question, costs: tuple[str, str], count: int, ask: Ask) -> Frontier:
    """The curve by its two ends and `count` - 2 levels between them; `ask` answers, or knows.

    Levels that lead to one plan are one point. What isn't found within the limits is left out.
    """
    first, second = costs
    low = _then(question, second, first, None, None, ask)
    if isinstance(low, Answer):
        return Frontier((), low)
    high = _then(question, first, second, None, low.answer, ask)
    if isinstance(high, Answer):
        return Frontier((), high)
    left = Trade(low.second, low.first, low.first, low.answer.bound, low.proven, low.answer)
    curve = _joined([left], high)
    size = _box(left, high)
    for _ in range(count - 2):
        at = max(range(len(curve) - 1), key=lambda k: _box(*curve[k : k + 2]), default=0)
        if len(curve) < 2 or _box(*curve[at : at + 2]) <= SLACK * size:
            break
        here, there = curve[at : at + 2]
        level = (here.level + there.second) / 2
        found = _then(question, first, second, level, here.answer, ask)
        if isinstance(found, Answer):
            break
        curve = [*curve[:at], *_joined([here], found), *curve[at + 1 :]]
    return Frontier(tuple(curve))


def _box(here: Trade, there: Trade) -> float:
    """Area in which the curve may still run between two points."""
    return max(there.second - here.level, 0.0) * max(here.first - there.first, 0.0)


def _joined(curve: list[Trade], found: Trade) -> list[Trade]:
    """With a point further on; one that is no better in the first cost raises the last one's
    level: up to there the last is best."""
    last = curve[-1]
    if found.first < last.first - 2 * _room(last.first):
        return [*curve, found]
    level = max(last.level, found.level)
    return [*curve[:-1], replace(last, level=level, proven=last.proven and found.proven)]


def _then(
    question: Question,
    one: str,
    other: str,
    level: float | None,
    start: Answer | None,
    ask: Ask,
) -> Trade | Answer:
    """The least of `one` with `other` at most at a level, then the least of `other` with it."""
    cap = None if level is None else (other, level)
    best = ask(replace(question, minimise=one, cap=cap), start)
    if not best.found or best.costs is None:
        return best
    value = best.costs[one]
    held = ask(replace(question, minimise=other, cap=(one, value + _room(value))), best)
    if not held.found or held.costs is None:
        return held
    proven = best.status == "optimal" and held.status == "optimal"
    top = held.costs[other] if level is None else level
    return Trade(held.costs[one], held.costs[other], top, best.bound, proven, held)


def _room(value: float) -> float:
    return SLACK * max(1.0, abs(value))
