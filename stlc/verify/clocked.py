"""What changes with the clock by its numbers alone, such as a moving obstacle, judged in one go.

Each case of a `Timed` formula holds at one step, so that judging every case over the whole run
takes the square of its length.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import reduce

import numpy as np

from stlc.ir.nodes import And, Linear, Node, Or
from stlc.verify.trace import Array, Trace

Scaled = Callable[[Array, str], Array]


def by_the_clock(cases: Sequence[Node], trace: Trace, scaled: Scaled) -> Array | None:
    """Robustness (L,) of `cases[t]` at each step t, the last one staying.

    None where the cases are not all made alike of predicates on the same signals.
    """
    first = cases[0]
    if any(type(c) is not type(first) or c.norms is not None for c in cases):
        return None
    if isinstance(first, And | Or):
        return _joined(first, cases, trace, scaled)
    if not isinstance(first, Linear):
        return None
    predicates = [c for c in cases if isinstance(c, Linear)]
    signals = [s for s, _ in first.terms]
    if any([s for s, _ in c.terms] != signals or c.unit != first.unit for c in predicates):
        return None
    columns = [trace.signal(s) for s in signals]
    length = min((len(column) for column in columns), default=trace.length)
    at = np.minimum(np.arange(length), len(cases) - 1)
    across = (slice(None), None) if trace.many else slice(None)  # the same for every run
    total = np.array([c.constant for c in predicates], dtype=np.float64)[at][across]
    factors = np.array([[f for _, f in c.terms] for c in predicates], dtype=np.float64)
    for k, column in enumerate(columns):
        total = total + factors[at, k][across] * column[:length]
    return scaled(total, first.unit)


def _joined(first: And | Or, cases: Sequence[Node], trace: Trace, scaled: Scaled) -> Array | None:
    """Conjunctions (or disjunctions) argument by argument; None if their widths differ."""
    if not first.args or any(len(c.children) != len(first.args) for c in cases):
        return None
    parts = []
    for args in zip(*(c.children for c in cases), strict=True):
        part = by_the_clock(args, trace, scaled)
        if part is None:
            return None
        parts.append(part)
    shortest = min(map(len, parts))
    join = np.minimum if isinstance(first, And) else np.maximum
    return np.asarray(reduce(join, [part[:shortest] for part in parts]))
