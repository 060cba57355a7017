"""Which formula encoding each disjunction gets under `auto`, and why.

    at most 4 alternatives           onehot: fewer binaries cannot help
    alternatives at different steps  unary: when something happens is ordered, and branching on
                                     "by step t or later" keeps both sides large
    alternatives at one step         onehot: their order means nothing, and the faces of boxes that
                                     alternatives share give the hull without copies

Measured with HiGHS alone (no start search) on the scenarios of stlpy, this took 0.86 of the time
of `onehot` throughout (geometric mean); `unary` everywhere more than doubles the narrow passage,
`log` is mostly 2 to 5 times slower, `hull` pays for its copies on the smallest only, and `bigm`
is as good where few faces are shared and up to 2 times slower elsewhere.
"""

from __future__ import annotations

from collections.abc import Sequence

from stlc.ir.nodes import Linear
from stlc.milp.formulas.selectors import FEW, ONE_HOT, SELECTORS, FormulaEncoding


def choose(predicates: Sequence[Sequence[Linear]]) -> tuple[FormulaEncoding, str]:
    """The encoding of an exclusive choice among alternatives, and the reason in words."""
    if len(predicates) <= FEW:
        return ONE_HOT, f"at most {FEW} alternatives"
    firsts = {min((s.shift for p in own for s, _ in p.terms), default=-1) for own in predicates}
    if len(firsts) > 1:
        return SELECTORS["unary"], "alternatives ordered in time"
    return ONE_HOT, "alternatives of one step share faces"
