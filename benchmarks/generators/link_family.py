"""Random missions like `two_agents_t8.stl`: link costs from a table, or requirements on the link.

Starts and goals lie 4 cells or more apart, obstacles are one or two boxes on integer borders.
Tables are a log-distance mean with a symmetric Gaussian process on pairs of cells (random Fourier
features), on the scale of the given table; that shape was chosen by eye.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from generators.text import apart, channel, clock, comment, document, interval

Array = NDArray[np.float64]
_SIZE = 10
_DISTANCE = [0.3, 1, 2, 3, 4.5, 6, 8, 10, 13]
_MEAN = [0.6, 1.32, 2.27, 2.79, 3.3, 3.68, 4.05, 4.3, 4.6]
_FEATURES = 400
_DIGITS = 4
_TALKS = (
    ("a level held throughout", "always[2, {steps}] rssi({a}, {b}) >= -40 dBm"),
    (
        "a bit error rate, for three steps",
        "eventually[2, {late}] always[0, 2] ber({a}, {b}) <= 1e-3",
    ),
    ("packets again and again", "always[0, {late}] eventually[0, 2] prr({a}, {b}) >= 0.9"),
)


def table(cells: int, seed: int) -> Array:
    """Symmetric link costs (cells**2, cells**2), four digits."""
    rng = np.random.default_rng(seed)
    centre = (np.arange(cells) + 0.5) * _SIZE / cells
    at = np.stack(np.meshgrid(centre, centre, indexing="ij"), axis=-1).reshape(-1, 2)
    frequency = rng.normal(size=(_FEATURES, 4)) / 2.0
    phase = rng.uniform(0, 2 * np.pi, _FEATURES)
    left, right = at @ frequency[:, :2].T, at @ frequency[:, 2:].T + phase
    field = np.cos(left) @ np.cos(right).T - np.sin(left) @ np.sin(right).T
    field = np.sqrt(2 / _FEATURES) * (field + field.T) / np.sqrt(2)
    distance = np.linalg.norm(at[:, None] - at[None], axis=2)
    mean = np.where(distance < 0.3, 0.42, np.interp(np.maximum(distance, 0.3), _DISTANCE, _MEAN))
    spread = np.minimum(0.07 + 0.05 * distance, 0.2)
    cost: Array = np.round(np.maximum(mean + spread * field, 0.05), _DIGITS)
    return np.maximum(cost, cost.T)


def table_name(cells: int, seed: int) -> str:
    """Its file beside the missions."""
    return f"links_c{cells}_s{seed}.npz"


def headline(seed: int) -> str:
    """`two_agents_t8` with another table."""
    text = (Path(__file__).parents[1] / "missions" / "two_agents_t8.stl").read_text()
    lines = [line for line in text.splitlines(keepends=True) if not line.startswith("#")]
    title = comment(f"two_agents_t8 with the random table {seed}.")
    return (
        title + "\n" + "".join(lines).replace("two_agents_t8_link_cost.csv", table_name(10, seed))
    )


def links(agents: int, steps: int, cells: int, seed: int) -> str:
    """Every pair pays for its link."""
    title = f"{agents} agents, {steps} steps, {cells} x {cells} cells, seed {seed}: links cost."
    radio = [f'channel radio {{ partition {cells} x {cells}; table "{table_name(cells, seed)}" }}']
    scene = _scene(agents, steps, seed)
    price = "minimize 0.1 * effort + 0.9 * link_cost(radio)"
    return document(comment(title), *scene[:-1], radio, scene[-1], price)


def talks(kind: int, agents: int, steps: int, cells: int, seed: int) -> str:
    """Neighbours in the team must hear each other; effort is minimised."""
    what, formula = _TALKS[kind]
    title = f"{agents} agents, {steps} steps, {cells} x {cells} cells, seed {seed}: {what}."
    names = _names(agents)
    talk = [
        f"require talk{k}: " + formula.format(a=a, b=b, steps=steps, late=steps - 2)
        for k, (a, b) in enumerate(pairwise(names), 1)
    ]
    scene = _scene(agents, steps, seed)
    return document(
        comment(title), *scene[:-1], channel(cells, -44), scene[-1] + talk, "minimize effort"
    )


def _names(agents: int) -> list[str]:
    return [f"r{k}" for k in range(1, agents + 1)]


def _scene(agents: int, steps: int, seed: int) -> list[list[str]]:
    """Clock, agents, places; requirements on motion last."""
    rng = np.random.default_rng(1000 + seed)
    holes = [_hole(rng) for _ in range(int(rng.integers(1, 3)))]
    ends = _ends(rng, holes, agents, steps)
    bodies, places, wanted = ["dynamics cart = double_integrator"], [], []
    for name, (start, goal) in zip(_names(agents), ends, strict=True):
        bodies += [
            f"agent {name} : cart {{",
            f"  start ({start[0]:g}, {start[1]:g})",
            "  control |u| <= 1",
            "  state |v| <= 2",
            "  speed <= 2 polygon 8 outer",
            "  effort_state (0, 0, 1, 1)",
            "}",
        ]
        places.append(f"region goal_{name} = {_box(goal, goal + 1)}")
        wanted.append(f"require reach_{name}: eventually[1, {steps}] {name} in goal_{name}")
    for k, (low, high) in enumerate(holes, 1):
        places.append(f"obstacle block{k} = {_box(low, high)}")
        clear = f"always[1, {steps}] forall a in agents: a outside block{k}"
        wanted.append(f"require clear{k}: {clear}")
    time = clock(steps, (0, _SIZE, 0, _SIZE))
    return [time, bodies, places, [*wanted, *apart(agents, 0.5)]]


def _box(low: Sequence[float], high: Sequence[float]) -> str:
    return f"box {interval(low[0], high[0])} x {interval(low[1], high[1])}"


def _hole(rng: np.random.Generator) -> tuple[Array, Array]:
    low = rng.integers(2, 7, 2).astype(float)
    return low, low + rng.integers(1, 3, 2)


def _ends(
    rng: np.random.Generator, holes: list[tuple[Array, Array]], agents: int, steps: int
) -> list[tuple[Array, Array]]:
    """Starts, and lower corners of the goals, for every agent."""
    found: list[tuple[Array, Array]] = []
    reach = min(9.0, 1.1 * steps)
    while len(found) < agents:
        cell, goal = rng.integers(0, 10, 2).astype(float), rng.integers(0, 10, 2).astype(float)
        start = cell + 0.5 if rng.random() < 0.5 else cell
        gap = np.abs(goal - cell)
        if not 4 <= gap.max() <= reach or gap.sum() > 1.7 * reach:
            continue
        if not (_free(cell - 0.5, cell + 1.5, holes) and _free(goal, goal + 1, holes)):
            continue
        near = [np.abs(s - start).max() < 1 or np.abs(g - goal).max() < 1 for s, g in found]
        if not any(near):
            found.append((start, goal))
    return found


def _free(low: Array, high: Array, holes: list[tuple[Array, Array]]) -> bool:
    return all(((low >= top) | (high <= bottom)).any() for bottom, top in holes)
