"""The strategy `routes`: a first plan by beams over states and progress, bettered in tubes.

Most missions of one agent end in the plain solve ahead of it: the searches are imported after that.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cache, partial
from typing import TYPE_CHECKING

import numpy as np

from stlc.backends.base import Solution
from stlc.solve import tuning
from stlc.solve.routes.glance import glance
from stlc.solve.strategy import Work

if TYPE_CHECKING:
    from stlc.solve.routes.motion_bounds import Bounds


def plan_routes(work: Work) -> Work | Solution:
    """A first plan by ways from visit to visit or else by beams, better ones near it, bounds; where
    a plan is known, or found at a glance, bounds first."""
    known = cache(partial(_bounds, work))

    def goes_on(value: float) -> bool:
        found = known()
        return found is None or not found.promises(value, tuning.ROUTES.promise)

    begun = _glanced(work, goes_on)
    if begun is None or isinstance(begun, Solution):
        return begun or work
    from stlc.solve.routes.first_plans import bounded, planned

    bounds = known()
    if bounds is not None and bounds.hopeless():
        return begun.without_plan("ways from visit to visit")
    if begun.x is None:
        return planned(begun, bounds)
    if bounds is None:
        return begun
    return bounded(begun, bounds)


def _bounds(work: Work) -> Bounds | None:
    """What can be bound, None for nothing."""
    from stlc.solve.routes.motion_bounds import Bounds

    moment = work.deadline.share(tuning.ROUTES.share, tuning.ROUTES.seconds)
    bounds = Bounds.of(work.compiled, moment.over)
    return None if bounds is None or bounds.says_nothing() else bounds


def _glanced(work: Work, goes_on: Callable[[float], bool]) -> Work | Solution | None:
    """The work after a plain solve. Of one agent it goes on for a while where it has a plan, and
    then to its end where nothing can be bound well. A team has none after one in vain (`brief`)."""
    soon = work.deadline.share(tuning.ROUTES.share, tuning.ROUTES.glance)
    if len(work.compiled.states) == 1:
        return glance(work, soon, work.deadline.within(tuning.ROUTES.known_glance), goes_on)
    return work if np.isfinite(work.bound) else glance(work, soon, soon)
