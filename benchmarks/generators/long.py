"""Long missions of one agent: rounds to be made for ever."""

from __future__ import annotations

from generators.text import Box, clock, comment, document, region


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
