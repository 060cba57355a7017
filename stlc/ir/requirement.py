"""A named formula that a run has to satisfy."""

from __future__ import annotations

from dataclasses import dataclass

from stlc.ir.nodes import Node
from stlc.source import Span


@dataclass(frozen=True, slots=True)
class Requirement:
    """One `require`: satisfied when the robustness of `formula` at step 0 is >= `margin`."""

    name: str
    formula: Node
    margin: float = 0.0
    span: Span | None = None
