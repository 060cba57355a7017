"""A plain solve ahead of a search: over soon where it finds no plan, left to work where it does."""

from __future__ import annotations

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
    goes_on: Callable[[], bool]
    seen: bool = field(init=False)

    def __post_init__(self) -> None:
        self.seen = self.work.x is not None

    def see(self, progress: Progress) -> None:
        self.seen = self.seen or progress.incumbent is not None
        if self.work.options.on_progress is not None:
            self.work.options.on_progress(progress)

    def stop(self) -> bool:
        if self.work.deadline.over():
            return True
        return self.late.over() and not self.goes_on() if self.seen else self.soon.over()


def glance(
    work: Work, soon: Deadline, late: Deadline, goes_on: Callable[[], bool] = lambda: False
) -> Work | Solution | None:
    """The work after a plain solve of the whole model: until `soon`, where there is a plan until
    `late`, and on to its end where `goes_on` says so then.

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
