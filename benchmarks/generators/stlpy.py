"""The scenario families of stlpy 0.3.0 (V. Kurtz, H. Lin, MIT licence), stated in our language.

Dynamics, bounds, regions and the random draws are stlpy's (`numpy.random.seed`, the same order);
the objective is to maximise robustness, without stlpy's quadratic costs. stlpy's `a U[0,T] b` asks
for `a` only before the step at which `b` holds, ours there too; `b or (a until[0,T-1] next b)` is
stlpy's meaning, exactly, at every run.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from generators.text import Box, clock, comment, document, region

_DYNAMICS = """dynamics cart {
  states px py vx vy
  inputs ux uy
  A = [[1, 0, 1, 0], [0, 1, 0, 1], [0, 0, 1, 0], [0, 0, 0, 1]]
  B = [[0, 0], [0, 0], [1, 0], [0, 1]]
  position px py
  velocity vx vy
}"""
_FIELD: Box = (0, 10, 0, 10)
_SIDE = 1.0  # of stones and targets [m]


def _mission(
    title: str,
    steps: int,
    start: tuple[float, float],
    regions: dict[str, Box],
    requirements: list[str],
    workspace: Box = _FIELD,
    speed: float = 1.0,
) -> str:
    robot = [
        "agent robot : cart {",
        f"  start ({start[0]:g}, {start[1]:g})",
        "  control |u| <= 0.5",
        f"  state |v| <= {speed:g}",
        "}",
    ]
    return document(
        comment(f"{title}: a scenario of stlpy 0.3.0 (V. Kurtz, H. Lin), restated."),
        clock(steps, workspace),
        _DYNAMICS,
        robot,
        [region(name, bounds) for name, bounds in regions.items()],
        [f"require {line}" for line in requirements],
        "maximize robustness",
    )


def _clear(names: list[str]) -> str:
    return "clear: always (" + " and ".join(f"robot outside {name}" for name in names) + ")"


def _any(names: list[str]) -> str:
    return "(" + " or ".join(f"robot in {name}" for name in names) + ")"


def reach_avoid(steps: int) -> str:
    """Reach a goal around one obstacle."""
    regions: dict[str, Box] = {"goal": (7, 8, 8, 9), "obstacle": (3, 5, 4, 6)}
    wanted = [_clear(["obstacle"]), "arrive: eventually robot in goal"]
    return _mission("Reach and avoid", steps, (1, 2), regions, wanted)


def either_or(steps: int, dwell: int) -> str:
    """Stay `dwell` steps in one of two targets on the way."""
    regions: dict[str, Box] = {
        "goal": (7, 8, 8, 9),
        "target_one": (1, 2, 6, 7),
        "target_two": (7, 8, 4.5, 5.5),
        "obstacle": (3, 5, 4, 6),
    }
    stay = f"always[0, {dwell}] robot in target_"
    wanted = [
        f"visit: eventually[0, {steps - dwell}] ({stay}one or {stay}two)",
        _clear(["obstacle"]),
        "arrive: eventually robot in goal",
    ]
    return _mission("Either or", steps, (2, 2), regions, wanted)


def narrow_passage(steps: int) -> str:
    """Two goals, one behind a gap of half a metre."""
    regions: dict[str, Box] = {
        "obs1": (2, 5, 4, 6),
        "obs2": (5.5, 9, 3.8, 5.7),
        "obs3": (4.6, 8, 0.5, 3.5),
        "obs4": (2.2, 4.4, 6.4, 11),
        "goal1": (7, 8, 8, 9),
        "goal2": (9.5, 10.5, 1.5, 2.5),
    }
    wanted = [
        f"arrive: eventually {_any(['goal1', 'goal2'])}",
        _clear([f"obs{k}" for k in range(1, 5)]),
    ]
    return _mission("Narrow passage", steps, (3, 3.6), regions, wanted)


def stepping_stones(steps: int, stones: int, seed: int) -> str:
    """Stay on randomly placed stones; the last one is the goal."""
    draw = np.random.RandomState(seed)
    names = [f"stone{k}" for k in range(1, stones + 1)]
    regions = {name: _square(draw, _SIDE) for name in names}
    wanted = [f"dry: always {_any(names)}", f"arrive: eventually robot in {names[-1]}"]
    return _mission("Stepping stones", steps, (2, 1.3), regions, wanted)


def multitarget(steps: int, obstacles: int, groups: int, targets: int, seed: int) -> str:
    """Visit one target of each group, all placed at random."""
    draw = np.random.RandomState(seed)
    walls = {f"obs{k}": _square(draw, 2 * _SIDE) for k in range(1, obstacles + 1)}
    sets = [[f"T{g}_{k}" for k in range(1, targets + 1)] for g in range(1, groups + 1)]
    goals = {name: _square(draw, _SIDE) for names in sets for name in names}
    wanted = [_clear(list(walls))]
    wanted += [f"visit{g}: eventually {_any(names)}" for g, names in enumerate(sets, 1)]
    return _mission("Random multitarget", steps, (5, 2), walls | goals, wanted)


def _square(draw: np.random.RandomState, side: float) -> Box:
    x = float(draw.uniform(0, 9))
    y = float(draw.uniform(0, 9))
    return (x, x + side, y, y + side)


def door_puzzle(steps: int, doors: int) -> str:
    """Fetch keys before the doors they open."""
    regions: dict[str, Box] = {
        "obs1": (8, 15.01, -0.01, 4),
        "obs2": (8, 15.01, 6, 10.01),
        "obs3": (3.5, 5, -0.01, 2.5),
        "obs4": (-0.01, 2.5, 4, 6),
        "obs5": (3.5, 5, 7.5, 10.01),
    }
    wanted = [_clear(list(regions))]
    keys: list[Box] = [(1, 2, 1, 2), (1, 2, 8, 9), (6, 7, 8, 9), (6, 7, 1, 2)]
    fronts = [12.8, 11.5, 10.2, 8.9]
    for k in range(1, doors + 1):
        front = fronts[k - 1]
        regions |= {
            f"door{k}": (front, round(front + 1.2, 9), 3.99, 6.01),
            f"key{k}": keys[k - 1],
        }
        key, closed = f"robot in key{k}", f"robot outside door{k}"
        wanted.append(f"unlock{k}: {key} or ({closed} until[0, {steps - 1}] next {key})")
    regions["goal"] = (14.1, 14.9, 4.1, 5.9)
    wanted.append("arrive: eventually robot in goal")
    return _mission("Door puzzle", steps, (6, 1), regions, wanted, (0, 15, 0, 10), 2.0)


def frugal(scenario: Callable[..., str]) -> Callable[..., str]:
    """A scenario that is to be fulfilled at the least effort instead of as robustly as can be."""

    def made(**parameters: int) -> str:
        return scenario(**parameters).replace("maximize robustness", "minimize effort")

    return made
