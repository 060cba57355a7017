"""A plain solve ahead of a search: over soon where it finds no plan, left to work where it does."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field, replace

from stlc.backends.base import Capability, Progress, Solution, Status
from stlc.errors import SolverError
from stlc.solve.deadline import Deadline
from stlc.solve.strategy import Work


@dataclass(slots=True, eq=False)
class _Watch:
    """Ends a solve at `soon` without a plan, at `late` with one unless `goes_on` says otherwise."""

    work: Work
    soon: Deadline
    late: Deadline
    goes_on: Callable[[float], bool]
    best: float = field(init=False)
    _decided: bool | None = None

    def __post_init__(self) -> None:
        self.best = self.work.value

    def see(self, progress: Progress) -> None:
        if progress.incumbent is not None and progress.objective is not None:
            self.best = min(self.best, progress.objective)
        if self.work.options.on_progress is not None:
            self.work.options.on_progress(progress)

    def stop(self) -> bool:
        if self.work.deadline.over():
            return True
        if not math.isfinite(self.best):
            return self.soon.over()
        if self._decided is None and self.late.over():
            self._decided = not self.goes_on(self.best)
        return bool(self._decided)


def glance(
    work: Work,
    soon: Deadline,
    late: Deadline,
    goes_on: Callable[[float], bool] = lambda value: False,
) -> Work | Solution | None:
    """The work after a plain solve of the whole model: until `soon`, where there is a plan until
    `late`, and on to its end where `goes_on` of what the plan costs says so then.

    A Solution where that is proven or the time is over; None where it says infeasible, which is to
    be settled elsewhere, or fails.
    """
    if soon.over():
        return work
    watch = _Watch(work, soon, late, goes_on)
    told = work.can(Capability.INCUMBENTS | Capability.CANCEL)
    asked = replace(work.asked(), on_progress=None)
    if told:
        asked = replace(asked, on_progress=watch.see, should_stop=watch.stop)
    else:
        asked = soon.bind(asked)
    try:
        found = work.backend.solve(work.compiled.model, asked)
    except SolverError:
        return None
    if found.status is Status.INFEASIBLE:
        return None
    if found.status is Status.OPTIMAL or work.deadline.over():
        return work.concluded(found)
    work = work if found.bound is None else work.with_bound(found.bound)
    return work.with_point(found.x, "")
