"""Random scenes by family and seed. Worlds are about 10 m wide."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from truth.draw_parts import (
    SPACE,
    Random,
    crossing,
    drawn_body,
    drawn_clock,
    drawn_number,
    goal_box,
    kept_out,
    left_start,
    named_model,
    some_boxes,
    touching_pieces,
)
from truth.models import drawn_model
from truth.scene import DOUBLE, SINGLE, Body, Model, Obstacle, Part, Ring, Scene, Window, box


def draw(family: str, seed: int) -> Scene:
    """The scene of a family and a seed."""
    return FAMILIES[family](np.random.default_rng([seed, *family.encode()]), family)


def _plain(rng: Random, family: str) -> Scene:
    kind = SINGLE if family == "single" else DOUBLE
    return crossing(rng, family, Model(kind), some_boxes(rng, int(rng.integers(1, 4))))


def _turning(rng: Random, family: str) -> Scene:
    scene = crossing(rng, family, Model(DOUBLE), some_boxes(rng, 2))
    start = (*scene.bodies[0].start[:2], drawn_number(rng, 0.5, 1.0), 0.0)
    body = Body("r", Model(DOUBLE), start, 2.0, 2.0, turns=True)
    return Scene(
        family, 1.0, 8, SPACE, (body,), scene.obstacles,
        kept_out((body,), scene.obstacles, Window(0, 7)), goals=scene.goals,
    )  # fmt: skip


def _matrices(rng: Random, family: str) -> Scene:
    model = drawn_model(rng, family == "continuous")
    return crossing(rng, family, model, some_boxes(rng, int(rng.integers(1, 3))))


def _walls(rng: Random, family: str) -> Scene:
    """Pieces of one obstacle, or obstacles, that touch; closed, flush, or with a gap at an end."""
    low, high = (
        (0.0, 10.0),
        (0.0, drawn_number(rng, 6, 8.5)),
        (drawn_number(rng, 1, 3), 10.0),
        (-1.0, 11.0),
    )[int(rng.integers(0, 4))]
    parts = touching_pieces(rng, low, high)
    closed = low <= 0 and high >= 10
    if family == "union":
        obstacles: tuple[Obstacle, ...] = (Obstacle("wall", {0: tuple(parts)}),)
    else:
        obstacles = tuple(Obstacle(f"w{k}", {0: (p,)}) for k, p in enumerate(parts))
    return crossing(rng, family, named_model(rng), obstacles, closed=closed)


def _flush(rng: Random, family: str) -> Scene:
    """Walls that stand on the border of a workspace, which may be a slanted polygon."""
    space, x = SPACE, drawn_number(rng, 3.5, 5.5)
    if rng.random() < 0.4:
        space = ((0.0, 0.0), (10.0, -1.0), (11.0, 10.0), (0.0, 10.0))
    floor = 0.0 if space is SPACE else -0.1 * x
    width, top = drawn_number(rng, 0.25, 1.0) + 0.1, drawn_number(rng, 4, 9.5)
    right = 0.0 if space is SPACE else -0.1 * (x + width)
    wall = Part(((x, floor), (x + width, right), (x + width, top), (x, top)), is_box=space is SPACE)
    obstacles = [Obstacle("wall", {0: (wall,)})]
    closed = bool(rng.random() < 0.3)
    if closed:
        obstacles.append(Obstacle("lid", {0: (box(x, x + width, top, 10.0),)}))
    model = named_model(rng) if rng.random() < 0.7 else drawn_model(rng, True)
    return crossing(rng, family, model, tuple(obstacles), space, closed)


def _room(rng: Random, family: str) -> Scene:
    """Non-convex polygons: rings with a hole that has the start in it, hooks, and stars."""
    x, y, w = drawn_number(rng, 3, 4), drawn_number(rng, 2, 3.5), drawn_number(rng, 3, 4)
    t = drawn_number(rng, 0.25, 0.75) + 0.05
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
    scene = crossing(rng, family, named_model(rng), (Obstacle("room", {0: (part,)}),))
    if rng.random() < 0.5:
        return scene
    goals = {"r": box(x + w / 3, x + w / 2, y + w / 3, y + w / 2)}
    return Scene(
        family, scene.step, scene.horizon, SPACE, scene.bodies, scene.obstacles, scene.keep_out,
        goals=goals, closed=bool(part.holes),
    )  # fmt: skip


def _moving(rng: Random, family: str) -> Scene:
    """Trucks on their way, some flush with the border, some of two touching parts."""
    step, horizon = drawn_clock(rng)
    body = drawn_body(rng, named_model(rng), left_start(rng))
    obstacles = []
    for k in range(int(rng.integers(1, 3))):
        x, y = drawn_number(rng, 3, 6), drawn_number(rng, 2, 8)
        dx, dy = drawn_number(rng, -0.4, 0.4) * step, drawn_number(rng, -0.7, 0.7) * step
        w, h = drawn_number(rng, 0.5, 1.5) + 0.1, drawn_number(rng, 0.5, 2.5) + 0.1
        if rng.random() < 0.3:
            y, dy = 0.0, 0.0
        every = int(rng.choice([1, 1, 1, 2]))
        frames = {}
        for n in range(0, horizon, every):
            a, b = x + n * dx, y + n * dy
            frames[n] = (box(a, a + w, b, b + h),)
            if k == 1:
                frames[n] += (box(a, a + w, b + h, b + 1.5 * h),)
        obstacles.append(
            Obstacle(f"truck{k}", frames, drawn_number(rng, 0, 0.3) if k == 0 else 0.0)
        )
    made = tuple(obstacles)
    keep = kept_out((body,), made, Window(0, horizon - 1))
    return Scene(family, step, horizon, SPACE, (body,), made, keep, goals={"r": goal_box(rng)})


def _border(rng: Random, family: str) -> Scene:
    """Fast along and towards the border, with every kind of dynamics."""
    models = [Model(DOUBLE), drawn_model(rng, True), drawn_model(rng, True)]
    model = models[int(rng.integers(0, 3))]
    step, horizon = float(rng.choice([1.0, 2.0])), 5
    body = drawn_body(rng, model, (drawn_number(rng, 0.25, 1.5), drawn_number(rng, 0.25, 2.0)))
    full = np.array(body.start)
    assert model.velocity is not None
    full[list(model.velocity)] = (drawn_number(rng, -1.5, 0.5), drawn_number(rng, -1.5, 0.5))
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
    step, horizon = drawn_clock(rng)
    places = [((1.0, 5.0), 7.75, 4.5), ((9.0, 5.0), 1.0, 4.5), ((5.0, 1.0), 4.25, 7.5)]
    count = 3 if family == "three" else 2
    models = [
        named_model(rng) if rng.random() < 0.7 else drawn_model(rng, True) for _ in range(count)
    ]
    bodies, goals = [], {}
    for k, (model, (start, gx, gy)) in enumerate(zip(models, places, strict=False)):
        place = (start[0] + drawn_number(rng, -0.4, 0.4), start[1] + drawn_number(rng, -0.5, 0.5))
        bodies.append(drawn_body(rng, model, place, f"r{k}"))
        goals[f"r{k}"] = goal_box(rng, gx, gy)
    names = [b.name for b in bodies]
    gap = (drawn_number(rng, 0.4, 1.0), drawn_number(rng, 0.4, 1.0))
    pairs = [(a, b) for i, a in enumerate(names) for b in names[i + 1 :]]
    apart = {pair: (gap, Window(0, horizon - 1)) for pair in pairs}
    obstacles = some_boxes(rng, 1) if count == 3 else ()
    keep = kept_out(tuple(bodies[:1]), obstacles, Window(0, horizon - 1))
    return Scene(
        family, step, horizon, SPACE, tuple(bodies), obstacles, keep, apart=apart, goals=goals
    )


def _inflated(rng: Random, family: str) -> Scene:
    """Grown boxes and sharp triangles, some of which touch only when grown."""
    grow = drawn_number(rng, 0.1, 0.5) + 0.05
    x, y = drawn_number(rng, 3.5, 5), drawn_number(rng, 2, 6)
    gap = 2 * grow if rng.random() < 0.5 else 0.0
    parts = (
        box(x, x + 0.5, y, y + 1.5),
        Part(((x, y + 1.5 + gap), (x + 0.5, y + 1.5 + gap), (x + 0.25, y + 3.0))),
    )
    return crossing(rng, family, named_model(rng), (Obstacle("o", {0: parts}, grow),))


def _inside(rng: Random, family: str) -> Scene:
    """A corridor of touching or overlapping boxes that isn't left between the samples either."""
    step, horizon = drawn_clock(rng)
    y, bend = drawn_number(rng, 2, 4), drawn_number(rng, 5, 7)
    over = float(rng.choice([0.0, 0.0, 0.5]))
    parts = (box(0.0, 5.0 + over, y, y + 1.5), box(5.0 - over, 6.5, y, bend + 1.5),
             box(6.5 - over, 10.0, bend, bend + 1.5))  # fmt: skip
    model = named_model(rng) if rng.random() < 0.7 else drawn_model(rng, True)
    start = (drawn_number(rng, 0.5, 2.0), y + 0.75)
    body = drawn_body(rng, model, start)
    keep = {("r", "way"): Window(0, horizon - 1)}
    goal = {"r": box(8.0, 9.5, bend + 0.2, bend + 1.4)}
    return Scene(
        family, step, horizon, SPACE, (body,), regions={"way": parts}, keep_in=keep, goals=goal
    )


def _sampled(rng: Random, family: str) -> Scene:
    parts = tuple(touching_pieces(rng, 0.0, drawn_number(rng, 7, 9)))
    model = named_model(rng) if rng.random() < 0.6 else drawn_model(rng, False)
    return crossing(rng, family, model, (Obstacle("wall", {0: parts}),), swept=False)


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
