"""Inputs without the lines that don't matter for their fault."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from typing import Protocol

from fuzz.faults import Fault
from fuzz.inputs import Input

TRIES = 60  # runs spent on one input; what takes seconds gets fewer
SECONDS = 40.0


class Examines(Protocol):
    """What runs the commands."""

    def examine(self, given: Input) -> Found: ...


class Found(Protocol):
    """What it finds."""

    faults: list[Fault]
    seconds: float


def shortened(given: Input, fault: Fault, examiner: Examines) -> Input:
    """Lines are left out, halves first, while the fault stays the same one."""
    tries, spent = 0, 0.0
    size = max(1, given.text.count("\n") // 2)
    while size >= 1:
        for text in _without(given.text, size):
            if tries >= TRIES or spent > SECONDS:
                return given
            tries += 1
            found = examiner.examine(replace(given, text=text))
            spent += found.seconds
            if any(f.signature == fault.signature for f in found.faults):
                given = replace(given, text=text)
                break
        else:
            size //= 2
    return given


def _without(text: str, size: int) -> Iterator[str]:
    lines = text.split("\n")
    for at in range(0, len(lines), size):
        yield "\n".join(lines[:at] + lines[at + size :])
