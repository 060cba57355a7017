"""What the verifier found of one requirement, and whether the plan presses against it."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

from stlc.source import Span


@dataclass(frozen=True, slots=True)
class RequirementReport:
    """One requirement at step 0; a robustness that can't be judged is None.

    robustness  on the samples, channels on their cell model
    true        on the samples, channels at the true positions (None without a channel model)
    swept       with every `swept` condition judged in continuous time (None without one)
    critical    (step, unit) of the predicate that decides `robustness`
    decides     place of that predicate, and `says` what it says, in the file's words
    corners     where samples lie on another side of a place by its corners in the file than the
                formula says: with them on that side (None where none does)
    """

    name: str
    margin: float
    robustness: float | None
    true: float | None = None
    swept: float | None = None
    critical: tuple[int, str] | None = None
    span: Span | None = None
    corners: float | None = None
    decides: Span | None = None
    says: str = ""

    @property
    def satisfied(self) -> bool:
        """Robustness, in continuous time where it is asked, reaches the margin less 1e-6."""
        value = self.robustness if self.swept is None else self.swept
        if self.corners is not None and not self.corners >= self.margin - 1e-6:
            return False
        return value is not None and value >= self.margin - 1e-6


TIGHT = 1e-4
"""Slack, in the unit of the predicate, up to which a requirement counts as tight: plans that a
solver presses against a condition are within its tolerances of 1e-6, judged at 1e-6."""


def slack_of(r: RequirementReport) -> float | None:
    """Robustness less margin, the least of samples and continuous time; None: not judged.

    A motion that rounds a corner within a step holds in continuous time alone, which counts then.
    """
    values = [v for v in (r.robustness, r.swept) if v is not None]
    if r.swept is not None and by_motion(r):
        return r.swept - r.margin
    return min(values) - r.margin if values else None


def by_motion(r: RequirementReport) -> bool:
    """Whether a requirement holds by the motion itself, though not by the predicates at samples
    that are sufficient for it."""
    return r.satisfied and r.robustness is not None and r.robustness < r.margin - 1e-6


def is_tight(r: RequirementReport) -> bool:
    """Whether the plan presses against a requirement (or breaks it)."""
    slack = None if r.robustness is None else r.robustness - r.margin
    return slack is not None and slack <= TIGHT


def tight_words(requirements: Iterable[RequirementReport]) -> str:
    """`tight: reach (r1 in goal at step 8), ..`; nothing where none is."""
    found = [r for r in requirements if is_tight(r)]
    words = [
        f"{r.name} ({r.says} at step {r.critical[0]})" if r.critical and r.says else r.name
        for r in found
    ]
    return f"tight: {', '.join(words)}" if words else ""
