"""Atoms that keep an agent's position within a box: the places of `visits.py`."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from stlc.analysis.link_tables import link_of
from stlc.arrays import Floats
from stlc.ir.nodes import And, Linear, Link, Node, Not, Or, Role
from stlc.milp.compile import Compiled
from stlc.solve.relaxation.problem import Body
from stlc.solve.routes.moves import LevelOf
from stlc.solve.routes.progress import Progress

_LOOSE = 1e-6  # m: what the solver and the verifier let pass
_ANY = np.array([[-np.inf, np.inf], [-np.inf, np.inf]])


def places_of(
    compiled: Compiled, name: str, progress: Progress, levels: Sequence[LevelOf], body: Body
) -> tuple[dict[int, int], list[Floats]]:
    """The place of each atom that is one, and the places' boxes (2, 2: axis, low and high)."""
    ranges = np.array([[axis.box[:, 0].min(), axis.box[:, 1].max()] for axis in body.axes])
    known: dict[bytes, int] = {}
    boxes: list[Floats] = []
    place: dict[int, int] = {}
    for number, atom in progress.atoms.items():
        if number in progress.asserted.get(atom.step, ()):
            continue
        box = _box(compiled, name, atom.node, atom.step, levels[atom.source], body)
        box = np.stack([np.maximum(box[:, 0] - _LOOSE, ranges[:, 0]),
                        np.minimum(box[:, 1] + _LOOSE, ranges[:, 1])], axis=1)  # fmt: skip
        if (box <= ranges).all() and (box >= ranges).all():
            continue
        key = np.round(box, 9).tobytes()
        if key not in known:
            known[key] = len(boxes)
            boxes.append(box)
        place[number] = known[key]
    return place, boxes


def _box(
    compiled: Compiled, name: str, node: Node, step: int, level: LevelOf, body: Body
) -> Floats:
    """Where the agent's position is at `step` if a formula holds, at the most."""
    match node:
        case And(args=args):
            found = [_box(compiled, name, arg, step, level, body) for arg in args]
            low, high = (np.array([b[:, k] for b in found] or [_ANY[:, k]]) for k in (0, 1))
            return np.stack([low.max(axis=0), high.min(axis=0)], axis=1)
        case Or(args=args) if args:
            found = [_box(compiled, name, arg, step, level, body) for arg in args]
            found = [b for b in found if (b[:, 0] <= b[:, 1]).all()] or found
            low, high = (np.array([b[:, k] for b in found]) for k in (0, 1))
            return np.stack([low.min(axis=0), high.max(axis=0)], axis=1)
        case Linear(terms=((signal, weight),)):
            where = {axis.state: d for d, axis in enumerate(body.axes)}
            box, d = _ANY.copy(), where.get(signal.index)
            own = signal.owner == name and signal.role is Role.STATE and signal.shift == step
            if own and d is not None:
                box[d, 0 if weight > 0 else 1] = (level(node.unit) - node.constant) / weight
            return box
        case Link() | Not(arg=Link()):
            return _link_box(compiled, name, node, step, level(""))
        case _:
            return _ANY


def _link_box(compiled: Compiled, name: str, node: Node, step: int, level: float) -> Floats:
    """The box around the cells where a link with a station holds."""
    assert isinstance(node, Link | Not)
    link = link_of(node)
    ends = {link.sender, link.receiver}
    if link.shift != step or name not in ends or len(ends & compiled.mission.agents.keys()) != 1:
        return _ANY
    found = compiled.channels.thresholds(link)
    table = np.asarray(found.low if isinstance(node, Link) else -found.high)
    partition = compiled.mission.channels[link.channel].partition
    fine = np.flatnonzero(table.ravel() >= level - _LOOSE)
    if table.ndim != 1 or table.size != len(partition.low) or not len(fine):
        return _ANY
    return np.stack([partition.low[fine].min(axis=0), partition.high[fine].max(axis=0)], axis=1)
