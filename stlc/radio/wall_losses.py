"""Losses of walls among the coefficients of a fit's mean."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from stlc.radio.problem import FIXED
from stlc.radio.samples import Samples
from stlc.radio.walls import Walls

Array = NDArray[np.float64]
Open = tuple[Walls, NDArray[np.intp]]
"""Walls, and the numbers of those whose loss is estimated."""


def losses_of(walls: Open | None, coefficients: Array) -> Walls | None:
    """Walls with the losses that are among the mean's coefficients, 0 for those not open."""
    if walls is None:
        return None
    loss = np.zeros(len(walls[0]))
    loss[walls[1]] = coefficients[FIXED : FIXED + len(walls[1])]
    return walls[0].with_loss(loss)


def wall_errors(walls: Open | None, covariance: Array) -> tuple[tuple[str, float], ...]:
    """Standard errors [dB] of the losses, from the covariance of the mean's coefficients."""
    if walls is None:
        return ()
    spread = np.sqrt(np.diag(covariance)[FIXED : FIXED + len(walls[1])])
    return tuple(
        (f"wall {walls[0].names[k]}", float(e)) for k, e in zip(walls[1], spread, strict=True)
    )


def wall_notes(samples: Samples, walls: Open | None) -> list[str]:
    """Walls that the samples say nothing of, or that cost nothing by them."""
    if walls is None:
        return []
    crossed = list(map(bool, walls[0].crossed(samples.links).sum(axis=0)))
    idle = [n for n, hit in zip(walls[0].names, crossed, strict=True) if not hit]
    free = [n for k, n in enumerate(walls[0].names) if crossed[k] and k not in walls[1]]
    notes = [f"no sample crosses the walls {', '.join(idle)}: taken for 0 dB"] if idle else []
    if free:
        notes.append(f"the samples give the walls {', '.join(free)} no loss: taken for 0 dB")
    return notes
