"""Requirements that no run within the ranges can meet, and agents left without any state."""

from __future__ import annotations

from typing import NoReturn

from stlc.errors import InfeasibleError
from stlc.ir.requirement import Requirement


class Unreachable(InfeasibleError):
    """`requirement` is out of reach; `why` says what of it (`stlc.solve.blame` finds out)."""

    def __init__(self, requirement: Requirement, why: str = "no run can reach its margin") -> None:
        self.requirement = requirement
        super().__init__(f"requirement '{requirement.name}' cannot hold: {why}")


class NoState(InfeasibleError):
    """The intervals of an agent leave it no state at some step."""

    def __init__(self, agent: str, text: str) -> None:
        self.agent = agent
        super().__init__(text)


def refuse(requirement: Requirement) -> NoReturn:
    """Raise it bare: passes know that a requirement fails, not what is to blame."""
    raise Unreachable(requirement)
