"""Which formula encoding each disjunction gets under `auto`, and why."""

from __future__ import annotations

from collections.abc import Sequence

from stlc.ir.nodes import Linear
from stlc.milp.selectors import FEW, ONE_HOT, FormulaEncoding


def choose(predicates: Sequence[Sequence[Linear]]) -> tuple[FormulaEncoding, str]:
    """The encoding of an exclusive choice among alternatives, and the reason in words."""
    if len(predicates) <= FEW:
        return ONE_HOT, f"at most {FEW} alternatives"
    return ONE_HOT, "shared faces are the hull already"
