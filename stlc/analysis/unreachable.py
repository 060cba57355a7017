"""A requirement that no run within the ranges can meet."""

from __future__ import annotations

from typing import NoReturn

from stlc.errors import InfeasibleError
from stlc.ir.requirement import Requirement


class Unreachable(InfeasibleError):
    """`requirement` is out of reach; `why` says what of it (`stlc.solve.blame` finds out)."""

    def __init__(self, requirement: Requirement, why: str = "no run can reach its margin") -> None:
        self.requirement = requirement
        super().__init__(f"requirement '{requirement.name}' cannot hold: {why}")


def refuse(requirement: Requirement) -> NoReturn:
    """Raise it bare: passes know that a requirement fails, not what is to blame."""
    raise Unreachable(requirement)
