"""Random missions with link costs, like `two_agents_t8.stl`: text and table for a seed.

Tables are a log-distance mean with a symmetric Gaussian process on pairs of cells (random Fourier
features), on the scale of the shared table. Starts and goals lie 4 cells or more apart, obstacles
are one or two boxes on integer borders.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from stlc.files import write_atomic

Array = NDArray[np.float64]
SIZE = 10
_DISTANCE = [0.3, 1, 2, 3, 4.5, 6, 8, 10, 13]
_MEAN = [0.6, 1.32, 2.27, 2.79, 3.3, 3.68, 4.05, 4.3, 4.6]


@dataclass(frozen=True, slots=True)
class Family:
    """Size of the missions."""

    agents: int = 2
    steps: int = 8
    cells: int = 10

    @property
    def label(self) -> str:
        """Such as a2_t8_c10."""
        return f"a{self.agents}_t{self.steps}_c{self.cells}"


def table(cells: int, seed: int) -> Array:
    """Symmetric link costs (cells**2, cells**2)."""
    rng = np.random.default_rng(seed)
    centre = (np.arange(cells) + 0.5) * SIZE / cells
    at = np.stack(np.meshgrid(centre, centre, indexing="ij"), axis=-1).reshape(-1, 2)
    features = 400
    frequency = rng.normal(size=(features, 4)) / 2.0
    phase = rng.uniform(0, 2 * np.pi, features)
    left, right = at @ frequency[:, :2].T, at @ frequency[:, 2:].T + phase
    field = np.cos(left) @ np.cos(right).T - np.sin(left) @ np.sin(right).T
    field = np.sqrt(2 / features) * (field + field.T) / np.sqrt(2)
    distance = np.linalg.norm(at[:, None] - at[None], axis=2)
    mean = np.where(distance < 0.3, 0.42, np.interp(np.maximum(distance, 0.3), _DISTANCE, _MEAN))
    spread = np.minimum(0.07 + 0.05 * distance, 0.2)
    cost: Array = np.round(np.maximum(mean + spread * field, 0.05), 8)
    return (cost + cost.T) / 2


def write(folder: Path, seed: int, family: Family) -> Path:
    """Write mission and table; returns the mission's path."""
    name = f"{family.label}_s{seed}"
    rows = table(family.cells, seed)
    text = "\n".join(",".join(f"{v:.8f}" for v in row) for row in rows)
    write_atomic(folder / f"{name}.csv", text + "\n")
    path = folder / f"{name}.stl"
    write_atomic(path, mission(seed, family, f"{name}.csv"))
    return path


def mission(seed: int, family: Family, csv: str) -> str:
    """The mission's text."""
    rng = np.random.default_rng(1000 + seed)
    holes = [_hole(rng) for _ in range(int(rng.integers(1, 3)))]
    ends = _ends(rng, holes, family)
    names = [f"a{i + 1}" for i in range(family.agents)]
    last = f"[1, {family.steps}]"
    lines = ["step 1 s", f"horizon {family.steps}", f"workspace box [0, {SIZE}] x [0, {SIZE}]"]
    lines.append("dynamics cart = double_integrator")
    for name, (start, goal) in zip(names, ends, strict=True):
        lines.append(
            f"agent {name} : cart {{ start ({start[0]:g}, {start[1]:g}); control |u| <= 1; "
            "state |v| <= 2; speed <= 2 polygon 8 outer; effort_state (0, 0, 1, 1) }"
        )
        box = f"box [{goal[0]}, {goal[0] + 1}] x [{goal[1]}, {goal[1] + 1}]"
        lines.append(f"region goal_{name} = {box}")
    for k, hole in enumerate(holes):
        spans = [f"[{low}, {high}]" for low, high in hole]
        lines.append(f"obstacle block{k} = box {spans[0]} x {spans[1]}")
    lines.append(f'channel radio {{ partition {family.cells} x {family.cells}; table "{csv}" }}')
    for name in names:
        lines.append(f"require reach_{name}: eventually{last} {name} in goal_{name}")
        for k in range(len(holes)):
            lines.append(f"require clear_{name}_{k}: always{last} {name} outside block{k}")
    for i, first in enumerate(names):
        for second in names[i + 1 :]:
            lines.append(
                f"require apart_{first}_{second}: always{last} separation({first}, {second}) >= 0.5"
            )
    lines.append("minimize 0.1 * effort + 0.9 * link_cost(radio)")
    return "\n".join(lines) + "\n"


def _hole(rng: np.random.Generator) -> Array:
    low = rng.integers(2, 7, 2)
    return np.stack([low, low + rng.integers(1, 3, 2)], 1)


def _ends(
    rng: np.random.Generator, holes: list[Array], family: Family
) -> list[tuple[Array, Array]]:
    """Starts, and lower corners of the goals, for every agent."""
    found: list[tuple[Array, Array]] = []
    reach = min(9.0, 1.1 * family.steps)
    while len(found) < family.agents:
        cell, goal = rng.integers(0, 10, 2), rng.integers(0, 10, 2)
        start = cell + 0.5 if rng.random() < 0.5 else cell.astype(float)
        gap = np.abs(goal - cell)
        if not 4 <= gap.max() <= reach or gap.sum() > 1.7 * reach:
            continue
        if not (_free(cell - 0.5, cell + 1.5, holes) and _free(goal, goal + 1, holes)):
            continue
        near = [np.abs(s - start).max() < 1 or np.abs(g - goal).max() < 1 for s, g in found]
        if not any(near):
            found.append((start, goal))
    return found


def _free(low: Array, high: Array, holes: list[Array]) -> bool:
    return all(((low >= h[:, 1]) | (high <= h[:, 0])).any() for h in holes)
