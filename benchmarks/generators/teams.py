"""Teams: agents in a column change sides around a pillar, far enough from each other."""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import combinations

import numpy as np

from generators.text import Box, apart, box, carts, channel, clock, comment, document, region

_FIELD: Box = (0, 10, 0, 10)
_LEVEL = "-44 dBm"


def _stations(agents: int) -> list[float]:
    """Heights of the agents at their start [m], evenly spread."""
    return [1 + 8 * k / (agents - 1) if agents > 1 else 5.0 for k in range(agents)]


def _scene(agents: int, steps: int) -> tuple[list[str], ...]:
    heights = _stations(agents)
    starts = [(1.0, round(y, 3)) for y in heights]
    goals: list[Box] = [
        (8, 9, max(0.0, round(y - 0.5, 3)), min(10.0, round(y + 0.5, 3))) for y in reversed(heights)
    ]
    wanted = [f"require reach{k}: eventually r{k} in goal{k}" for k in range(1, agents + 1)]
    return (
        clock(steps, _FIELD),
        carts(starts),
        [
            *(region(f"goal{k}", bounds) for k, bounds in enumerate(goals, 1)),
            "obstacle pillar = box [4, 6] x [4, 6]",
        ],
        wanted,
        ["require clear: always forall a in agents: a outside pillar", *apart(agents, 0.5)],
    )


def team(agents: int, steps: int) -> str:
    """No radio: effort alone."""
    time, bodies, places, goals, safety = _scene(agents, steps)
    title = comment(f"{agents} agents change sides in {steps} steps.")
    return document(title, time, bodies, places, [*goals, *safety], "minimize effort")


def radio_team(agents: int, steps: int, cells: int) -> str:
    """Every pair pays for its link."""
    time, bodies, places, goals, safety = _scene(agents, steps)
    title = comment(f"{agents} agents change sides in {steps} steps; every pair pays for its link.")
    price = "minimize 0.1 * effort + 0.9 * link_cost(radio)"
    return document(title, time, bodies, places, channel(cells), [*goals, *safety], price)


def connected_team(agents: int, steps: int, cells: int) -> str:
    """Every pair must hear each other at every step."""
    time, bodies, places, goals, safety = _scene(agents, steps)
    talk = [
        f"require talk{a}{b}: always rssi(r{a}, r{b}) >= {_LEVEL}"
        for a, b in combinations(range(1, agents + 1), 2)
    ]
    title = comment(f"{agents} agents change sides in {steps} steps and always hear each other.")
    return document(
        title, time, bodies, places, channel(cells), [*goals, *safety, *talk], "minimize effort"
    )


def swarm(agents: int, steps: int, seed: int) -> str:
    """Many agents from random starts to random goals past a wall, all pairs apart between samples
    too; no radio. There is as much room for each whatever their number."""
    rng = np.random.default_rng(seed)
    across = 2 * math.ceil(1.5 * math.sqrt(agents) + 2)
    free = [(x, y) for x in range(across) for y in range(across) if abs(y + 0.5 - across / 2) > 2]
    starts = [(x + 0.5, y + 0.5) for x, y in rng.permutation(free)[:agents]]
    field: Box = (0, across, 0, across)
    goals = [_near(start, free, steps, rng) for start in starts]
    wall: Box = (across / 4, 3 * across / 4, across / 2 - 1, across / 2 + 1)
    return document(
        comment(f"{agents} agents past a wall in {steps} steps, seed {seed}."),
        clock(steps, field),
        carts(starts),
        [
            *(region(f"goal{k}", goal) for k, goal in enumerate(goals, 1)),
            f"obstacle wall = {box(wall)}",
        ],
        [f"require reach{k}: eventually r{k} in goal{k}" for k in range(1, agents + 1)],
        [
            "require clear: always forall a in agents: a outside wall swept",
            "require apart: always forall (a, b) in pairs: separation(a, b) >= 0.5 m swept",
        ],
        "minimize effort",
    )


def _near(
    start: tuple[float, float],
    free: Sequence[tuple[int, int]],
    steps: int,
    rng: np.random.Generator,
) -> Box:
    """A goal of 1 x 1 m within easy reach."""
    reach = [(x, y) for x, y in free if max(abs(x - start[0]), abs(y - start[1])) <= 0.75 * steps]
    x, y = reach[int(rng.integers(len(reach)))]
    return (float(x), float(x) + 1, float(y), float(y) + 1)
