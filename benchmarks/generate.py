"""Writes the generated missions of the registry: `python benchmarks/generate.py`.

Each file is what its generator gives for the parameters in `registry.py`; a test compares them.
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from generators import radio, scaling, stlpy, teams
from registry import SUITES

from stlc.bench.problem import Problem
from stlc.files import write_atomic

GENERATORS: dict[str, Callable[..., str]] = {
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
    "patrol": scaling.patrol,
}
MISSIONS = Path(__file__).parent / "missions"


def generated(problem: Problem) -> str:
    """The text of a generated problem."""
    return GENERATORS[problem.generator](**problem.parameters)


def main() -> None:
    """Write every generated mission."""
    for suite in SUITES:
        for problem in suite.problems:
            if problem.generator:
                path = MISSIONS / problem.file
                path.parent.mkdir(exist_ok=True)
                write_atomic(path, generated(problem))


if __name__ == "__main__":
    main()
