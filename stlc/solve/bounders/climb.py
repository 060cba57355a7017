"""Sweeps of an agreement in turns with subgradient steps of its pairs' potentials."""

from __future__ import annotations

import numpy as np

from stlc.arrays import Floats
from stlc.solve import tuning
from stlc.solve.bounders.agreement import Agreement, Pair
from stlc.solve.restricted.session import Session


def climb(agreement: Agreement, rounds: int, session: Session, cutoff: float, whole: bool) -> None:
    """Sweeps and steps of the potentials. Ends early above the cutoff and when stopped, after a
    forward sweep. `whole`: what is found is a bound on all plans."""
    last, until = agreement.prepare(), session.seconds + tuning.TEAM.climb_seconds
    gap = tuning.TEAM.later_step * (cutoff - last) if np.isfinite(cutoff) else np.inf
    if whole:
        session.raise_bound(min(last, session.cutoff))
    step = min(gap, tuning.TEAM.first_step * abs(last)) / max(1, len(agreement.pairs))
    direction: dict[Pair, Floats] = {}
    for k in range(rounds):
        value = agreement.forward(cutoff)
        if whole:
            session.raise_bound(min(agreement.bound, session.cutoff))
        late = session.seconds > until or session.stopped()
        if k == rounds - 1 or late or agreement.bound >= cutoff:
            break
        step *= 1.1 if value - last > 0.2 * step * len(agreement.pairs) else 0.75
        last, change = value, {}
        for p in agreement.pairs:
            direction[p] = agreement.slopes(p) + tuning.TEAM.momentum * direction.get(p, 0.0)
            size = float((direction[p] ** 2).sum()) * (1 - tuning.TEAM.momentum)
            change[p] = step / max(size, 1e-9) * direction[p]
        agreement.move(change)
        agreement.backward()
