"""Two Python environments over the same problems, pair by pair, by processor time.

    python benchmarks/pair.py PYTHON_A PYTHON_B [--only A,B] [--output FILE]

Makes `results/highs_versions.txt`: the environments there differ in the version of highspy. Both
runs of a pair are made at the same time, so that other load on the machine meets them alike, and
what is compared is the processor time of the solver with the searches around it. Runs go to
`out/pair/`, and what is there is not made again.
"""

from __future__ import annotations

import argparse
import os
import subprocess
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from math import exp, log
from pathlib import Path

from stlc.bench.record import Record
from stlc.bench.store import Store
from stlc.files import write_atomic

CHECKOUT = Path(__file__).resolve().parent.parent
ENTRY = "import sys; from stlc.cli import main; sys.argv[0] = 'stlc'; main()"
LIMIT = 30  # s
LEAST = 0.1  # s: below, a ratio says nothing
PLAN = {  # suite and options of `stlc bench`, to the problems, each a substring of its name
    "stlpy --strategies auto,milp --repeat 3": (
        "reach_avoid_T20,either_or_T20_d5,narrow_passage_T25,stepping_stones_15_T15_s1",
        "door_puzzle_N1_T20,door_puzzle_N2_T25,multitarget_o1_g5_t2_T25_s0",
    ),
    "headline": (
        "two_agents_t8", *(f"links_a2_t8_c10_s{seed}" for seed in range(8)), "links_a2_t8_c15",
        "rssi_a2", "ber_a2", "prr_a2", "links_a3_t8_c10_s0",
    ),
    "teams": ("team_2", "team_3", "team_4"),  # with radio_team_N and connected_team_N
    "scaling": ("horizon_25,horizon_50", "targets_1,targets_2,targets_4", "agents_1,agents_2"),
}  # fmt: skip


@dataclass(frozen=True, slots=True)
class Pair:
    """One problem, configuration and seed, in both environments."""

    a: Record
    b: Record

    @property
    def ratio(self) -> float | None:
        """Processor time of B by that of A; None unless both have a proof."""
        if not (self.a.solved and self.b.solved):
            return None
        return max(self.b.cpu_seconds or 0.0, LEAST) / max(self.a.cpu_seconds or 0.0, LEAST)


def run(pythons: Sequence[Path], options: str, only: str) -> None:
    """The same problems in both environments at the same time."""
    env = os.environ | {"PYTHONPATH": str(CHECKOUT), "OPENBLAS_NUM_THREADS": "1"}
    words = ["bench", *options.split(), "--only", only, "--time-limit", str(LIMIT)]
    started = [
        subprocess.Popen(
            [python, "-c", ENTRY, *words, "--store", str(store(side))],
            cwd=CHECKOUT, env=env, stdout=subprocess.DEVNULL,
        )
        for python, side in zip(pythons, "ab", strict=True)
    ]  # fmt: skip
    for process in started:
        if process.wait() != 0:
            raise SystemExit(f"{process.args} ended with status {process.returncode}")


def store(side: str) -> Path:
    """Where the runs of an environment are kept."""
    return CHECKOUT / "out" / "pair" / f"{side}.sqlite"


def pairs() -> list[Pair]:
    """Of the runs that both stores have, in the order of A's."""
    a, b = (Store(store(side)).records() for side in "ab")
    of_b = {_name(record): record for record in b}
    return [Pair(one, of_b[_name(one)]) for one in a if _name(one) in of_b]


def _name(record: Record) -> tuple[str, str, str, int]:
    return record.suite, record.problem, record.strategy, record.repeat


def report(found: Sequence[Pair], command: str) -> str:
    """The table, and for each suite and strategy the means."""
    first = found[0]
    lines = [
        command, f"A: {first.a.versions}", f"B: {first.b.versions}",
        f"{first.a.processor}; limit {LIMIT} s of the clock, gap {first.a.gap_limit}, 1 thread",
        "processor time of the solver [s] (* no proof: the gap reached), nodes, B / A", "",
    ]  # fmt: skip
    groups: dict[str, list[Pair]] = {}
    for pair in found:
        groups.setdefault(f"{pair.a.suite}, {pair.a.strategy}", []).append(pair)
    for title, group in groups.items():
        lines += [title, *map(_line, group), *_means(group), ""]
    return "\n".join([*lines, "all", *_means(found), ""])


def _line(pair: Pair) -> str:
    ratio = "" if pair.ratio is None else f"{pair.ratio:8.2f}"
    name = f"{pair.a.problem} {pair.a.repeat}"
    return f"  {name:34}{_side(pair.a)}{_side(pair.b)}{ratio}".rstrip()


def _side(record: Record) -> str:
    time = f"{record.cpu_seconds or 0.0:8.2f}"
    nodes = "-" if record.nodes is None else str(record.nodes)
    gap = "none" if record.gap is None else f"{record.gap:.1%}"
    return f"{time}{'' if record.solved else f'* {gap}':8}{nodes:>8}"


def _means(group: Sequence[Pair]) -> list[str]:
    ratios = [pair.ratio for pair in group if pair.ratio is not None]
    solved = [sum(getattr(pair, side).solved for pair in group) for side in "ab"]
    said = [f"  solved of {len(group)}: A {solved[0]}, B {solved[1]}"]
    if not ratios:
        return said
    mean = exp(sum(map(log, ratios)) / len(ratios))
    total = [sum(getattr(p, s).cpu_seconds for p in group if p.ratio is not None) for s in "ab"]
    faster, slower = sum(r < 0.8 for r in ratios), sum(r > 1.25 for r in ratios)
    return [
        *said,
        f"  both proven, {len(ratios)}: B / A {mean:.2f} (geometric mean), {total[0]:.1f} s against"
        f" {total[1]:.1f} s in all; B is faster by 1.25 and more in {faster}, slower in {slower}",
    ]


def main() -> None:
    """Run the plan, write the table."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("pythons", nargs=2, type=Path, metavar="PYTHON")
    parser.add_argument("--suites", default=",".join(name.split()[0] for name in PLAN))
    parser.add_argument("--output", type=Path)
    asked = parser.parse_args()
    for options, problems in PLAN.items():
        if options.split()[0] in asked.suites.split(","):
            for only in problems:
                run(asked.pythons, options, only)
    names = " ".join(f"PYTHON_{side}" for side in "AB")
    text = report(pairs(), f"python benchmarks/pair.py {names}")
    if asked.output is not None:
        write_atomic(asked.output, text)
    sys.stdout.write(text)


if __name__ == "__main__":
    main()
