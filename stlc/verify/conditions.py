"""`swept` conditions on states and inputs of any agents, in continuous time.

A condition is a minimum and maximum of linear forms of signals and of Euclidean lengths of such;
along the paths of the states each form is quadratic on every piece, so that its extrema are exact
(`continuous.py`), and those of lengths are known to within 1e-7 (`lengths.py`).
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from math import hypot

import numpy as np

from stlc.ir.nodes import Linear, Node, Role, Timed, walk
from stlc.ir.norms import Norms, Sum
from stlc.plan import Run
from stlc.verify.continuous import extremum
from stlc.verify.lattice import Atom, Combine, atoms, combination, lattice
from stlc.verify.lengths import Curve, least
from stlc.verify.paths import Array, Path
from stlc.verify.sway import Quadratic

Forms = tuple[Array, Array, Array, Array]
"""c0, c1, c2 (rows, leaves) of all leaves, and what a path may put them off by (rows, leaves)."""


@dataclass(frozen=True, slots=True, eq=False)
class Motions:
    """Paths of all states and the inputs of a run; T+1 steps of `pieces` rows each.

    `radii` [m] of agents whose position is somewhere in a disc around their path.
    """

    paths: Mapping[str, Path]
    runs: Mapping[str, Run]
    radii: Mapping[str, float] = field(default_factory=dict)

    @property
    def pieces(self) -> int:
        """Pieces of a step."""
        return next((path.pieces for path in self.paths.values()), 1)

    def least(self, condition: Node, steps: int) -> Array:
        """Least robustness (L,) over [t, t + 1], t = 0..L-1, L <= `steps`."""
        count = steps - max((s.shift for leaf in _leaves(condition) for s, _ in leaf.terms),
                            default=0)  # fmt: skip
        frames = condition.cases if isinstance(condition, Timed) else (condition,)
        parts = []
        for t, case in enumerate(frames[:count]):
            last = t == min(len(frames), count) - 1
            parts.append(self._frame(case, slice(t, count if last else t + 1)))
        return np.concatenate([np.empty(0), *parts])

    def _frame(self, condition: Node, steps: slice) -> Array:
        """Least robustness (steps,) of a condition that stays the same over some steps."""
        whole = lattice(condition, self._exact)
        found = tuple(dict.fromkeys(atoms(whole)))
        combine = combination(whole, {atom: k for k, atom in enumerate(found)})
        if any(isinstance(atom.form, Norms) for atom in found):
            value, error = self._along(found, combine, steps)
        else:
            c0, c1, c2, error = self._forms(found, steps)
            value = extremum(c0, c1, c2, combine).value
        worst = error.max(axis=1, initial=0.0)
        return np.asarray((value - worst).reshape(-1, self.pieces).min(axis=1))

    def _exact(self, norms: Norms) -> bool:
        """Whether all who take part in lengths are on their paths; else their faces are judged."""
        return not any(o in self.radii or self.paths[o].sways for o in norms.owners)

    def _along(self, found: Sequence[Atom], combine: Combine, steps: slice) -> tuple[Array, Array]:
        """Least values (pieces,) of what lengths take part in, and errors (pieces, atoms)."""
        made = [self._curve(atom, steps) for atom in found]
        rows = (steps.stop - steps.start) * self.pieces
        value = least([curve for curve, _ in made], combine, rows)
        return value, np.column_stack([error for _, error in made])

    def _curve(self, atom: Atom, steps: slice) -> tuple[Curve, Array]:
        """An atom's number along the motion, and what it may be off by (pieces,)."""
        if isinstance(atom.form, Linear):
            *rest, error = (part[:, 0] for part in self._forms([atom], steps))
            return Curve(np.stack(rest)), error
        sign, lengths = 1.0 if atom.positive else -1.0, []
        *rest, error = self._parts([atom.form.rest], steps)
        error = error[:, 0]
        for factor, components in atom.form.lengths:
            *parts, off = self._parts(components, steps)
            lengths.append((sign * factor, np.stack(parts)))
            error = error + abs(factor) * np.linalg.norm(off, axis=1)
        return Curve(sign * np.stack(rest)[..., 0], tuple(lengths)), error

    def _forms(self, found: Sequence[Atom], steps: slice) -> Forms:
        """`_parts` of predicates, each by its sign and less what it may be off by."""
        forms = [atom.form for atom in found if isinstance(atom.form, Linear)]
        signs = np.array([1.0 if atom.positive else -1.0 for atom in found])
        *parts, error = self._parts(forms, steps)
        c0, c1, c2 = (part * signs for part in parts)
        for k, leaf in enumerate(forms):
            c0[:, k] -= self._off(leaf)
            for into, off in zip((c0, c1, c2), self._swayed(leaf, steps), strict=True):
                into[:, k] -= off
        return c0, c1, c2, error

    def _parts(self, forms: Sequence[Linear | Sum], steps: slice) -> Forms:
        """Coefficients c0, c1, c2 and error (pieces, forms) of each as a quadratic of time over
        every piece of these steps."""
        rows = (steps.stop - steps.start) * self.pieces
        out = tuple(np.zeros((rows, len(forms))) for _ in range(4))
        for k, form in enumerate(forms):
            out[0][:, k] = form.constant
            for signal, weight in form.terms:
                at = slice(steps.start + signal.shift, steps.stop + signal.shift)
                if signal.role is Role.INPUT:
                    values = self.runs[signal.owner].inputs[at, signal.index]
                    out[0][:, k] += weight * np.repeat(values, self.pieces)
                    continue
                path = self.paths[signal.owner]
                on = slice(at.start * self.pieces, at.stop * self.pieces)
                for into, part in zip(out, (path.c0, path.c1, path.c2), strict=False):
                    into[:, k] += weight * part[on, signal.index]
                if path.error is not None:
                    out[3][:, k] += abs(weight) * path.error[on, signal.index]
        return out[0], out[1], out[2], out[3]

    def _swayed(self, leaf: Linear, steps: slice) -> Quadratic:
        """What disturbances may take off a predicate, as quadratics of time."""
        rows: dict[tuple[str, int], Array] = {}
        for signal, weight in leaf.terms:
            path = self.paths[signal.owner]
            if path.sways:
                states, inputs = self.runs[signal.owner].states, self.runs[signal.owner].inputs
                width = states.shape[1] + inputs.shape[1]
                row = rows.setdefault((signal.owner, signal.shift), np.zeros((1, width)))
                behind = 0 if signal.role is Role.STATE else states.shape[1]
                row[0, behind + signal.index] += weight
        off = [np.zeros((steps.stop - steps.start) * self.pieces) for _ in range(3)]
        for (owner, shift), row in rows.items():
            on = slice(*(self.pieces * (end + shift) for end in (steps.start, steps.stop)))
            for into, part in zip(off, self.paths[owner].swayed(row), strict=True):
                into += part[on, 0]
        return off[0], off[1], off[2]

    def _off(self, leaf: Linear) -> float:
        """What a predicate may be less for agents that are anywhere in their discs."""
        lengths: dict[tuple[str, int], float] = {}
        for signal, weight in leaf.terms:
            if signal.owner in self.radii and signal.role is Role.STATE:
                key = signal.owner, signal.shift
                lengths[key] = hypot(lengths.get(key, 0.0), weight)
        return sum(self.radii[owner] * length for (owner, _), length in lengths.items())


def _leaves(node: Node) -> Iterator[Linear]:
    """The distinct predicates of a condition."""
    return (part for part in walk(node) if isinstance(part, Linear))
