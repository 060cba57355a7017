"""The paper's headline and its families: `python benchmarks/headline.py [--limit 60] [--only ...]`.

Runs `two_agents_t8`, ten random missions of its size and the families around it through the normal
driver, one after the other, and prints for each the time to the first verified plan, the gap at
the time limit (or at 60 s if that is earlier), the time to the proof (wall and CPU seconds), and
at the end median and worst of the ten. `--literal S` gives the paper's encoding S seconds each
with M = 99999 and with the tightest M, and times it from text to matrices.
"""

from __future__ import annotations

import argparse
import statistics
import tempfile
import time
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path

from link_family import Family, write

from stlc import Mission
from stlc.errors import StlcError
from stlc.milp.encodings import compile_options
from stlc.solve.driver import SolveSettings, solve_mission
from stlc.solve.events import Event, ProgressEvent, SolutionEvent

HEADLINE = Path(__file__).parent / "missions" / "two_agents_t8.stl"
FAMILIES = {
    "steps12": Family(steps=12),
    "steps16": Family(steps=16),
    "cells20": Family(cells=20),
    "agents3": Family(agents=3),
    "agents4": Family(agents=4),
    "team4": Family(agents=4, steps=12, cells=20),
    "team6": Family(agents=6, steps=12, cells=20),
}
_MARK = 60.0  # s at which the gap is read


@dataclass(slots=True)
class Record:
    """One run. Seconds since the command began with the file; None where it did not happen."""

    name: str
    first: float | None = None
    gap: float | None = None
    wall: float = 0.0
    cpu: float = 0.0
    objective: float | None = None
    bound: float | None = None
    status: str = ""
    offset: float = 0.0
    began: float = field(default_factory=time.perf_counter)

    def hear(self, event: Event) -> None:
        """Note the first verified plan and the last gap before the mark."""
        seconds = time.perf_counter() - self.began
        if isinstance(event, SolutionEvent) and self.first is None:
            self.first = seconds
        if isinstance(event, ProgressEvent) and seconds <= _MARK and event.gap is not None:
            self.gap = event.gap

    def line(self) -> str:
        """One row of the table."""
        cells = (self.first, self.gap, self.wall, self.cpu, self.objective, self.bound)
        shown = ["-" if c is None else f"{c:.4g}" for c in cells]
        return f"{self.name:24s} {self.status:10s} " + " ".join(f"{c:>9s}" for c in shown)


HEADER = f"{'mission':24s} {'status':10s} " + " ".join(
    f"{c:>9s}" for c in ("first s", "gap@60", "wall s", "cpu s", "objective", "bound")
)


def run(path: Path, limit: float, folder: Path, encoding: str = "auto") -> Record:
    """Solve a mission file; nothing is left out of the clock but the imports."""
    record = Record(path.stem if encoding == "auto" else f"{path.stem} {encoding}")
    cpu = time.process_time()
    settings = SolveSettings(
        compile=compile_options(encoding), time_limit=limit, save_to=folder / "plan.json"
    )
    try:
        outcome = solve_mission(Mission.from_file(path), settings, record.hear)
        info = outcome.plan.solve
        record.objective, record.bound, record.status = info.objective, info.bound, info.status
        if time.perf_counter() - record.began <= _MARK:
            record.gap = info.gap
    except StlcError as error:
        record.status = type(error).__name__.removesuffix("Error").lower()
    record.wall = time.perf_counter() - record.began
    record.cpu = time.process_time() - cpu
    print(record.line(), flush=True)
    return record


def ten(folder: Path, limit: float) -> None:
    """Ten random missions of the headline's size, with median and worst."""
    records = [run(write(folder, seed, Family()), limit, folder) for seed in range(10)]
    for what in ("wall", "cpu"):
        values = [getattr(r, what) for r in records]
        print(f"{what}: median {statistics.median(values):.4g} s, worst {max(values):.4g} s")
    print(f"proven: {sum(r.status == 'optimal' for r in records)} of {len(records)}", flush=True)


def family(name: str, folder: Path, limit: float, seeds: int) -> Iterator[Record]:
    """The first seeds of a family."""
    for seed in range(seeds):
        yield run(write(folder, seed, FAMILIES[name]), limit, folder)


def literal(folder: Path, limit: float) -> None:
    """The paper's encoding with M = 99999 and with the tightest M."""
    for encoding in ("literal", "literal-tight"):
        mission = Mission.from_file(HEADLINE)
        began = time.perf_counter()
        mission = Mission.from_file(HEADLINE)
        model = mission.compile(compile_options(encoding)).model
        seconds = time.perf_counter() - began
        print(
            f"{encoding}: {model.columns} columns, {model.rows} rows, {model.binaries} binaries "
            f"(paper: 73327 columns, 291808 rows); text to matrices {seconds:.3f} s"
        )
        run(HEADLINE, limit, folder, encoding)


def main() -> None:
    """Run what is asked for."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--limit", type=float, default=120.0, help="seconds for each solve")
    parser.add_argument("--seeds", type=int, default=2, help="missions of each family")
    parser.add_argument("--literal", type=float, default=0.0, help="seconds for the paper's")
    parser.add_argument("--out", type=Path, help="folder for missions and plans")
    names = ["headline", "ten", *FAMILIES]
    parser.add_argument("--only", nargs="*", choices=names, default=names)
    asked = parser.parse_args()
    with tempfile.TemporaryDirectory() as scratch:
        folder = asked.out or Path(scratch)
        folder.mkdir(parents=True, exist_ok=True)
        print(HEADER)
        if "headline" in asked.only:
            run(HEADLINE, asked.limit, folder)
        if "ten" in asked.only:
            ten(folder, asked.limit)
        for name in FAMILIES:
            if name in asked.only:
                list(family(name, folder, asked.limit, asked.seeds))
        if asked.literal > 0:
            literal(folder, asked.literal)


if __name__ == "__main__":
    main()
