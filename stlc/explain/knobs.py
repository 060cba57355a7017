"""Numbers of a file that a planner may change to end a conflict: deadlines, thresholds, bounds.

A knob is one number of the text (or those of one partition), with the way it may go and the step in
which it goes. What the world is made of is none: path loss, dynamics, masses.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass
from math import floor, log2, log10

from stlc.explain.conflict import Conflict
from stlc.explain.givens import Given, Kind
from stlc.explain.numbers import Number, Of, number, numbers_of, properties
from stlc.mission import Mission
from stlc.source import Span

FINEST_GRID = 32
"""Cells along a side of the finest partition that is offered; see `stlc.grids`."""


WEIGHT = {Of.BOUND: 2.0, Of.OBSTACLE: 2.0, Of.WORKSPACE: 3.0, Of.START: 3.0}
"""Others count once: what a mission asks for is easier to change than a robot, and that easier
than the world."""


@dataclass(frozen=True, slots=True)
class Knob:
    """One number and its way: value, value + way * step, ... up to `most` steps.

    `scale` is the change that counts as 1; `spans` are the texts that take the new number.
    """

    of: Of
    name: str
    spans: tuple[Span, ...]
    values: tuple[float, ...]
    way: int
    step: float
    most: int
    scale: float
    unit: str = ""

    def at(self, count: int) -> tuple[float, ...]:
        """The numbers so many steps on."""
        if self.of is Of.PARTITION:
            return tuple(v * 2**count for v in self.values)
        return tuple(round(v + self.way * count * self.step, 12) for v in self.values)

    def cost(self, old: float, new: float) -> float:
        """How large the change from one number to another is."""
        if self.of is Of.PARTITION:
            return 0.2 * abs(log2(new / old))
        return WEIGHT.get(self.of, 1.0) * abs(new - old) / self.scale


def knobs(mission: Mission, conflict: Conflict) -> tuple[Knob, ...]:
    """The knobs of a conflict's clauses, of the places they name, and of what is given."""
    found = dict.fromkeys(k for n in numbers_of(mission, conflict) for k in _ways(n, mission))
    every = [*found, *_partitions(mission, conflict.givens)]
    return tuple(k for k in every if all(s.source is mission.source for s in k.spans))


def _partitions(mission: Mission, givens: tuple[Given, ...]) -> Iterator[Knob]:
    """A grid `nx x ny`, or `nx x ny x nz`, in it, with cells of half the width, and so on."""
    for given in givens:
        for item in properties(mission.source) if given.kind is Kind.PARTITION else ():
            if item.span != given.span or len(item.args) not in (2, 3):
                continue
            found = [n for arg in item.args for n in number(arg, Of.PARTITION)]
            if len(found) == len(item.args):
                values, spans = tuple(n.value for n in found), tuple(n.span for n in found)
                most = max(0, floor(log10(FINEST_GRID / max(values)) / log10(2) + 1e-9))
                name = f"partition of {given.owner}"
                yield Knob(Of.PARTITION, name, spans, values, 1, 1.0, most, 1.0)


# --- ways --------------------------------------------------------------------------------------

_STEPS = (Of.BEGIN, Of.DEADLINE)
_MORE = 10  # hops or instances at most: teams that a solver plans for are hardly larger
_TIMES = {"s": 1.0, "ms": 1e-3, "min": 60.0}


def _ways(number: Number, mission: Mission) -> Iterator[Knob]:
    """A number's knobs: up and down, as far as that makes sense."""
    for way in (1, -1):
        step, most, scale = _grid(number, way, mission)
        if most > 0:
            name, unit = number.name or number.of.value, number.unit or _unit(number)
            spans, values = (number.span,), (number.value,)
            yield Knob(number.of, name, spans, values, way, step, most, scale, unit)


def _unit(number: Number) -> str:
    if number.of in _STEPS:
        return "steps"
    return "m" if number.of in (Of.REGION, Of.OBSTACLE, Of.WORKSPACE, Of.START) else ""


def _grid(number: Number, way: int, mission: Mission) -> tuple[float, int, float]:
    """Step, number of steps at most, and the change that counts as 1."""
    value, size = number.value, abs(number.value)
    if number.of is Of.COUNT:
        return 1.0, round(size) if way < 0 else _MORE, max(size, 1.0)
    if number.of in _STEPS:
        step = mission.step / _TIMES.get(number.unit, mission.step) if number.unit else 1.0
        least = mission.horizon + 10 if way > 0 else round(value / step)
        return step, least, max(size, step)
    if number.of is Of.PROBABILITY:
        return 0.01, round((value if way < 0 else 1 - value) / 0.01) - 1, 0.5
    if re.match("dB", number.unit):
        return 0.1, 600, 10.0
    if number.of in (Of.REGION, Of.OBSTACLE, Of.WORKSPACE, Of.START):
        wide = _width(mission)
        return _tenth(wide) / 10, round(wide / (_tenth(wide) / 10)), wide / 4
    step = _tenth(size or 1.0) / 10
    room = value if way < 0 and value > 0 else 9 * (size or 1.0)
    return (
        step,
        max(0, round(room / step) - (1 if way < 0 and number.of is Of.BOUND else 0)),
        (size or 1.0),
    )


def _tenth(size: float) -> float:
    """A tenth of the power of ten below a size."""
    return float(10.0 ** (floor(log10(size)) - 1))


def _width(mission: Mission) -> float:
    space = mission.workspace
    if space is None:
        return 10.0
    return float((space.vertices.max(axis=0) - space.vertices.min(axis=0)).max())
