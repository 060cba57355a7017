"""How soon an agent can be at one visit after another."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from stlc.arrays import Bools, Floats, Ints
from stlc.solve.relaxation.problem import Body

_EDGE = 1e-6
_FOREVER = 1 << 30


@dataclass(frozen=True, slots=True)
class Pace:
    """need[a][b]: steps from a visit of kind a to one of kind b at the least; can_be[b][t]:
    whether there may be one at step t."""

    need: list[list[int]]
    can_be: list[list[bool]]

    @staticmethod
    def of(body: Body, boxes: Floats) -> Pace:
        """Of kinds by their boxes (kinds, 2, 2: axis, low and high), the start the last."""
        return Pace(_steps(body, boxes).tolist(), _can_be(body, boxes).tolist())

    def may(self, before: int, s: int, kind: int, t: int) -> bool:
        """Whether there may be a visit at step t after one of another kind at step s."""
        return t - s >= self.need[before][kind] and self.can_be[kind][t]


def _steps(body: Body, boxes: Floats) -> Ints:
    """Steps (kinds, kinds) between boxes by the rates along the axes and the speed polygon."""
    low = boxes[None, :, :, 0] - boxes[:, None, :, 1]
    high = boxes[None, :, :, 1] - boxes[:, None, :, 0]
    far = np.maximum(np.maximum(low, -high) - _EDGE, 0.0)
    rates = np.array([max(np.abs(axis.box[:, 2:]).max(), 1e-12) for axis in body.axes])
    need = (far / rates).max(axis=2)
    start = np.array([axis.start[1] for axis in body.axes])
    for *normal, c in body.faces:
        n = np.array(normal)
        least = np.minimum(n * low, n * high).sum(axis=2) - _EDGE
        most = np.full((len(boxes), 1), c)
        most[-1] = max(c, float(n @ start))
        need = np.maximum(need, np.where(least > 0, least / np.maximum(most, 1e-12), 0.0))
    return np.asarray(np.maximum(np.ceil(np.minimum(need, _FOREVER) - _EDGE), 1), np.int64)


def _can_be(body: Body, boxes: Floats) -> Bools:
    """(kinds, T+1): whether a box meets the positions of a step."""
    found = np.ones((len(boxes), len(body.axes[0].box)), bool)
    for d, axis in enumerate(body.axes):
        found &= boxes[:, d, :1] <= axis.box[None, :, 1] + _EDGE
        found &= boxes[:, d, 1:] >= axis.box[None, :, 0] - _EDGE
    return found
