"""Damage to one token of a text, as all our generators of wrong missions do it."""

from __future__ import annotations

import random
from collections.abc import Sequence


def change_one(rng: random.Random, made: list[str], others: Sequence[str]) -> None:
    """Change one token of `made` (not empty) in place.

    It is overwritten by another, exchanged with it, replaced from `others`, preceded by a copy of
    another, or left out.
    """
    at, second = rng.randrange(len(made)), rng.randrange(len(made))
    match rng.randrange(5):
        case 0:
            made[at] = made[second]
        case 1:
            made[at], made[second] = made[second], made[at]
        case 2:
            made[at] = rng.choice(others)
        case 3:
            made.insert(at, made[second])
        case _:
            del made[at]
