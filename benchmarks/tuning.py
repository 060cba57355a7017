"""Halves and doubles each number of `stlc/solve/tuning.py` over missions whose search reads it.

    python benchmarks/tuning.py [--records PAIR,TEAM] [--limit SECONDS] [--output FILE]

Makes `results/tuning.txt`: for each mission the processor seconds, the plan's value and the bound
as the record stands, and for each number varied the same three relative to that. Every run is a
process of its own, one after the other, with one thread, and stops after so many seconds of
processor time, which the searches within it take for the time too: what else the machine does
changes little. Runs go to `out/tuning.ndjson`, and what is there is not made again.
"""

from __future__ import annotations

import argparse
import json
import os
import resource
import subprocess
import sys
from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass, replace
from functools import partial
from pathlib import Path
from types import SimpleNamespace
from typing import Any
from unittest.mock import patch

from stlc.api import load, solve
from stlc.backends.base import Solution, SolveOptions
from stlc.backends.highs import Highs
from stlc.errors import NoPlanError
from stlc.files import write_atomic
from stlc.milp.model import Model
from stlc.record import changed
from stlc.solve import deadline, tuning
from stlc.solve.outcome import SolveSettings
from stlc.solve.routes import motion_bounds

CHECKOUT = Path(__file__).resolve().parent.parent
MISSIONS = CHECKOUT / "benchmarks" / "missions"
KEPT = CHECKOUT / "out" / "tuning.ndjson"
PLAN = {
    "BRIEF": ("teams/team_2", "teams/radio_team_2"),
    "PAIR": ("two_agents_t8", "headline/rssi_a2_t8_c10"),
    "TEAM": ("three_agents_t4", "headline/links_a3_t8_c10_s0"),
    "DIVE": ("stlpy/door_puzzle_N2_T25", "stlpy/multitarget_o3_g4_t2_T30_s1"),
    "LONE": ("teams/team_3", "teams/team_4"),
    "TURNS": ("teams/team_5", "headline/prr_a3_t12_c10"),
    "NEAR": ("teams/team_4", "teams/team_5"),
    "ROUTES": (
        "long/maze_1",
        "long/frugal_door_puzzle_N1_T20",
        "long/rounds_40",
        "published/stlp_rover-1",
    ),
}
"""Record -> missions of benchmarks/missions whose search reads it."""

CLOCK = 20.0  # s of the clock for each of processor time, at most: the machine may be busy
SMALLEST = 0.1  # s of processor time: below, a ratio says nothing
NOISE = 0.1  # of processor time


@dataclass(frozen=True, slots=True)
class Run:
    """One solve: a mission, which number was varied to what ("" for none), and what came of it."""

    mission: str
    limit: float
    number: str
    value: float
    cpu: float
    plan: float | None
    bound: float | None


def run(mission: str, limit: float, number: str, value: float) -> Run:
    """Solve in this process, with the number changed for good. Seconds of all its threads."""
    if number:
        record, _, field = number.partition(".")
        setattr(tuning, record, changed(getattr(tuning, record), **{field: value}))
    loaded, began = load(MISSIONS / f"{mission}.stl"), _cpu()
    plan, bound = None, None
    try:
        settings = SolveSettings(time_limit=limit, threads=1, seed=0)
        late = partial(_late, began + limit)
        info = solve(loaded, settings, should_stop=late).plan.solve
        plan, bound = info.objective, info.bound
    except NoPlanError as error:
        bound = error.bound
    return Run(mission, limit, number, value, _cpu() - began, plan, bound)


def count_processor_time() -> None:
    """Let the searches of this process, and HiGHS, take its processor time for the time."""
    for module in (deadline, motion_bounds):
        patch.object(module, "time", SimpleNamespace(monotonic=_cpu)).start()
    by_clock = Highs.solve

    def by_processor(self: Highs, model: Model, options: SolveOptions) -> Solution:
        """As before, the limit counted anew."""
        if options.time_limit is None:
            return by_clock(self, model, options)
        end, asked = _cpu() + options.time_limit, options.should_stop

        def over() -> bool:
            return _cpu() >= end or (asked is not None and asked())

        longer = replace(options, time_limit=CLOCK * options.time_limit, should_stop=over)
        return by_clock(self, model, longer)

    patch.object(Highs, "solve", by_processor).start()


def _late(when: float) -> bool:
    return _cpu() >= when


def _cpu() -> float:
    used = resource.getrusage(resource.RUSAGE_SELF)
    return used.ru_utime + used.ru_stime


def apart(mission: str, limit: float, number: str, value: float) -> Run:
    """The same in a process of its own; CalledProcessError where that fails."""
    words = [sys.executable, __file__, "--one", json.dumps([mission, limit, number, value])]
    env = os.environ | {"OPENBLAS_NUM_THREADS": "1"}
    done = subprocess.run(words, env=env, stdout=subprocess.PIPE, text=True, check=True)
    return Run(**json.loads(done.stdout.splitlines()[-1]))


def variations(record: str) -> Iterator[tuple[str, float]]:
    """The record as it stands, then each of its numbers halved and doubled."""
    yield "", 0.0
    for field in getattr(tuning, record).record_fields:
        value = getattr(getattr(tuning, record), field)
        if not isinstance(value, int | float):
            continue  # a schedule, such as the efforts of a beam
        for factor in (0.5, 2.0):
            varied = value * factor
            if isinstance(value, int):
                varied = max(1, int(varied))
            if varied != value:
                yield f"{record}.{field}", varied


def measured(records: Sequence[str], limit: float) -> list[Run]:
    """Every run of these records; those in the store are taken from there."""
    kept = _kept()
    found = {}
    for record in records:
        for mission in PLAN[record]:
            for number, value in variations(record):
                key = (mission, limit, number, value)
                if key not in kept:
                    kept[key] = apart(*key)
                    _keep(kept[key])
                found[key] = kept[key]
    return list(found.values())


def _kept() -> dict[tuple[Any, ...], Run]:
    lines = KEPT.read_text().splitlines() if KEPT.exists() else []
    runs = [Run(**json.loads(line)) for line in lines]
    return {(r.mission, r.limit, r.number, r.value): r for r in runs}


def _keep(one: Run) -> None:
    KEPT.parent.mkdir(exist_ok=True)
    with KEPT.open("a") as file:
        file.write(json.dumps(asdict(one)) + "\n")


def report(runs: Sequence[Run], command: str) -> str:
    """A table for each mission."""
    lines = [
        command,
        "processor time / that of the record as it stands; plan and bound less its",
        "",
    ]
    for mission in dict.fromkeys(r.mission for r in runs):
        here = [r for r in runs if r.mission == mission]
        base = here[0]
        lines.append(
            f"{mission}: {base.cpu:.1f} s, plan {_show(base.plan)}, bound {_show(base.bound)}; "
            f"limit {base.limit:g} s"
        )
        lines += [_line(one, base) for one in here[1:]] + [""]
    return "\n".join(lines)


def _line(one: Run, base: Run) -> str:
    ratio = max(one.cpu, SMALLEST) / max(base.cpu, SMALLEST)
    said = f"  {one.number:22} = {one.value:<9g} time x {ratio:4.2f}"
    plan, bound = _moved(one.plan, base.plan), _moved(one.bound, base.bound)
    if abs(ratio - 1) <= NOISE and not plan and not bound:
        return f"{said}  flat"
    return f"{said}{plan and f'  plan {plan}'}{bound and f'  bound {bound}'}"


def _moved(value: float | None, base: float | None) -> str:
    """The difference, or nothing where it is within the gap that a proof leaves."""
    if value is None or base is None:
        return "" if value is base else f"{_show(value)} against {_show(base)}"
    return "" if abs(value - base) <= 2e-4 * max(1.0, abs(base)) else f"{value - base:+.4g}"


def _show(value: float | None) -> str:
    return "none" if value is None else f"{value:.5g}"


def main() -> None:
    """Run what is missing, write the tables; with --one, that run and its line of JSON."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--records", default=",".join(PLAN))
    parser.add_argument("--limit", type=float, default=30.0, help="of processor time [s]")
    parser.add_argument("--output", type=Path)
    parser.add_argument("--one", type=json.loads, help=argparse.SUPPRESS)
    asked = parser.parse_args()
    if asked.one:
        count_processor_time()
        print(json.dumps(asdict(run(*asked.one))))
        return
    runs = measured(asked.records.split(","), asked.limit)
    text = report(runs, f"python benchmarks/tuning.py --limit {asked.limit:g}")
    if asked.output is not None:
        write_atomic(asked.output, text)
    sys.stdout.write(text)


if __name__ == "__main__":
    main()
