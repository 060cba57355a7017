"""Missions carried out in simulated worlds: how long planning anew takes, how many are kept.

    python benchmarks/renewal.py [--worlds 200] [--time-limit 1] [--store FILE] [--loops NAME]
                                  [--processor] [flat] [team]

Each world draws the true channels from what the mission knows of them and pushes agents off their
way. Printed are median and 99th percentile of the processor seconds between measuring and acting,
and how many missions hold by the true channels: planned anew at each step, with channels that learn
from what is heard and with those of the file; planned anew on events; and the first plan carried
out blindly. Each world is a line of the store, so that more worlds are added to those that are
there and an interrupted run goes on; `--seconds` ends one after so long. `--loops` takes those
whose names begin so, and `--processor` counts limits in processor time, for a shared machine.

`flat` is examples/ble_apartment.stl with noise and a margin for it, 14 steps; `team` are four
agents that cross, keep apart and report, 20 steps.
"""

from __future__ import annotations

import argparse
import re
import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import product
from pathlib import Path

import numpy as np
from scipy.stats import binomtest

from stlc import api
from stlc.arrays import Floats
from stlc.backends.base import Solution, SolveOptions
from stlc.backends.highs import Highs
from stlc.channels import LinkValues, needed, true_robustness
from stlc.errors import StlcError
from stlc.ir.nodes import Link
from stlc.milp.model import Model
from stlc.mission import Mission
from stlc.plan import Plan, read_plan
from stlc.radio.pathloss import link_distance
from stlc.renew.receding import Loop, Measured
from stlc.renew.world import SimulatedWorld
from stlc.solve import deadline
from stlc.solve.outcome import SolveSettings
from stlc.verify.requirements import swept_override
from stlc.verify.robustness import TOLERANCE, Evaluator
from stlc.verify.subject import make_subject
from stlc.verify.trace import Trace

EXAMPLES = Path(__file__).parent.parent / "examples"

TEAM = """step 1 s
horizon 20
workspace box [0, 12] x [0, 12]
dynamics cart = double_integrator { control |u| <= 1; speed <= 1.5 polygon 8; control_noise 0.01 }
agent a : cart { start (1, 2) }
agent b : cart { start (11, 3) }
agent c : cart { start (1, 9) }
agent d : cart { start (11, 10) }
station base at (6, 0)
obstacle pillar = box [5, 7] x [5, 7]
region east = box [9, 12] x [0, 12]
region west = box [0, 3] x [0, 12]
channel radio {
  path_loss L0 = -30 dBm, n = 2.5; fading 2 dB^2, shadowing 9 dB^2, length 3 m
  partition 4 x 4
}
require cross: forall x in [a, c]: eventually[0, 18] x in east
require back: forall x in [b, d]: eventually[0, 18] x in west
require clear margin 0.05: always forall x in agents: x outside pillar
require apart margin 0.05: always forall (x, y) in pairs: separation(x, y) >= 0.5 m
require report: eventually[0, 18] rssi(a, base) >= -52 dBm
minimize effort
"""


@dataclass(frozen=True, slots=True)
class Case:
    """A mission to carry out, and when it is planned anew."""

    name: str
    mission: Mission
    drift: float


def cases() -> dict[str, Case]:
    """The missions by name."""
    text = (EXAMPLES / "ble_apartment.stl").read_text()
    text = re.sub(r"(speed <= 0.5)", r"\1\n  control_noise 0.005", text)
    text = text.replace("require round:", "require round margin 0.05:")
    flat = api.loads(text, name="flat", folder=EXAMPLES)
    return {
        "flat": Case("flat", flat, 0.01),
        "team": Case("team", api.loads(TEAM, name="team"), 0.02),
    }


def kept(mission: Mission, world: SimulatedWorld, run: Plan) -> bool:
    """Whether a run holds by the true channels: every requirement, links at their true means, one
    packet's fading left."""
    subject = make_subject(mission, run, None)

    def link(predicate: Link, positive: bool) -> np.ndarray:
        """Robustness (T+1,) of a link predicate by what was drawn."""
        pair = (predicate.sender, predicate.receiver)
        channel = mission.channels[predicate.channel]
        model, _ = needed(channel)
        mean = np.array(world.means[predicate.channel, pair])
        ends = [subject.positions[name] for name in pair]
        distance = link_distance(np.hstack([end[:, :2] for end in ends]))
        sigma = np.full(len(mean), np.sqrt(model.fading))
        return true_robustness(channel, predicate, LinkValues(mean, sigma, distance))

    trace = Trace(mission.horizon + 1, subject.signals, link)
    judge = Evaluator(trace, swept_override(mission, run.runs))
    return all(judge.robustness(r.formula)[0] >= -TOLERANCE for r in mission.requirements)


class Clocked(SimulatedWorld):
    """Tells apart the processor time that goes by between its own steps."""

    __slots__ = ("_left", "seconds")

    def begin(self) -> Measured:
        """As the world."""
        found = super().begin()
        self.seconds, self._left = [], time.process_time()
        return found

    def step(self, states: Mapping[str, Floats], inputs: Mapping[str, Floats]) -> Measured:
        """As the world."""
        self.seconds.append(time.process_time() - self._left)
        found = super().step(states, inputs)
        self._left = time.process_time()
        return found


@dataclass(frozen=True, slots=True)
class Row:
    """A mission carried out in one world by one loop; `seconds` are those of each step."""

    case: str
    loop: str
    seed: int
    plans: int
    late: int
    kept: int
    seconds: tuple[float, ...]

    def text(self) -> str:
        """As a line of the store."""
        found = (self.case, self.loop, self.seed, self.plans, self.late, self.kept)
        return ",".join([*map(str, found), " ".join(f"{s:.3f}" for s in self.seconds)])

    @classmethod
    def of(cls, line: str) -> Row:
        """From a line of the store."""
        case, rest = line.strip().split(",", 1)
        loop, *numbers, seconds = rest.rsplit(",", 5)  # loops have commas in their names
        seed, plans, late, held = map(int, numbers)
        return cls(case, loop, seed, plans, late, held, tuple(map(float, seconds.split())))


def loops(case: Case, seconds: float) -> Mapping[str, Loop]:
    """When a mission is planned anew, by what is said of it."""
    settings = SolveSettings(time_limit=seconds, gap=0.02)
    return {
        "anew each step, channels learn": Loop(every=1, settings=settings),
        "anew each step, channels of the file": Loop(every=1, settings=settings, learn=False),
        "anew on events, channels learn": Loop(drift=case.drift, settings=settings),
        "the first plan, carried out blindly": Loop(sigmas=np.inf, drift=np.inf),
    }


def carried_out(case: Case, seed: int, name: str, loop: Loop, first: Plan) -> Row:
    """One mission in one world; no plan at all counts as not kept."""
    world = Clocked(case.mission, np.random.default_rng(seed))
    try:
        voyage = api.receding(case.mission, world, loop, plan=first)
    except StlcError as error:
        print(f"  {case.name}, world {seed}: {error}")
        return Row(case.name, name, seed, 0, 0, 0, tuple(world.seconds[1:]))
    late = sum(e.renewed is None for e in voyage.events)
    held = int(kept(case.mission, world, voyage.run))
    return Row(case.name, name, seed, len(voyage.events), late, held, tuple(world.seconds[1:]))


def measure(case: Case, asked: argparse.Namespace) -> None:
    """Carry a case out in every world that the store lacks, and print its figures."""
    store, first_plan = asked.store, asked.store.with_suffix(f".{case.name}.json")
    lines = store.read_text().splitlines() if store.exists() else []
    rows = [row for row in map(Row.of, lines) if row.case == case.name]
    if not first_plan.exists():
        settings = SolveSettings(time_limit=60.0, gap=0.01, save_to=first_plan)
        api.solve(case.mission, settings)
    first = read_plan(first_plan)
    print(f"{case.name}: first plan costs {first.solve.objective:.4g}")
    done = {(row.loop, row.seed) for row in rows}
    end = time.monotonic() + asked.seconds
    chosen = {
        n: loop for n, loop in loops(case, asked.time_limit).items() if n.startswith(asked.loops)
    }
    for seed, (name, loop) in product(range(asked.worlds), chosen.items()):
        if (name, seed) not in done and time.monotonic() < end:
            rows.append(carried_out(case, seed, name, loop, first))
            with store.open("a") as file:
                file.write(rows[-1].text() + "\n")
    for name in chosen:
        print(f"  {name:38} {figures([row for row in rows if row.loop == name])}", flush=True)


def figures(rows: Sequence[Row]) -> str:
    """What a line says of all worlds of a loop."""
    if not rows:
        return "-"
    times = np.array([s for row in rows for s in row.seconds])
    plans, late, good = (sum(getattr(r, n) for r in rows) for n in ("plans", "late", "kept"))
    low, high = binomtest(good, len(rows)).proportion_ci(0.95)
    return (
        f"{len(times)} steps, {plans} plans, {late} not in time; median {np.median(times):.2f} s, "
        f"p99 {np.quantile(times, 0.99):.2f} s; kept {good} of {len(rows)} "
        f"({low:.0%} to {high:.0%})"
    )


class _Processor:
    """A clock that stands still while others are at the processor."""

    monotonic = staticmethod(time.process_time)


def count_processor_time() -> None:
    """Let deadlines, and the solver that keeps them, go by the processor time of this process."""
    solve = Highs.solve

    def timed(self: Highs, model: Model, options: SolveOptions) -> Solution:
        if options.time_limit is None:
            return solve(self, model, options)
        end, asked = time.process_time() + options.time_limit, options.should_stop

        def over() -> bool:
            return time.process_time() >= end or (asked is not None and asked())

        wall = 10.0 * options.time_limit + 2.0
        return solve(self, model, replace(options, time_limit=wall, should_stop=over))

    deadline.time = _Processor  # type: ignore[attr-defined,assignment]
    Highs.solve = timed  # type: ignore[method-assign]


def main() -> None:
    """Carry out the missions that are named, or both."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("names", nargs="*", choices=[[], "flat", "team"])
    parser.add_argument("--worlds", type=int, default=10)
    parser.add_argument("--time-limit", type=float, default=1.0)
    parser.add_argument("--seconds", type=float, default=np.inf, help="end after so long")
    parser.add_argument("--store", type=Path, default=Path("renewal.csv"))
    parser.add_argument("--loops", default="", help="only those whose names begin so")
    parser.add_argument("--processor", action="store_true", help="limits in processor time")
    asked = parser.parse_args()
    if asked.processor:
        count_processor_time()
    for name, case in cases().items():
        if not asked.names or name in asked.names:
            measure(case, asked)


if __name__ == "__main__":
    main()
