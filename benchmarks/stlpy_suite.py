"""Our default against the better of stlpy's two encodings, on stlpy's own scenarios.

    python benchmarks/stlpy_suite.py --scenarios DIR --peers DIR [--repeats 3] [--limit 120]

Every model is solved in this one run, HiGHS with one thread, in alternating order; the figure is
the median of the repeats. Ours counts everything after compiling: the search for a start and the
solver. A peer that reaches the limit counts with the limit.
"""

from __future__ import annotations

import argparse
import lzma
import math
import statistics
import tempfile
import time
from dataclasses import dataclass, field
from pathlib import Path

import highspy
import scenarios

from stlc.backends import get
from stlc.backends.base import SolveOptions
from stlc.milp.compile import Compiled, compile_mission
from stlc.milp.statistics import lp_bound
from stlc.solve.strategy import run_strategy


@dataclass(slots=True)
class Contender:
    """One model of one scenario and its times [s] (wall, processor)."""

    name: str
    model: Compiled | Path
    wall: list[float] = field(default_factory=list)
    processor: list[float] = field(default_factory=list)
    objective: float = math.nan

    def run(self, limit: float) -> None:
        """Solve once more."""
        wall, processor = time.perf_counter(), time.process_time()
        objective = self._solve(limit)
        self.wall.append(time.perf_counter() - wall)
        self.processor.append(time.process_time() - processor)
        self.objective = math.nan if objective is None else objective

    def _solve(self, limit: float) -> float | None:
        if isinstance(self.model, Compiled):
            options = SolveOptions(time_limit=limit, threads=1)
            return run_strategy("auto", self.model, get("highs"), options).objective
        h = highspy.Highs()
        for key, value in (("log_to_console", False), ("threads", 1), ("time_limit", limit)):
            h.setOptionValue(key, value)
        h.readModel(str(self.model))
        h.run()
        return float(h.getInfo().objective_function_value)


def peers_of(name: str, folder: Path, scratch: Path) -> list[Contender]:
    """stlpy's models of a scenario, unpacked."""
    found = []
    for packed in sorted(folder.glob(f"{name}__*.mps.xz")):
        path = scratch / packed.stem
        path.write_bytes(lzma.decompress(packed.read_bytes()))
        found.append(Contender(packed.name.split("__")[1].split(".")[0], path))
    return found


def measure(path: Path, peers: Path, scratch: Path, repeats: int, limit: float) -> float:
    """Solve one scenario's models in turns; prints a block and returns the speed-up."""
    began = time.perf_counter()
    compiled = compile_mission(scenarios.load(path))
    built = time.perf_counter() - began
    ours = Contender("stlc", compiled)
    field_ = [ours, *peers_of(path.stem, peers, scratch)]
    for k in range(repeats):
        for contender in field_ if k % 2 == 0 else field_[::-1]:
            contender.run(limit)
    m = compiled.model
    print(f"{path.stem}: {m.columns} columns, {m.binaries} binaries, {m.rows} rows,"
          f" LP bound {lp_bound(m):.4f}, compiled in {built:.2f} s")  # fmt: skip
    for c in field_:
        wall, processor = statistics.median(c.wall), statistics.median(c.processor)
        print(
            f"    {c.name:6} {wall:8.3f} s wall {processor:8.3f} s processor"
            f"  objective {c.objective:.6f}"
        )
    best = min(statistics.median(c.processor) for c in field_[1:])
    return best / statistics.median(ours.processor)


def main() -> None:
    """Measure every scenario and print the geometric mean."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--scenarios", type=Path, required=True)
    parser.add_argument("--peers", type=Path, required=True)
    parser.add_argument("--repeats", type=int, default=3)
    parser.add_argument("--limit", type=float, default=120.0)
    args = parser.parse_args()
    gains = []
    with tempfile.TemporaryDirectory() as scratch:
        for path in sorted(args.scenarios.glob("*.json")):
            if list(args.peers.glob(f"{path.stem}__*")):
                gains.append(measure(path, args.peers, Path(scratch), args.repeats, args.limit))
                print(f"    {gains[-1]:.1f} times faster than the better peer", flush=True)
    mean = math.exp(statistics.fmean(math.log(g) for g in gains))
    print(f"geometric mean {mean:.2f}, least {min(gains):.2f}")


if __name__ == "__main__":
    main()
