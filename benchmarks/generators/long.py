"""Long missions of one agent: rounds to be made for ever, rooms whose doors have keys."""

from __future__ import annotations

from generators.text import Box, box, clock, comment, document, region


def rounds(steps: int, period: int) -> str:
    """Four corners, each visited again within `period` steps at the latest."""
    corners: dict[str, Box] = {
        "A": (0, 3, 0, 3), "B": (7, 10, 0, 3), "C": (7, 10, 7, 10), "D": (0, 3, 7, 10),
    }  # fmt: skip
    return document(
        comment(f"Four corners every {period} steps, over {steps} steps."),
        clock(steps, (0, 10, 0, 10)),
        "agent r : double_integrator { start (2, 5); control |u| <= 2; speed <= 3 }",
        [*(region(name, bounds) for name, bounds in corners.items()),
         "obstacle mid = box [4, 6] x [4, 6]"],
        [f"require rounds: forall g in regions: always[0, {steps - period}] "
         f"eventually[0, {period}] r in g",
         "require clear: always r outside mid swept"],
        "minimize effort",
    )  # fmt: skip


_ROOM, _HIGH, _THICK = 4.0, 8.0, 0.2  # m: length and height of a room, half a wall


def maze(doors: int) -> str:
    """Rooms in a row, each door shut until its key was fetched, which lies a room or two before
    it; the goal is behind the last."""
    walls, openings, keys = dict[str, Box](), dict[str, Box](), dict[str, Box]()
    for k in range(1, doors + 1):
        left, right = _ROOM * k - _THICK, _ROOM * k + _THICK
        low = 1.0 if k % 2 else 5.0  # the gap is below, then above
        walls |= {f"low{k}": (left, right, 0, low), f"high{k}": (left, right, low + 2, _HIGH)}
        openings[f"door{k}"] = (left, right, low, low + 2)
        begin = _ROOM * max(k - 2, 0)
        keys[f"key{k}"] = (begin + 0.5, begin + 1.5, *((6.5, 7.5) if k % 2 else (0.5, 1.5)))
    goal: Box = (_ROOM * doors + 2, _ROOM * doors + 3, 3.5, 4.5)
    named = {**openings, **keys, "goal": goal}
    return document(
        comment(f"{doors + 1} rooms in a row, each door with a key of its own."),
        clock(8 + 8 * doors, (0, _ROOM * (doors + 1), 0, _HIGH)),
        "agent r : single_integrator { start (2, 4); control |u| <= 2 }",
        [f"obstacle {name} = {box(bounds)}" for name, bounds in walls.items()],
        [region(name, bounds) for name, bounds in named.items()],
        ["require clear: always forall o in obstacles: r outside o swept",
         *(f"require unlock{k}: (r outside door{k} swept) until r in key{k}"
           for k in range(1, doors + 1)),
         "require arrive: eventually r in goal"],
        "minimize effort",
    )  # fmt: skip
