"""Random scenes by family and seed. Worlds are about 10 m wide."""

from __future__ import annotations

import itertools
from collections.abc import Callable

import numpy as np

from truth.models import drawn_model
from truth.scene import (
    DOUBLE,
    SINGLE,
    Body,
    Model,
    Obstacle,
    Part,
    Point,
    Ring,
    Scene,
    Window,
    box,
)

Random = np.random.Generator
SPACE: Ring = ((0.0, 0.0), (10.0, 0.0), (10.0, 10.0), (0.0, 10.0))


def draw(family: str, seed: int) -> Scene:
    """The scene of a family and a seed."""
    return FAMILIES[family](np.random.default_rng([seed, *family.encode()]), family)


def _number(rng: Random, low: float, high: float) -> float:
    """On a grid of a quarter half of the time, else with three decimals."""
    value = float(rng.uniform(low, high))
    return round(value * 4) / 4 if rng.random() < 0.5 else round(value, 3)


def _body(rng: Random, model: Model, start: Point, name: str = "r") -> Body:
    """An agent at rest, or moving slowly."""
    control = _number(rng, 1.5, 3.0)
    if model.kind == SINGLE:
        return Body(name, model, start, control, disc=bool(rng.random() < 0.3))
    speed = _number(rng, 1.5, 3.5) if rng.random() < 0.6 else None
    rest = (0.0, 0.0) if rng.random() < 0.5 else (_number(rng, -0.5, 0.8), _number(rng, -0.5, 0.5))
    full = np.zeros(len(model.A) or 4)
    full[list(model.position)] = start
    if model.velocity is not None:
        full[list(model.velocity)] = rest
    return Body(name, model, tuple(full.tolist()), control, speed, disc=bool(rng.random() < 0.3))


def _named(rng: Random) -> Model:
    return Model(SINGLE if rng.random() < 0.3 else DOUBLE)


def _goal(rng: Random, x: float = 7.75, y: float | None = None) -> Part:
    x = x + _number(rng, 0.0, 0.5)
    y = _number(rng, 1.0, 8.0) if y is None else y
    return box(x, x + 1.25, y, y + 1.25)


def _clock(rng: Random) -> tuple[float, int]:
    """Step [s] and horizon of about eight seconds."""
    step = float(rng.choice([0.5, 1.0, 1.0, 1.5, 2.0]))
    return step, int(max(4, min(9, round(8.0 / step))))


def _start(rng: Random) -> Point:
    return _number(rng, 0.5, 2.0), _number(rng, 1.0, 9.0)


def _boxes(rng: Random, count: int) -> tuple[Obstacle, ...]:
    made = []
    for k in range(count):
        x, y = _number(rng, 2.5, 6.0), _number(rng, 0.5, 7.5)
        w, h = _number(rng, 0.25, 1.5), _number(rng, 0.5, 2.5)
        made.append(Obstacle(f"o{k}", {0: (box(x, x + max(w, 0.2), y, y + h),)}))
    return tuple(made)


def _out(bodies: tuple[Body, ...], obstacles: tuple[Obstacle, ...], window: Window) -> dict[
    tuple[str, str], Window
]:  # fmt: skip
    return {(b.name, o.name): window for b in bodies for o in obstacles}


def _crossing(
    rng: Random,
    family: str,
    model: Model,
    obstacles: tuple[Obstacle, ...],
    space: Ring = SPACE,
    closed: bool = False,
    swept: bool = True,
) -> Scene:
    """One agent from the left to the right, past obstacles."""
    step, horizon = _clock(rng)
    body = _body(rng, model, _start(rng))
    keep = _out((body,), obstacles, Window(0, horizon - 1, swept))
    return Scene(
        family, step, horizon, space, (body,), obstacles, keep, goals={"r": _goal(rng)},
        closed=closed,
    )  # fmt: skip


def _plain(rng: Random, family: str) -> Scene:
    kind = SINGLE if family == "single" else DOUBLE
    return _crossing(rng, family, Model(kind), _boxes(rng, int(rng.integers(1, 4))))


def _turning(rng: Random, family: str) -> Scene:
    scene = _crossing(rng, family, Model(DOUBLE), _boxes(rng, 2))
    start = (*scene.bodies[0].start[:2], _number(rng, 0.5, 1.0), 0.0)
    body = Body("r", Model(DOUBLE), start, 2.0, 2.0, turns=True)
    return Scene(
        family, 1.0, 8, SPACE, (body,), scene.obstacles,
        _out((body,), scene.obstacles, Window(0, 7)), goals=scene.goals,
    )  # fmt: skip


def _matrices(rng: Random, family: str) -> Scene:
    model = drawn_model(rng, family == "continuous")
    return _crossing(rng, family, model, _boxes(rng, int(rng.integers(1, 3))))


def _cuts(rng: Random, low: float, high: float) -> list[float]:
    inner = sorted({_number(rng, low + 0.3, high - 0.3) for _ in range(int(rng.integers(1, 4)))})
    return [low, *inner, high]


def _wall(rng: Random, low: float, high: float) -> list[Part]:
    """A wall of touching pieces, upright or slanted, some of them of other widths."""
    x, cuts = _number(rng, 3.5, 5.5), _cuts(rng, low, high)
    slant = _number(rng, -0.15, 0.15) if rng.random() < 0.5 else 0.0
    parts = []
    for y0, y1 in itertools.pairwise(cuts):
        width = _number(rng, 0.25, 1.0) + 0.1
        a, b = (x + slant * (y - low) for y in (y0, y1))
        ring = ((a, y0), (a + width, y0), (b + width, y1), (b, y1))
        parts.append(Part(ring) if slant else box(x, x + width, y0, y1))
    return parts


def _walls(rng: Random, family: str) -> Scene:
    """Pieces of one obstacle, or obstacles, that touch; closed, flush, or with a gap at an end."""
    low, high = (
        (0.0, 10.0),
        (0.0, _number(rng, 6, 8.5)),
        (_number(rng, 1, 3), 10.0),
        (-1.0, 11.0),
    )[int(rng.integers(0, 4))]
    parts = _wall(rng, low, high)
    closed = low <= 0 and high >= 10
    if family == "union":
        obstacles: tuple[Obstacle, ...] = (Obstacle("wall", {0: tuple(parts)}),)
    else:
        obstacles = tuple(Obstacle(f"w{k}", {0: (p,)}) for k, p in enumerate(parts))
    return _crossing(rng, family, _named(rng), obstacles, closed=closed)


def _flush(rng: Random, family: str) -> Scene:
    """Walls that stand on the border of a workspace, which may be a slanted polygon."""
    space, x = SPACE, _number(rng, 3.5, 5.5)
    if rng.random() < 0.4:
        space = ((0.0, 0.0), (10.0, -1.0), (11.0, 10.0), (0.0, 10.0))
    floor = 0.0 if space is SPACE else -0.1 * x
    width, top = _number(rng, 0.25, 1.0) + 0.1, _number(rng, 4, 9.5)
    right = 0.0 if space is SPACE else -0.1 * (x + width)
    wall = Part(((x, floor), (x + width, right), (x + width, top), (x, top)), is_box=space is SPACE)
    obstacles = [Obstacle("wall", {0: (wall,)})]
    closed = bool(rng.random() < 0.3)
    if closed:
        obstacles.append(Obstacle("lid", {0: (box(x, x + width, top, 10.0),)}))
    model = _named(rng) if rng.random() < 0.7 else drawn_model(rng, True)
    return _crossing(rng, family, model, tuple(obstacles), space, closed)


def _room(rng: Random, family: str) -> Scene:
    """Non-convex polygons: rings with a hole that has the start in it, hooks, and stars."""
    x, y, w = _number(rng, 3, 4), _number(rng, 2, 3.5), _number(rng, 3, 4)
    t = _number(rng, 0.25, 0.75) + 0.05
    match int(rng.integers(0, 3)):
        case 0:
            part = Part(
                ((x, y), (x + w, y), (x + w, y + w), (x, y + w)),
                (((x + t, y + t), (x + w - t, y + t), (x + w - t, y + w - t), (x + t, y + w - t)),),
            )
        case 1:
            ring = ((x, y), (x + w, y), (x + w, y + t), (x + t, y + t), (x + t, y + w - t),
                    (x + w, y + w - t), (x + w, y + w), (x, y + w))  # fmt: skip
            part = Part(ring)
        case _:
            angles = np.sort(rng.uniform(0, 2 * np.pi, 9))
            radii = rng.uniform(0.6, 2.0, 9)
            ring = tuple(
                (round(float(5 + r * np.cos(a)), 3), round(float(5 + r * np.sin(a)), 3))
                for r, a in zip(radii, angles, strict=True)
            )
            part = Part(ring)
    scene = _crossing(rng, family, _named(rng), (Obstacle("room", {0: (part,)}),))
    if rng.random() < 0.5:
        return scene
    goals = {"r": box(x + w / 3, x + w / 2, y + w / 3, y + w / 2)}
    return Scene(
        family, scene.step, scene.horizon, SPACE, scene.bodies, scene.obstacles, scene.keep_out,
        goals=goals, closed=bool(part.holes),
    )  # fmt: skip


def _moving(rng: Random, family: str) -> Scene:
    """Trucks on their way, some flush with the border, some of two touching parts."""
    step, horizon = _clock(rng)
    body = _body(rng, _named(rng), _start(rng))
    obstacles = []
    for k in range(int(rng.integers(1, 3))):
        x, y = _number(rng, 3, 6), _number(rng, 2, 8)
        dx, dy = _number(rng, -0.4, 0.4) * step, _number(rng, -0.7, 0.7) * step
        w, h = _number(rng, 0.5, 1.5) + 0.1, _number(rng, 0.5, 2.5) + 0.1
        if rng.random() < 0.3:
            y, dy = 0.0, 0.0
        every = int(rng.choice([1, 1, 1, 2]))
        frames = {}
        for n in range(0, horizon, every):
            a, b = x + n * dx, y + n * dy
            frames[n] = (box(a, a + w, b, b + h),)
            if k == 1:
                frames[n] += (box(a, a + w, b + h, b + 1.5 * h),)
        obstacles.append(Obstacle(f"truck{k}", frames, _number(rng, 0, 0.3) if k == 0 else 0.0))
    made = tuple(obstacles)
    keep = _out((body,), made, Window(0, horizon - 1))
    return Scene(family, step, horizon, SPACE, (body,), made, keep, goals={"r": _goal(rng)})


def _border(rng: Random, family: str) -> Scene:
    """Fast along and towards the border, with every kind of dynamics."""
    models = [Model(DOUBLE), drawn_model(rng, True), drawn_model(rng, True)]
    model = models[int(rng.integers(0, 3))]
    step, horizon = float(rng.choice([1.0, 2.0])), 5
    body = _body(rng, model, (_number(rng, 0.25, 1.5), _number(rng, 0.25, 2.0)))
    full = np.array(body.start)
    assert model.velocity is not None
    full[list(model.velocity)] = (_number(rng, -1.5, 0.5), _number(rng, -1.5, 0.5))
    start = tuple(full.tolist())
    body = Body("r", model, start, 3.0, None, disc=body.disc)
    ring: Ring = (
        SPACE
        if rng.random() < 0.5
        else ((0.0, -0.5), (7.0, 0.0), (10.0, 5.0), (5.0, 10.0), (-0.5, 6.0))
    )
    return Scene(family, step, horizon, ring, (body,), goals={"r": box(3.0, 6.0, 3.0, 6.0)})


def _swap(rng: Random, family: str) -> Scene:
    """Agents that change sides, kept apart in continuous time."""
    step, horizon = _clock(rng)
    places = [((1.0, 5.0), 7.75, 4.5), ((9.0, 5.0), 1.0, 4.5), ((5.0, 1.0), 4.25, 7.5)]
    count = 3 if family == "three" else 2
    models = [_named(rng) if rng.random() < 0.7 else drawn_model(rng, True) for _ in range(count)]
    bodies, goals = [], {}
    for k, (model, (start, gx, gy)) in enumerate(zip(models, places, strict=False)):
        place = (start[0] + _number(rng, -0.4, 0.4), start[1] + _number(rng, -0.5, 0.5))
        bodies.append(_body(rng, model, place, f"r{k}"))
        goals[f"r{k}"] = _goal(rng, gx, gy)
    names = [b.name for b in bodies]
    gap = (_number(rng, 0.4, 1.0), _number(rng, 0.4, 1.0))
    pairs = [(a, b) for i, a in enumerate(names) for b in names[i + 1 :]]
    apart = {pair: (gap, Window(0, horizon - 1)) for pair in pairs}
    obstacles = _boxes(rng, 1) if count == 3 else ()
    keep = _out(tuple(bodies[:1]), obstacles, Window(0, horizon - 1))
    return Scene(
        family, step, horizon, SPACE, tuple(bodies), obstacles, keep, apart=apart, goals=goals
    )


def _inflated(rng: Random, family: str) -> Scene:
    """Grown boxes and sharp triangles, some of which touch only when grown."""
    grow = _number(rng, 0.1, 0.5) + 0.05
    x, y = _number(rng, 3.5, 5), _number(rng, 2, 6)
    gap = 2 * grow if rng.random() < 0.5 else 0.0
    parts = (
        box(x, x + 0.5, y, y + 1.5),
        Part(((x, y + 1.5 + gap), (x + 0.5, y + 1.5 + gap), (x + 0.25, y + 3.0))),
    )
    return _crossing(rng, family, _named(rng), (Obstacle("o", {0: parts}, grow),))


def _inside(rng: Random, family: str) -> Scene:
    """A corridor of touching or overlapping boxes that isn't left between the samples either."""
    step, horizon = _clock(rng)
    y, bend = _number(rng, 2, 4), _number(rng, 5, 7)
    over = float(rng.choice([0.0, 0.0, 0.5]))
    parts = (box(0.0, 5.0 + over, y, y + 1.5), box(5.0 - over, 6.5, y, bend + 1.5),
             box(6.5 - over, 10.0, bend, bend + 1.5))  # fmt: skip
    model = _named(rng) if rng.random() < 0.7 else drawn_model(rng, True)
    start = (_number(rng, 0.5, 2.0), y + 0.75)
    body = _body(rng, model, start)
    keep = {("r", "way"): Window(0, horizon - 1)}
    goal = {"r": box(8.0, 9.5, bend + 0.2, bend + 1.4)}
    return Scene(
        family, step, horizon, SPACE, (body,), regions={"way": parts}, keep_in=keep, goals=goal
    )


def _sampled(rng: Random, family: str) -> Scene:
    parts = tuple(_wall(rng, 0.0, _number(rng, 7, 9)))
    model = _named(rng) if rng.random() < 0.6 else drawn_model(rng, False)
    return _crossing(rng, family, model, (Obstacle("wall", {0: parts}),), swept=False)


FAMILIES: dict[str, Callable[[Random, str], Scene]] = {
    "single": _plain,
    "double": _plain,
    "turning": _turning,
    "continuous": _matrices,
    "discrete": _matrices,
    "union": _walls,
    "touching": _walls,
    "flush": _flush,
    "room": _room,
    "moving": _moving,
    "border": _border,
    "apart": _swap,
    "three": _swap,
    "inflated": _inflated,
    "inside": _inside,
    "sampled": _sampled,
}
