"""What random scenes are made of: agents, boxes, walls of touching pieces, ways across."""

from __future__ import annotations

import itertools

import numpy as np

from truth.scene import DOUBLE, SINGLE, Body, Model, Obstacle, Part, Point, Ring, Scene, Window, box

Random = np.random.Generator
SPACE: Ring = ((0.0, 0.0), (10.0, 0.0), (10.0, 10.0), (0.0, 10.0))


def drawn_number(rng: Random, low: float, high: float) -> float:
    """On a grid of a quarter half of the time, else with three decimals."""
    value = float(rng.uniform(low, high))
    return round(value * 4) / 4 if rng.random() < 0.5 else round(value, 3)


def drawn_body(rng: Random, model: Model, start: Point, name: str = "r") -> Body:
    """An agent at rest, or moving slowly."""
    control = drawn_number(rng, 1.5, 3.0)
    if model.kind == SINGLE:
        return Body(name, model, start, control, disc=bool(rng.random() < 0.3))
    speed = drawn_number(rng, 1.5, 3.5) if rng.random() < 0.6 else None
    rest = (
        (0.0, 0.0)
        if rng.random() < 0.5
        else (drawn_number(rng, -0.5, 0.8), drawn_number(rng, -0.5, 0.5))
    )
    full = np.zeros(len(model.A) or 4)
    full[list(model.position)] = start
    if model.velocity is not None:
        full[list(model.velocity)] = rest
    return Body(name, model, tuple(full.tolist()), control, speed, disc=bool(rng.random() < 0.3))


def named_model(rng: Random) -> Model:
    """A single or double integrator."""
    return Model(SINGLE if rng.random() < 0.3 else DOUBLE)


def goal_box(rng: Random, x: float = 7.75, y: float | None = None) -> Part:
    """A box 1.25 m wide near x, on the right."""
    x = x + drawn_number(rng, 0.0, 0.5)
    y = drawn_number(rng, 1.0, 8.0) if y is None else y
    return box(x, x + 1.25, y, y + 1.25)


def drawn_clock(rng: Random) -> tuple[float, int]:
    """Step [s] and horizon of about eight seconds."""
    step = float(rng.choice([0.5, 1.0, 1.0, 1.5, 2.0]))
    return step, int(max(4, min(9, round(8.0 / step))))


def left_start(rng: Random) -> Point:
    """A point on the left."""
    return drawn_number(rng, 0.5, 2.0), drawn_number(rng, 1.0, 9.0)


def some_boxes(rng: Random, count: int) -> tuple[Obstacle, ...]:
    """Boxes in the middle, each an obstacle; they may overlap."""
    made = []
    for k in range(count):
        x, y = drawn_number(rng, 2.5, 6.0), drawn_number(rng, 0.5, 7.5)
        w, h = drawn_number(rng, 0.25, 1.5), drawn_number(rng, 0.5, 2.5)
        made.append(Obstacle(f"o{k}", {0: (box(x, x + max(w, 0.2), y, y + h),)}))
    return tuple(made)


def kept_out(bodies: tuple[Body, ...], obstacles: tuple[Obstacle, ...], window: Window) -> dict[
    tuple[str, str], Window
]:  # fmt: skip
    """Every body out of every obstacle, within the window."""
    return {(b.name, o.name): window for b in bodies for o in obstacles}


def crossing(
    rng: Random,
    family: str,
    model: Model,
    obstacles: tuple[Obstacle, ...],
    space: Ring = SPACE,
    closed: bool = False,
    swept: bool = True,
) -> Scene:
    """One agent from the left to the right, past obstacles."""
    step, horizon = drawn_clock(rng)
    body = drawn_body(rng, model, left_start(rng))
    keep = kept_out((body,), obstacles, Window(0, horizon - 1, swept))
    return Scene(
        family, step, horizon, space, (body,), obstacles, keep, goals={"r": goal_box(rng)},
        closed=closed,
    )  # fmt: skip


def _cuts(rng: Random, low: float, high: float) -> list[float]:
    inner = sorted(
        {drawn_number(rng, low + 0.3, high - 0.3) for _ in range(int(rng.integers(1, 4)))}
    )
    return [low, *inner, high]


def touching_pieces(rng: Random, low: float, high: float) -> list[Part]:
    """A wall of touching pieces, upright or slanted, some of them of other widths."""
    x, cuts = drawn_number(rng, 3.5, 5.5), _cuts(rng, low, high)
    slant = drawn_number(rng, -0.15, 0.15) if rng.random() < 0.5 else 0.0
    parts = []
    for y0, y1 in itertools.pairwise(cuts):
        width = drawn_number(rng, 0.25, 1.0) + 0.1
        a, b = (x + slant * (y - low) for y in (y0, y1))
        ring = ((a, y0), (a + width, y0), (b + width, y1), (b, y1))
        parts.append(Part(ring) if slant else box(x, x + width, y0, y1))
    return parts
