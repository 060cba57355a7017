"""Sizes of a compiled mission by requirement and by pass, and its LP relaxation bound."""

from __future__ import annotations

from dataclasses import asdict, replace
from typing import Any

import numpy as np

from stlc.backends import get
from stlc.backends.base import SolveOptions, Status
from stlc.milp.compile import Compiled
from stlc.milp.model import Model


def lp_bound(model: Model) -> float | None:
    """Optimum of the LP relaxation, or None when HiGHS finds none."""
    relaxed = replace(model, integrality=np.zeros(model.columns, np.uint8))
    solution = get("highs").solve(relaxed, SolveOptions())
    return solution.objective if solution.status is Status.OPTIMAL else None


def statistics(compiled: Compiled) -> dict[str, Any]:
    """Plain JSON values."""
    m = compiled.model
    keys = ("columns", "integers", "rows", "nonzeros")
    return {
        "columns": m.columns,
        "binaries": m.binaries,
        "rows": m.rows,
        "nonzeros": m.nonzeros,
        "lp_bound": compiled.mission.sense.own(lp_bound(m)),
        "seconds": compiled.stats.seconds,
        "by_origin": {
            label: dict(zip(keys, sizes, strict=True))
            for label, sizes in compiled.stats.by_origin.items()
        },
        "passes": [asdict(p) for p in compiled.stats.passes],
        "notes": list(compiled.stats.notes),
    }


def statistics_text(stats: dict[str, Any]) -> str:
    """The same for a person."""
    header = f"{'':36} {'columns':>9} {'integers':>9} {'rows':>9} {'nonzeros':>9}"
    lines = [header]
    for label, s in stats["by_origin"].items():
        cells = (s["columns"], s["integers"], s["rows"], s["nonzeros"])
        lines.append(f"{label[:36]:36} " + " ".join(f"{v:9d}" for v in cells))
    total = (stats["columns"], stats["binaries"], stats["rows"], stats["nonzeros"])
    lines.append(f"{'total':36} " + " ".join(f"{v:9d}" for v in total))
    bound = "none" if stats["lp_bound"] is None else f"{stats['lp_bound']:.6g}"
    lines.append(f"LP relaxation bound {bound}; compiled in {stats['seconds']:.2f} s")
    for entry in stats["passes"]:
        lines.append("  " + ", ".join(f"{k} {_short(v)}" for k, v in entry.items()))
    return "\n".join(lines)


def _short(value: object) -> str:
    return format(value, ".4g") if isinstance(value, float) else str(value)
