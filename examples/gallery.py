"""Missions of this folder solved, drawn and shown: `python examples/gallery.py OUT [NAME ..]`.

Leaves NAME.json, NAME.png and NAME.html (the report) of each mission in OUT, and exits with 1
unless every plan was verified. A plan that is there already, in OUT or in `docs/gallery`, is kept
while it satisfies its mission: only what has changed is solved again.
"""

from __future__ import annotations

import shutil
import sys
from pathlib import Path

import stlc
from stlc.errors import StlcError
from stlc.plot import plot_plan

HERE = Path(__file__).resolve().parent
KEPT = HERE.parent / "docs" / "gallery"
LIMIT = 60.0  # s; most take seconds on one core
ELSEWHERE = {"paper_two_agents"}  # `make demo` has it; its table alone takes ten seconds


def shown(file: Path, out: Path) -> bool:
    """One mission; whether its plan satisfies it."""
    there, kept = stlc.load(file), out / f"{file.stem}.json"
    if not kept.exists() and (KEPT / kept.name).exists():
        shutil.copy(KEPT / kept.name, kept)
    plan = _read(there, kept) or there.solve(LIMIT, threads=1)
    plan.write(kept)
    plot_plan(plan.mission, plan.data, out / f"{file.stem}.png")
    plan.page(out / f"{file.stem}.html")
    print(f"{file.stem}: {plan!r}")
    return bool(plan.ok)


def _read(there: stlc.Mission, path: Path) -> stlc.Plan | None:
    """The plan of an earlier run, if it is one of the mission as it stands."""
    try:
        plan = there.read_plan(path)
    except StlcError:
        return None
    return plan if plan.ok else None


def main() -> int:
    """Those that are named, else all of them."""
    out, names = Path(sys.argv[1]), sys.argv[2:]
    out.mkdir(parents=True, exist_ok=True)
    names = names or sorted({p.stem for p in HERE.glob("*.stl")} - ELSEWHERE)
    return 0 if all([shown(HERE / f"{name}.stl", out) for name in names]) else 1


if __name__ == "__main__":
    raise SystemExit(main())
