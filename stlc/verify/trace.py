"""A sampled run, as formulas are judged on it."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from stlc.ir.nodes import Link, Role, Signal

Array = NDArray[np.float64]
LinkEvaluator = Callable[[Link, bool], Array]


@dataclass(frozen=True, slots=True, eq=False)
class Trace:
    """A sampled run.

    `length` steps; `signals[owner, role]` is (steps, width), indexed by `Signal.index` (inputs
    have one row less than states). `link(predicate, positive)` gives the robustness of a link
    predicate at steps 0..length-1, its `shift` left out; None when the run has no radio. What is
    known as an interval is judged by its lower end where the predicate counts positively and by
    its upper end under a negation, so that the robustness of the whole is a lower bound.

    `spread` is how far signals may be off, whatever happens: a predicate is judged by the least
    that it may be where it counts positively, by the most under a negation. The states of `discs`
    are together within a disc of that radius, each of the others by itself.

    Many runs at once are one more axis, the last: signals (steps, width, runs) and links
    (steps, runs), with 1 in place of the number of runs where all are alike; then `many` is true
    and robustness is (L, runs) or (L, 1).
    """

    length: int
    signals: Mapping[tuple[str, Role], Array] = field(default_factory=dict)
    link: LinkEvaluator | None = None
    many: bool = False
    spread: Mapping[tuple[str, Role], Array] = field(default_factory=dict)
    discs: Collection[str] = ()

    def signal(self, signal: Signal) -> Array:
        """Values from step `signal.shift` on. Raises KeyError for an unknown signal."""
        return self.signals[signal.owner, signal.role][signal.shift :, signal.index]

    def off(self, terms: Sequence[tuple[Signal, float]], positive: bool) -> Array | float:
        """How much a sum of signals may be less, or more under a negation, by the `spread`."""
        widths = []
        for owner, role, shift, factors in self._grouped(terms):
            width = self.spread[owner, role][shift:]
            if owner in self.discs and role is Role.STATE:
                widths.append(float(np.linalg.norm(factors)) * width[:, 0])
            else:
                widths.append(width @ np.abs(factors))
        if not widths:
            return 0.0
        shortest = min(len(self.signal(s)) for s, _ in terms)
        total = np.sum([width[:shortest] for width in widths], axis=0)
        return np.asarray(total if positive else -total)

    def _grouped(
        self, terms: Sequence[tuple[Signal, float]]
    ) -> Iterator[tuple[str, Role, int, Array]]:
        """(owner, role, shift, factors of all its signals) of what has a spread."""
        found: dict[tuple[str, Role, int], Array] = {}
        for s, factor in terms:
            width = self.spread.get((s.owner, s.role))
            if width is not None:
                row = found.setdefault((s.owner, s.role, s.shift), np.zeros(width.shape[1]))
                row[s.index] += factor
        for (owner, role, shift), factors in found.items():
            yield owner, role, shift, factors

    def filled(self, length: int, value: float) -> Array:
        """`value` at `length` steps, for whatever number of runs."""
        return np.full((length, 1) if self.many else length, value)
