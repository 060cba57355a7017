"""One size grows, everything else stays."""

from __future__ import annotations

import numpy as np

from generators.text import Box, carts, clock, comment, document, region

_FIELD: Box = (0, 10, 0, 10)


def patrol(steps: int, targets: int, seed: int) -> str:
    """One agent visits `targets` small boxes and stays out of two obstacles, with least effort."""
    draw = np.random.RandomState(seed)
    corners = [(float(draw.uniform(1, 8)), float(draw.uniform(1, 2.5))) for _ in range(targets)]
    boxes: list[Box] = [
        (round(x, 3), round(x + 1, 3), round(y, 3), round(y + 1, 3)) for x, y in corners
    ]
    places = [region(f"goal{k}", bounds) for k, bounds in enumerate(boxes, 1)]
    places += ["obstacle low = box [3, 4] x [4, 6]", "obstacle high = box [6, 7] x [4, 6]"]
    wanted = [f"require visit{k}: eventually r1 in goal{k}" for k in range(1, targets + 1)]
    wanted.append("require clear: always (r1 outside low and r1 outside high)")
    return document(
        comment(f"One agent visits {targets} places in {steps} steps."),
        clock(steps, _FIELD),
        carts([(5, 3)]),
        places,
        wanted,
        "minimize effort",
    )
