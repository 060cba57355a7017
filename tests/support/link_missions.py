"""Small random missions with link costs, as text with tables beside it."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from stlc import backends
from stlc.api import load
from stlc.backends.base import Progress, SolveOptions
from stlc.errors import InfeasibleError
from stlc.milp.compile import Compiled, compile_mission
from stlc.mission import Mission
from stlc.solve.strategies import run_strategy

SIZE = 6


@dataclass(frozen=True, slots=True)
class Variant:
    """What a mission is made of."""

    agents: int = 2
    steps: int = 5
    cells: int = 4
    single: bool = False
    dt: float = 1.0
    station: bool = False
    extra: str = ""


def _agent_and_goal(
    name: str, rng: np.random.Generator, hole: np.ndarray, variant: Variant
) -> list[str]:
    start = _free_point(rng, hole)
    goal = np.clip(start + rng.integers(-2, 3, 2), 0, SIZE - 1)
    region = f"region goal_{name} = box {_span(goal[0])} x {_span(goal[1])}"
    return [_agent(name, start, variant), region]


def write_mission(folder: Path, seed: int, variant: Variant) -> Mission:
    """A mission with random starts, goals, an obstacle and a table; on a coarse raster, so that
    starts, faces and cell borders often coincide."""
    rng = np.random.default_rng(seed)
    names = [f"a{i}" for i in range(variant.agents)]
    table = rng.uniform(0.2, 4.0, (variant.cells**2,) * 2)
    np.savetxt(folder / "cost.csv", table + table.T, delimiter=",")
    lines = [
        f"step {variant.dt:g} s",
        f"horizon {variant.steps}",
        f"workspace box [0, {SIZE}] x [0, {SIZE}]",
    ]
    corner = rng.integers(1, SIZE - 2, 2)
    hole = np.stack([corner, corner + rng.integers(1, 3, 2)], 1)
    for name in names:
        lines += _agent_and_goal(name, rng, hole, variant)
    lines.append(
        f"obstacle block = box [{hole[0, 0]}, {hole[0, 1]}] x [{hole[1, 0]}, {hole[1, 1]}]"
    )
    if "west" in variant.extra:
        lines += [
            f"region west = box [0, 5] x [0, {SIZE}]",
            f"region east = box [1, 6] x [0, {SIZE}]",
        ]
    if variant.station:
        lines.append(f"station base at ({rng.uniform(0, SIZE):.2f}, {rng.uniform(0, SIZE):.2f})")
    lines += [
        "channel radio {",
        f"  partition {variant.cells} x {variant.cells}",
        '  table "cost.csv"',
        "}",
        *_requirements(names, variant),
        f"minimize {rng.uniform(0.05, 0.5):.3f} * effort + 0.9 * {_cost(names, variant)}",
    ]
    path = folder / f"mission_{seed}.stl"
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")
    return load(path)


def _free_point(rng: np.random.Generator, hole: np.ndarray) -> np.ndarray:
    while True:
        point: np.ndarray = rng.integers(0, SIZE + 1, 2)
        if not ((point > hole[:, 0]) & (point < hole[:, 1])).all():
            return point


def _span(low: int) -> str:
    return f"[{low}, {low + 1}]"


def _agent(name: str, start: np.ndarray, variant: Variant) -> str:
    if variant.single:
        return (
            f"agent {name} : single_integrator {{ start ({start[0]}, {start[1]}); "
            f"control |u| <= {1.5 / variant.dt:g} }}"
        )
    return (
        f"agent {name} : double_integrator {{ start ({start[0]}, {start[1]}); "
        f"control |u| <= {1 / variant.dt**2:g}; speed <= {2 / variant.dt:g} polygon 8 outer }}"
    )


def _requirements(names: list[str], variant: Variant) -> list[str]:
    last = variant.steps
    lines = [f"require reach_{n}: eventually[2, {last}] {n} in goal_{n}" for n in names]
    lines += [f"require clear_{n}: always[1, {last}] {n} outside block" for n in names]
    lines.append(f"require apart: always[1, {last}] separation(a0, a1) >= 0.5")
    if variant.extra:
        lines.append(f"require more: {variant.extra}")
    return lines


def _cost(names: list[str], variant: Variant) -> str:
    if not variant.station:
        return "link_cost(radio)"
    pairs = [f"({names[0]}, {names[1]})", f"({names[0]}, base)"]
    return f"link_cost(radio, {', '.join(pairs)})"


def compiled_mission(folder: Path, seed: int, variant: Variant) -> Compiled:
    """The first mission of seed, seed + 1000, ... that ranges alone don't rule out."""
    try:
        return compile_mission(write_mission(folder, seed, variant))
    except InfeasibleError:
        return compiled_mission(folder, seed + 1000, variant)


def assert_same_optimum(compiled: Compiled) -> None:
    """The search for link costs and the plain model agree, and no bound told is above."""
    backend, seen = backends.get("highs"), list[Progress]()
    plain = backend.solve(compiled.model, SolveOptions(gap=1e-6))
    found = run_strategy(
        "links", compiled, backend, SolveOptions(gap=1e-6, on_progress=seen.append)
    )
    assert found.status is plain.status
    if plain.objective is None:
        return
    assert found.objective is not None
    slack = 2e-6 * max(1.0, abs(plain.objective))
    assert abs(found.objective - plain.objective) <= 1.5 * slack
    assert all(p.bound is None or p.bound <= plain.objective + slack for p in seen)
