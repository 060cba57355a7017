"""Atoms that keep an agent's position within a box: the places of `visits.py`."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

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
    ranges = np.stack([np.array([axis.box[:, k] for axis in body.axes]).T for k in (0, 1)], axis=2)
    whole = np.stack([ranges[:, :, 0].min(axis=0), ranges[:, :, 1].max(axis=0)], axis=1)
    found: dict[int, Floats] = {}
    for number, atom in progress.atoms.items():
        if number in progress.asserted.get(atom.step, ()):
            continue
        box = _box(compiled, name, atom.node, atom.step, levels[atom.source], body)
        box = common(box + np.array([[-_LOOSE, _LOOSE]]), whole)
        if (box > whole).any() or (box < whole).any():
            found[number] = np.round(box, 9)
    return _shared(found, {n: ranges[progress.atoms[n].step] for n in found})


def _shared(
    found: Mapping[int, Floats], ranges: Mapping[int, Floats]
) -> tuple[dict[int, int], list[Floats]]:
    """The place of each atom: the smallest of all boxes that is the same within the range of its
    step. Faces that no run can cross by then are missing in the boxes of some steps."""
    known = {box.tobytes(): box for box in found.values()}
    every = sorted(known.values(), key=lambda box: float(np.ptp(box, axis=1).prod()))
    used: dict[int, int] = {}
    place: dict[int, int] = {}
    for number, box in found.items():
        range_ = ranges[number]
        here = common(box, range_)
        k = next(
            k for k, other in enumerate(every)
            if np.allclose(common(other, range_), here, rtol=0, atol=1e-9)
        )  # fmt: skip
        place[number] = used.setdefault(k, len(used))
    return place, [every[k] for k in used]


def common(a: Floats, b: Floats) -> Floats:
    """What two boxes (2, 2: axis, low and high) share; low above high where that is nothing."""
    return np.stack([np.maximum(a[:, 0], b[:, 0]), np.minimum(a[:, 1], b[:, 1])], axis=1)


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
