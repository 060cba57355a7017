"""What is still to be done, by when and where: read off open obligations."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np

from stlc.arrays import Floats
from stlc.solve.routes.destinations import Places, Window
from stlc.solve.routes.progress import Open


@dataclass(frozen=True, slots=True, eq=False)
class Agenda:
    """due (k, places): by when each progress has to be at each place, infinite for need not;
    since (places,): from when on it counts; stays (k,): steps that obligations still last."""

    due: Floats
    since: Floats
    stays: Floats

    @staticmethod
    def of(places: Places, opens: Sequence[Open], step: int) -> Agenda:
        """Of each progress after a step, with what starts only later."""
        later = [n for t, ns in places.progress.starting.items() if t > step for n in ns]
        future, own = _windows(places, later), [_windows(places, open_) for open_ in opens]
        due = np.full((len(opens), len(places.ways)), np.inf)
        since = np.full(len(places.ways), np.inf)
        for row, windows in zip(due, own, strict=True):
            for window in (*future, *windows):
                row[window.place] = min(window.by, row[window.place])
                since[window.place] = min(window.since, since[window.place])
        stays = np.array([sum(w.done - step - 1 for w in windows) for windows in own], float)
        return Agenda(due, since, stays)


def _windows(places: Places, numbers: Iterable[int]) -> list[Window]:
    found = (places.window(number) for number in numbers)
    return [w for w in found if not places.masks[w.place].all()]
