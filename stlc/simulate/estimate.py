"""How often requirements hold, with exact confidence intervals, and how robustly."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

LEVELS = (0.05, 0.25, 0.5, 0.75, 0.95)
"""Quantiles of the robustness that reports give."""

_BARS = 12
_WIDTH = 40


@dataclass(frozen=True, slots=True, eq=False)
class Estimate:
    """What the draws say of one requirement or preference.

    `hold` of `draws` draws satisfy it; `low` and `high` bound its probability at the level of
    confidence asked for; `certain` where nothing in it is random, so that all draws are alike.
    `robustness` (draws,), in the unit `unit`; None where the requirement can't be judged, and for
    preferences: of those `violation` is the mean violation, in their unit, None if not judged.
    """

    name: str
    margin: float
    hold: int
    draws: int
    low: float
    high: float
    certain: bool
    robustness: Array | None = None
    unit: str = ""
    violation: float | None = None

    @property
    def probability(self) -> float:
        """Share of the draws that satisfy it."""
        return self.hold / self.draws

    def as_dict(self) -> dict[str, Any]:
        """Plain values; quantiles by level, and a histogram of the robustness."""
        found: dict[str, Any] = {
            "name": self.name, "margin": self.margin, "probability": self.probability,
            "low": self.low, "high": self.high, "hold": self.hold, "certain": self.certain,
        }  # fmt: skip
        if self.violation is not None:
            found |= {"violation": self.violation, "unit": self.unit}
        if self.robustness is not None:
            values = np.quantile(self.robustness, LEVELS, method="lower")
            found |= {"unit": self.unit, "mean": float(self.robustness.mean())}
            found["quantiles"] = {f"{q:g}": float(v) for q, v in zip(LEVELS, values, strict=True)}
            counts, edges = histogram(self.robustness)
            found["histogram"] = {"counts": counts.tolist(), "edges": edges.tolist()}
        return found


@dataclass(frozen=True, slots=True, eq=False)
class Simulation:
    """All requirements of a mission, and `joint`: every one of them in the same draw. Of
    `preferences`, how often each is kept."""

    mission: str
    draws: int
    seed: int
    confidence: float
    requirements: tuple[Estimate, ...]
    joint: Estimate
    notes: tuple[str, ...]
    preferences: tuple[Estimate, ...] = ()

    def as_dict(self) -> dict[str, Any]:
        """Plain JSON values."""
        return {
            "mission": self.mission, "draws": self.draws, "seed": self.seed,
            "confidence": self.confidence,
            "requirements": [e.as_dict() for e in self.requirements],
            "joint": self.joint.as_dict(), "notes": list(self.notes),
            "preferences": [e.as_dict() for e in self.preferences],
        }  # fmt: skip

    def text(self) -> str:
        """The report for a person."""
        rows = [*self.requirements, self.joint]
        width = max(len(e.name) for e in (*rows, *self.preferences))
        lines = [
            f"{self.mission}: {self.draws} draws, seed {self.seed}; "
            f"{100 * self.confidence:g} % confidence intervals (Clopper and Pearson)",
            *(_line(e, width) for e in rows),
            *(f"{_line(e, width)}{_lack(e)}" for e in self.preferences),
        ]
        for e in self.requirements:
            lines += _bars(e)
        return "\n".join([*lines, *(f"  note: {note}" for note in self.notes)])


def interval(hold: int, draws: int, confidence: float) -> tuple[float, float]:
    """Clopper and Pearson's interval of a probability (Biometrika 26, 1934): it covers the true
    one with at least `confidence`, for every number of draws."""
    from scipy.special import betaincinv

    tail = (1.0 - confidence) / 2.0
    low = float(betaincinv(hold, draws - hold + 1, tail)) if hold else 0.0
    high = float(betaincinv(hold + 1, draws - hold, 1.0 - tail)) if hold < draws else 1.0
    return low, high


def histogram(values: Array) -> tuple[NDArray[np.intp], Array]:
    """Counts and edges; infinite values count with the outermost bars."""
    finite = values[np.isfinite(values)]
    low, high = (float(finite.min()), float(finite.max())) if len(finite) else (0.0, 0.0)
    if high - low <= 1e-9 * max(1.0, abs(low)):
        low, high = low - 0.5, high + 0.5
    edges = np.linspace(low, high, _BARS + 1)
    counts, _ = np.histogram(np.clip(values, low, high), edges)
    return np.asarray(counts, dtype=np.intp), np.asarray(edges, dtype=np.float64)


def _line(e: Estimate, width: int) -> str:
    head = f"  {e.name:<{width}}  {e.probability:8.4%}"
    if e.certain:
        return f"{head}  whatever chance does"
    return f"{head}  in [{e.low:.4%}, {e.high:.4%}]"


def _lack(e: Estimate) -> str:
    """What is said of a preference beside how often it is kept."""
    if not e.violation:
        return "  preferred"
    unit = f" {e.unit}" if e.unit else ""
    return f"  preferred; violated by {e.violation:.4g}{unit} on average"


def _bars(e: Estimate) -> list[str]:
    """The histogram of a requirement's robustness, where chance has a say in it."""
    if e.certain or e.robustness is None:
        return []
    counts, edges = histogram(e.robustness)
    unit = f" [{e.unit}]" if e.unit else ""
    lines = [f"  robustness of {e.name}{unit}, mean {float(e.robustness.mean()):.4g}"]
    for k, count in enumerate(counts.tolist()):
        bar = "#" * round(_WIDTH * count / int(counts.max()))
        lines.append(f"    {edges[k]:9.4g} .. {edges[k + 1]:9.4g} {count:8}  {bar}".rstrip())
    return lines
