"""A mission as plain numbers, and its text: nothing here knows the compiler."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Point = tuple[float, float]
Ring = tuple[Point, ...]

SINGLE, DOUBLE = "single_integrator", "double_integrator"


@dataclass(frozen=True, slots=True)
class Part:
    """A polygon with holes [m]; `is_box` is written as a box."""

    ring: Ring
    holes: tuple[Ring, ...] = ()
    is_box: bool = False

    def text(self) -> str:
        """As the language writes it."""
        if self.is_box:
            x, y = (sorted({p[k] for p in self.ring}) for k in range(2))
            return f"box [{x[0]!r}, {x[-1]!r}] x [{y[0]!r}, {y[-1]!r}]"
        return " hole ".join([f"polygon {_points(self.ring)}", *map(_points, self.holes)])


def box(x0: float, x1: float, y0: float, y1: float) -> Part:
    """An axis-aligned box."""
    return Part(((x0, y0), (x1, y0), (x1, y1), (x0, y1)), is_box=True)


@dataclass(frozen=True, slots=True)
class Model:
    """x(t+1) or x' = A x + B u + c; a named kind where `kind` says so, and then no matrices."""

    kind: str
    A: tuple[tuple[float, ...], ...] = ()
    B: tuple[tuple[float, ...], ...] = ()
    c: tuple[float, ...] = ()
    continuous: bool = False
    position: tuple[int, int] = (0, 1)
    velocity: tuple[int, int] | None = (2, 3)

    def text(self, name: str) -> str:
        """A `dynamics` statement."""
        if not self.A:
            return f"dynamics {name} = {self.kind}"
        states = [f"x{k}" for k in range(len(self.A))]
        lines = [f"  A = {_matrix(self.A)}", f"  B = {_matrix(self.B)}"]
        lines += [f"  c = [{', '.join(map(repr, self.c))}]"] if self.c else []
        lines += ["  continuous"] if self.continuous else []
        lines.append("  position " + " ".join(states[k] for k in self.position))
        if self.velocity is not None:
            lines.append("  velocity " + " ".join(states[k] for k in self.velocity))
        return "\n".join([f"dynamics {name} {{", *lines, "}"])


@dataclass(frozen=True, slots=True)
class Body:
    """One agent; limits in SI units, None where there is none."""

    name: str
    model: Model
    start: tuple[float, ...]
    control: float
    speed: float | None = None
    turns: bool = False
    disc: bool = False  # control is a Euclidean norm

    def text(self) -> str:
        """Its two statements."""
        lines = [f"  start ({', '.join(map(repr, self.start))})"]
        lines.append(f"  control |u| <= {self.control!r}" + (" polygon 12" if self.disc else ""))
        lines += [f"  speed <= {self.speed!r}"] if self.speed is not None else []
        lines += ["  turn_rate on"] if self.turns else []
        kind = f"{self.name}_kind"
        return "\n".join([self.model.text(kind), f"agent {self.name} : {kind} {{", *lines, "}"])


@dataclass(frozen=True, slots=True)
class Obstacle:
    """Frames by step (the latest holds) and what they grow by [m]."""

    name: str
    frames: Mapping[int, tuple[Part, ...]]
    grow: float = 0.0

    @property
    def moves(self) -> bool:
        """More than one frame."""
        return len(self.frames) > 1

    def frame(self, step: int) -> tuple[Part, ...]:
        """The parts that are there at a step."""
        return self.frames[max(k for k in self.frames if k <= step)]

    def text(self) -> str:
        """Its statement."""
        shapes = {k: _union(parts) for k, parts in self.frames.items()}
        shape = shapes[0]
        if self.moves:
            shape = "moving { " + "; ".join(f"{k}: {s}" for k, s in shapes.items()) + " }"
        return f"obstacle {self.name} = {shape}" + (f" inflate {self.grow!r}" if self.grow else "")


@dataclass(frozen=True, slots=True)
class Window:
    """Steps first..last of a requirement; `swept` holds between them too."""

    first: int
    last: int
    swept: bool = True

    def text(self, claim: str) -> str:
        """always[..] of a claim."""
        return f"always[{self.first}, {self.last}] {claim}" + (" swept" if self.swept else "")


@dataclass(frozen=True, slots=True)
class Scene:
    """A mission. Keys: (agent, obstacle), (agent, region), (agent, agent), agent -> goal.

    `closed`: nobody can get through, by construction.
    """

    family: str
    step: float
    horizon: int
    workspace: Ring
    bodies: tuple[Body, ...]
    obstacles: tuple[Obstacle, ...] = ()
    keep_out: Mapping[tuple[str, str], Window] = field(default_factory=dict)
    regions: Mapping[str, tuple[Part, ...]] = field(default_factory=dict)
    keep_in: Mapping[tuple[str, str], Window] = field(default_factory=dict)
    apart: Mapping[tuple[str, str], tuple[Point, Window]] = field(default_factory=dict)
    goals: Mapping[str, Part] = field(default_factory=dict)
    closed: bool = False

    def text(self) -> str:
        """The mission file."""
        return "\n".join(self._lines()) + "\n"

    def _lines(self) -> Iterator[str]:
        yield f"step {self.step!r} s\nhorizon {self.horizon}"
        rectangle = Part(self.workspace, is_box=_is_rectangle(self.workspace))
        yield f"workspace {rectangle.text()} swept"
        yield from (body.text() for body in self.bodies)
        yield from (obstacle.text() for obstacle in self.obstacles)
        yield from (f"region {name} = {_union(parts)}" for name, parts in self.regions.items())
        yield from (f"region goal_{name} = {part.text()}" for name, part in self.goals.items())
        for (who, what), window in self.keep_out.items():
            yield f"require out_{who}_{what}: {window.text(f'{who} outside {what}')}"
        for (who, what), window in self.keep_in.items():
            yield f"require in_{who}_{what}: {window.text(f'{who} in {what}')}"
        for (one, other), (gap, window) in self.apart.items():
            claim = f"separation({one}, {other}) >= ({gap[0]!r}, {gap[1]!r})"
            yield f"require apart_{one}_{other}: {window.text(claim)}"
        for who in self.goals:
            yield f"require reach_{who}: eventually[1, {self.horizon}] {who} in goal_{who}"
        yield "minimize effort"


def _union(parts: tuple[Part, ...]) -> str:
    return " + ".join(part.text() for part in parts)


def _points(ring: Ring) -> str:
    return " ".join(f"({x!r}, {y!r})" for x, y in ring)


def _matrix(rows: tuple[tuple[float, ...], ...]) -> str:
    return "[" + ", ".join("[" + ", ".join(map(repr, row)) + "]" for row in rows) + "]"


def _is_rectangle(ring: Ring) -> bool:
    xs, ys = {p[0] for p in ring}, {p[1] for p in ring}
    return len(ring) == 4 and len(xs) == 2 and len(ys) == 2
