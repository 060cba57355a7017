"""Writes the generated missions of the registry: `python benchmarks/generate.py`.

Each file is what its generator gives for the parameters in `registry.py`; a test compares them.
"""

from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path

import numpy as np
from generators import link_family, long, radio, scaling, stlpy, teams
from numpy.typing import NDArray
from registry import SUITES

from stlc.bench.problem import Problem
from stlc.files import write_atomic

_TABLE = re.compile(r"links_c(\d+)_s(\d+)\.npz")
GENERATORS: dict[str, Callable[..., str]] = {
    "headline": link_family.headline,
    "links": link_family.links,
    "talks": link_family.talks,
    "reach_avoid": stlpy.reach_avoid,
    "either_or": stlpy.either_or,
    "narrow_passage": stlpy.narrow_passage,
    "stepping_stones": stlpy.stepping_stones,
    "multitarget": stlpy.multitarget,
    "door_puzzle": stlpy.door_puzzle,
    "radio": radio.radio,
    "team": teams.team,
    "radio_team": teams.radio_team,
    "connected_team": teams.connected_team,
    "swarm": teams.swarm,
    "patrol": scaling.patrol,
    "rounds": long.rounds,
    "maze": long.maze,
}
for _name in ("reach_avoid", "either_or", "narrow_passage", "stepping_stones", "multitarget",
              "door_puzzle"):  # fmt: skip
    GENERATORS[f"frugal_{_name}"] = stlpy.frugal(GENERATORS[_name])
Array = NDArray[np.float64]
MISSIONS = Path(__file__).parent / "missions"


def generated(problem: Problem) -> str:
    """The text of a generated problem."""
    return GENERATORS[problem.generator](**problem.parameters)


def tables(problem: Problem) -> dict[str, Array]:
    """The random tables a problem reads, by the names of their files."""
    found = [(name, _TABLE.fullmatch(Path(name).name)) for name in problem.data]
    return {name: link_family.table(int(m[1]), int(m[2])) for name, m in found if m is not None}


def main() -> None:
    """Write every generated mission, and the tables that they read."""
    for problem in {p.file: p for suite in SUITES for p in suite.problems if p.generator}.values():
        path = MISSIONS / problem.file
        path.parent.mkdir(exist_ok=True)
        write_atomic(path, generated(problem))
        for name, values in tables(problem).items():
            np.savez_compressed(MISSIONS / name, cost=values)


if __name__ == "__main__":
    main()
