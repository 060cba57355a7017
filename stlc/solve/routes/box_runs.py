"""The cheapest runs of an agent over boxes of position, rate and progress: a bound, and a guide.

Whatever run fulfils the mission, the boxes that hold its states follow one another by steps of
`axis_boxes.py`, and what it holds at each step may hold in its box (`box_view.py`). Formulas are
monotone, so the cheapest sequence of boxes under what may hold costs no more: dynamic programming
over (progress, box), step by step, along one axis after the other. Of finer boxes only those are
looked at whose coarse ones lie on a sequence that is cheap enough.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

import numpy as np

from stlc.arrays import Floats, Ints
from stlc.solve.relaxation.problem import Singles
from stlc.solve.routes import patches
from stlc.solve.routes.axis_boxes import Span
from stlc.solve.routes.box_view import View
from stlc.solve.routes.patches import Patch
from stlc.solve.routes.progress import Open

_MOST = 100_000_000  # values of all steps: 400 MB
_ROUNDING = 2e-7  # of a value, by each step: costs are single numbers
Layer = dict[Open, Patch]
_NOTHING: Open = frozenset()


@dataclass(slots=True, eq=False)
class BoxRuns:
    """The runs over the boxes of a view that cost less than `most`, by steps: costs `so_far` from
    the start, and `to_go`. `base`: what every run costs at least, left out of both; `coarse`: the
    same over coarser boxes."""

    view: View
    most: float
    coarse: BoxRuns | None = None
    base: float = field(init=False)
    so_far: list[Layer] = field(default_factory=list)
    to_go: list[Layer] = field(default_factory=list)
    _next: list[dict[tuple[Open, int], Open]] = field(default_factory=list)
    _places: list[Singles] = field(init=False)

    def __post_init__(self) -> None:
        places = [self.view.places(t) for t in range(1, self.steps + 1)]
        least = [float(p.min()) for p in places]
        self.base = float(sum(least))
        self._places = [np.zeros(self.view.shape, np.float32)]
        self._places += [
            np.asarray(p - low, np.float32) for p, low in zip(places, least, strict=True)
        ]

    @property
    def _room(self) -> float:
        """What runs may cost beyond `base`, with what rounding takes."""
        room = self.most - self.base
        return room + self.steps * _ROUNDING * max(room, 0.0) + 1e-6

    @property
    def steps(self) -> int:
        """T."""
        return self.view.mission.horizon

    def bound(self, over: Callable[[], bool]) -> float | None:
        """The least cost of a run, `most` where all cost that much; None where time is over, or
        there are too many boxes."""
        self._next = [{} for _ in range(self.steps + 1)]
        self.so_far, size = [self._begun()], 0
        for t in range(1, self.steps + 1):
            if over():
                return None
            self.so_far.append(self._step(t, self.so_far[-1]))
            size += sum(patch.values.size for patch in self.so_far[-1].values())
            if size > _MOST:
                return None
        end = self.so_far[-1].get(_NOTHING)
        if end is None:
            return self.most
        least = float(end.values.min()) * (1 - self.steps * _ROUNDING)
        return min(self.base + least, self.most)

    def look_back(self, most: float) -> None:
        """What is still to go from each box of a run that costs less than `most`, in place of the
        costs so far."""
        self.most = min(most, self.most)
        last = self.so_far[-1].get(_NOTHING)
        none = np.float32(0.0)
        found: Layer = {}
        if last is not None:
            ends = np.where(np.isfinite(last.values), none, np.inf).astype(np.float32)
            found[_NOTHING] = last._replace(values=ends)
        self.to_go = [found]
        for t in range(self.steps, 0, -1):
            found = {}
            for opens, together in patches.alike(self.so_far[t - 1]):
                found |= self._ahead(t, opens, together, self.to_go[-1])
            self.to_go.append(found)
        self.to_go.reverse()
        self.so_far.clear()
        self.coarse = None

    def _begun(self) -> Layer:
        """The boxes that hold the start."""
        view, axes = self.view, self.view.body.axes
        ix, iy = view.x.holding(*axes[0].start), view.y.holding(*axes[1].start)
        spans = [(int(i.min()) // b.rates, int(i.max()) // b.rates + 1)
                 for i, b in ((ix, view.x), (iy, view.y))]  # fmt: skip
        patch = patches.empty(spans[0], spans[1], (view.x.rates, view.y.rates))
        flat = patch.values.reshape(patch.values.shape[0] * view.x.rates, -1)
        flat[np.ix_(ix - spans[0][0] * view.x.rates, iy - spans[1][0] * view.y.rates)] = 0.0
        found: Layer = {}
        self._part(0, [_NOTHING], patch._replace(values=patch.values[:, :, None]), found)
        return found

    def _step(self, t: int, layer: Layer) -> Layer:
        """All boxes a step on."""
        found: Layer = {}
        going = self.view.going(t)[None, :, None, None, :]
        for opens, together in patches.alike(layer):
            moved = patches.stepped(together, self.view.x, self.view.y, back=False)
            moved.values[...] += self._costs(t, moved.x, moved.y) + going
            self._part(t, opens, moved, found)
        kept = {open_: self._promising(t, open_, patch) for open_, patch in found.items()}
        return {open_: patch for open_, patch in kept.items() if patch is not None}

    def _costs(self, t: int, x: Span, y: Span) -> Singles:
        return self._places[t][x[0] : x[1], None, None, y[0] : y[1], None]

    def _part(self, t: int, opens: Sequence[Open], moved: Patch, found: Layer) -> None:
        """Share boxes out among what is open after step t."""
        label, memo, none = self.view.label(t), self.view.memo(t), np.float32(np.inf)
        for k, (wide, high) in enumerate(label.spans):
            x, y = patches.shared(wide, moved.x), patches.shared(high, moved.y)
            mask = label.of[x[0] : x[1], y[0] : y[1]] == k
            if not mask.any():
                continue
            parts = np.where(mask[:, None, None, :, None], patches.within(moved, x, y), none)
            for n in np.flatnonzero(np.isfinite(parts.min(axis=(0, 1, 3, 4)))).tolist():
                after = self.view.progress.after(opens[n], t, label.holds[k], memo[k])
                if after is not None:
                    self._next[t][opens[n], k] = after
                    part = Patch(x, y, parts[:, :, n])
                    found[after] = patches.merged(found.get(after), part)

    def _promising(self, t: int, open_: Open, patch: Patch) -> Patch | None:
        """The boxes from which the rest may still cost little enough."""
        values = patch.values
        if self.coarse is not None:
            ahead = self._coarse(t, open_, patch)
            if ahead is None:
                return None
            values[values + ahead > self._room] = np.inf
        elif np.isfinite(self._room):
            values[values > self._room] = np.inf
        return patches.trimmed(patch)

    def _coarse(self, t: int, open_: Open, patch: Patch) -> Singles | None:
        """What is to go from the coarse boxes that hold those of a patch: with the same open, or
        with whatever may be where the coarse ones see less."""
        assert self.coarse is not None
        coarse, layer = self.coarse.view, self.coarse.to_go[t]
        at = [own.parents(other) for own, other in
              ((self.view.x, coarse.x), (self.view.y, coarse.y))]  # fmt: skip
        x, y = at[0][0][slice(*patch.x)], at[1][0][slice(*patch.y)]
        rates = at[0][1], at[1][1]
        known = [layer.get(open_)] if self.view.sharp else list(layer.values())
        found = [patches.refined(p, x, y, rates) for p in known if p is not None]
        return np.minimum.reduce(found) if found else None

    def _ahead(self, t: int, opens: Sequence[Open], known: Patch, later: Layer) -> Layer:
        """What is to go from patches of one place at step t - 1."""
        view, rates = self.view, (self.view.x.rates, self.view.y.rates)
        x, y = view.x.beside(known.x), view.y.beside(known.y)
        ahead = [self._onward(t, open_, patches.empty(x, y, rates), later) for open_ in opens]
        whole = Patch(x, y, np.stack([patch.values for patch in ahead], axis=2))
        whole.values[...] += self._costs(t, x, y) + view.going(t)[None, :, None, None, :]
        back = patches.stepped(whole, view.x, view.y, back=True)
        values = patches.within(back, known.x, known.y)
        values[known.values + values > self._room] = np.inf
        found = (patches.trimmed(known._replace(values=values[:, :, n])) for n in range(len(opens)))
        return {o: patch for o, patch in zip(opens, found, strict=True) if patch is not None}

    def _onward(self, t: int, open_: Open, whole: Patch, later: Layer) -> Patch:
        """What is to go from where a step t may end, filled in."""
        label = self.view.label(t)
        for k, (wide, high) in enumerate(label.spans):
            after = self._next[t].get((open_, k))
            known = None if after is None else later.get(after)
            if known is not None:
                x = patches.shared(patches.shared(wide, whole.x), known.x)
                y = patches.shared(patches.shared(high, whole.y), known.y)
                mask = (label.of[x[0] : x[1], y[0] : y[1]] == k)[:, None, :, None]
                part = patches.within(whole, x, y)
                part[...] = np.where(mask, patches.within(known, x, y), part)
        return whole

    def positions(self, t: int) -> tuple[Floats, Floats]:
        """The least and the greatest position (2,) at step t of all runs that are cheap enough."""
        x = [p.x for p in self.to_go[t].values()]
        y = [p.y for p in self.to_go[t].values()]
        ends = [(boxes.p[min(s[0] for s in spans), 0], boxes.p[max(s[1] for s in spans) - 1, 1])
                for boxes, spans in ((self.view.x, x), (self.view.y, y))]  # fmt: skip
        low, high = np.array(ends).T
        return low, high

    def cheapest(self) -> Floats | None:
        """Boxes (2, T+1, 2: low and high, steps, axes) [m] around a cheapest run, as `bound` has
        found it; None where it has found none."""
        view, end = self.view, self.so_far[-1].get(_NOTHING)
        if end is None:
            return None
        i, u, j, v = (int(n) for n in np.unravel_index(end.values.argmin(), end.values.shape))
        at = (end.x[0] + i) * view.x.rates + u, (end.y[0] + j) * view.y.rates + v
        open_, found = _NOTHING, [at]
        for t in range(self.steps, 0, -1):
            open_, at = self._before(t, open_, at)
            found.append(at)
        where = np.array(found[::-1])
        x, y = view.x.p[where[:, 0] // view.x.rates], view.y.p[where[:, 1] // view.y.rates]
        return np.stack([x.T, y.T], axis=2)

    def _before(self, t: int, open_: Open, at: tuple[int, int]) -> tuple[Open, tuple[int, int]]:
        """A box of step t - 1 from which one of step t costs least."""
        view, best = self.view, (np.inf, open_, at)
        k = int(view.label(t).of[at[0] // view.x.rates, at[1] // view.y.rates])
        x, y = (np.unique(boxes.before[:, n]) for boxes, n in ((view.x, at[0]), (view.y, at[1])))
        x, y = x[x >= 0], y[y >= 0]
        for earlier, patch in self.so_far[t - 1].items():
            if self._next[t].get((earlier, k)) == open_:
                value = _read(patch, np.divmod(x, view.x.rates), np.divmod(y, view.y.rates))
                i, j = divmod(int(value.argmin()), len(y))
                if value[i, j] < best[0]:
                    best = float(value[i, j]), earlier, (int(x[i]), int(y[j]))
        return best[1], best[2]


def _read(patch: Patch, x: tuple[Ints, Ints], y: tuple[Ints, Ints]) -> Floats:
    """Values (k, l) of boxes given by position and rate, infinite off the patch."""
    (px, u), (py, v) = x, y
    inside = ((px >= patch.x[0]) & (px < patch.x[1]))[:, None]
    inside = inside & ((py >= patch.y[0]) & (py < patch.y[1]))[None]
    i, j = (np.clip(p - s[0], 0, s[1] - s[0] - 1) for p, s in ((px, patch.x), (py, patch.y)))
    return np.where(inside, patch.values[i[:, None], u[:, None], j[None], v[None]], np.inf)
