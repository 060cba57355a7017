"""Two sets of runs of the same problems: what got worse by more than the runs' own noise."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

from stlc.bench.groups import Group
from stlc.sense import Sense

_NOISE = 0.25  # relative, assumed where one repeat says nothing of it
_LEAST_NOISE = 0.10
_LEAST_SECONDS = 0.1


@dataclass(frozen=True, slots=True)
class Change:
    """One problem under one configuration, before and now. `kind` is regression, improvement,
    larger or disagreement; `ratio` is now / before, of time (or rows for `larger`)."""

    kind: str
    suite: str
    problem: str
    label: str
    text: str
    ratio: float | None = None


def changes(now: Iterable[Group], before: Iterable[Group]) -> list[Change]:
    """Worst first. Only problems with the same text, under the same configuration, compare."""
    old = {_name(group): group for group in before}
    found = []
    for group in now:
        other = old.get(_name(group))
        if other is not None and other.first.digest == group.first.digest:
            found += _changes(group, other)
    order = ("disagreement", "regression", "larger", "improvement")
    return sorted(found, key=lambda c: (order.index(c.kind), -(c.ratio or 0.0)))


def _name(group: Group) -> tuple[str, str, str]:
    return group.first.suite, group.first.problem, group.first.label


def noise(group: Group) -> float:
    """Half the spread of the times relative to their median; 0.25 for a single run."""
    if len(group.runs) < 2:
        return _NOISE
    low, high = group.spread
    return max(_LEAST_NOISE, (high - low) / 2 / max(group.seconds, 1e-9))


def _changes(now: Group, before: Group) -> list[Change]:
    found = [*_optimum(now, before), *_proof(now, before), *_size(now, before)]
    if now.solved and before.solved:
        found += _time(now, before)
    return found


def _change(kind: str, now: Group, text: str, ratio: float | None = None) -> Change:
    return Change(kind, *_name(now), text, ratio)


def _optimum(now: Group, before: Group) -> list[Change]:
    """Two proven optima further apart than both gaps and 1e-6 (relative) allow: one is wrong."""
    a, b = now.minimised, before.minimised
    if now.status != "optimal" or before.status != "optimal" or a is None or b is None:
        return []
    allowed = 1e-6 + now.first.gap_limit + before.first.gap_limit
    if abs(a - b) <= allowed * max(1.0, abs(a), abs(b)):
        return []
    own = Sense(now.first.sense).own
    return [
        _change("disagreement", now, f"the proven optimum was {own(b):.9g} and is {own(a):.9g}")
    ]


def _proof(now: Group, before: Group) -> list[Change]:
    if now.solved == before.solved:
        return []
    kind = "regression" if before.solved else "improvement"
    return [_change(kind, now, f"it was {before.status} and is {now.status}")]


def _size(now: Group, before: Group) -> list[Change]:
    a, b = now.value("rows"), before.value("rows")
    if not a or not b or a <= 1.01 * b:
        return []
    return [_change("larger", now, f"{b:.0f} rows became {a:.0f}", a / b)]


def _time(now: Group, before: Group) -> list[Change]:
    margin = max(noise(now), noise(before))
    a, b = now.seconds, before.seconds
    ratio = a / max(b, 1e-9)
    text = f"{b:.2f} s became {a:.2f} s (noise {margin:.0%})"
    if a > b * (1 + margin) + _LEAST_SECONDS:
        return [_change("regression", now, text, ratio)]
    if b > a * (1 + margin) + _LEAST_SECONDS:
        return [_change("improvement", now, text, ratio)]
    return []
