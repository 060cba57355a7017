"""The run of a grid (`play.py`) that its bound is of: where a cheap plan may be looked for."""

from __future__ import annotations

import numpy as np

from stlc.arrays import Floats
from stlc.solve.routes.play import Play
from stlc.solve.routes.progress import Open

_ROUNDING = 1e-9


def traced(play: Play) -> Floats | None:
    """Boxes (2, T+1, 2: low and high, steps, axes) [m] around the cheapest run that the last
    `bound` of a grid has found; None where it has found none below `most`."""
    last = len(play.board.lower) - 1
    if len(play.layers) <= last or not play.finished().any():
        return None
    opens, where, which, cost = play.layers[-1]
    k = int(np.flatnonzero(play.finished())[np.argmin(cost[play.finished()])])
    found = [int(where[k])]
    state = (opens[which[k]], found[0], float(cost[k]))
    for t in range(last, 0, -1):
        state = _before(play, t, *state)
        found.append(state[1])
    return play.board.ends[:, np.array(found[::-1])]


def _before(play: Play, t: int, open_: Open, point: int, cost: float) -> tuple[Open, int, float]:
    """A state of step t - 1 from which a state of step t was come to at its cost."""
    opens, where, which, before = play.layers[t - 1]
    columns = play.board.shape[1]
    moves = np.column_stack(
        [point // columns - where // columns, point % columns - where % columns]
    )
    way = play.board.way(where, np.array([point]))
    near = (moves >= play.board.moves.min(axis=0)) & (moves <= play.board.moves.max(axis=0))
    same = np.abs(before + way - cost) <= _ROUNDING * (1 + abs(cost))
    own = np.flatnonzero(near.all(axis=1) & same)
    fine, labels, label = play.board.classes(t, where[own], moves[own])
    memos: dict[int, dict[int, int]] = {}
    for k in np.flatnonzero(fine).tolist():
        n, was = int(label[k]), opens[which[own[k]]]
        if play.board.progress.after(was, t, labels[n], memos.setdefault(n, {})) == open_:
            return was, int(where[own[k]]), float(before[own[k]])
    raise AssertionError("a state of the grid without one before it")
