"""Why a requirement cannot hold: the error that interval analysis raises."""

from __future__ import annotations

from stlc.errors import InfeasibleError
from stlc.mission import Mission


class Unreachable(InfeasibleError):
    """A requirement is out of reach whatever the others say."""

    def __init__(self, message: str, requirement: str) -> None:
        self.requirement = requirement
        super().__init__(message)


def unreachable(mission: Mission, name: str) -> Unreachable:
    """The error for the requirement of that name."""
    return Unreachable(f"requirement '{name}' cannot hold", name)
