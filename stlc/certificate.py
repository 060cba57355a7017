"""What certification and verification found of a plan, as the plan keeps it."""

from __future__ import annotations

from dataclasses import asdict, dataclass, replace
from typing import Any

from stlc.violation import Violations


@dataclass(frozen=True, slots=True)
class Claim:
    """What the solver said, its objective in the mission's sense."""

    status: str
    objective: float | None
    solver: str
    solver_version: str


@dataclass(frozen=True, slots=True)
class Checked:
    """A point held against the model: figures in the mission's sense, `gap` and `tolerance`
    relative and absolute; warnings quote the model, which minimises.

    `before` is the point as the solver returned it, `after` as it is kept, `polished` whether its
    continuous part was solved again.
    """

    status: str
    objective: float | None
    bound: float | None
    gap: float | None
    tolerance: float
    claim: Claim
    before: Violations | None = None
    after: Violations | None = None
    polished: bool = False
    warnings: tuple[str, ...] = ()

    def as_dict(self) -> dict[str, Any]:
        """Plain JSON values."""
        return {
            "status": self.status,
            "objective": self.objective,
            "bound": self.bound,
            "gap": self.gap,
            "tolerance": self.tolerance,
            "claim": asdict(self.claim),
            "violations_before": None if self.before is None else asdict(self.before),
            "violations_after": None if self.after is None else asdict(self.after),
            "continuous_part_solved_again": self.polished,
            "warnings": list(self.warnings),
        }


@dataclass(frozen=True, slots=True)
class Certificate:
    """`checked`: against the model, where there was one; `verified`: against the mission, None
    before anybody looked; `notes` of the verifier."""

    checked: Checked | None = None
    verified: bool | None = None
    notes: tuple[str, ...] = ()

    @property
    def warnings(self) -> tuple[str, ...]:
        """What certification warns of."""
        return () if self.checked is None else self.checked.warnings

    def judged(self, verified: bool, notes: tuple[str, ...]) -> Certificate:
        """With the verifier's verdict."""
        return replace(self, verified=verified, notes=notes)

    def as_dict(self) -> dict[str, Any]:
        """Plain JSON values, one object."""
        found: dict[str, Any] = {} if self.checked is None else self.checked.as_dict()
        if self.verified is not None:
            found |= {"verified": self.verified, "notes": list(self.notes)}
        return found
