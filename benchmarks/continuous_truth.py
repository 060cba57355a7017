"""What plans really do between the samples, by a simulation of its own.

    python benchmarks/continuous_truth.py [PLANS] [--seed S] [--family F ..] [--time-limit S]

Random missions of every kind of dynamics and obstacle are solved; each plan's inputs are then
integrated from the start (closed forms, matrix exponentials), looked at in 240 points a step and
around the worst of them, and held against shapes made from the generator's own numbers. Prints
the worst excess of each family; exit status 1 when one is above 1e-6 m, when a plan goes through
a wall that is closed, or when solving ends in anything but a plan, 'infeasible' or a limit.
"""

from __future__ import annotations

import argparse
import sys
import tempfile
from collections import Counter
from dataclasses import dataclass, field
from pathlib import Path
from time import process_time

from truth.draw import FAMILIES, draw
from truth.judge import judge
from truth.motion import integrate
from truth.scene import Scene

from stlc.api import loads, solve
from stlc.errors import InfeasibleError, MissionError, NoPlanError, StlcError
from stlc.solve.outcome import SolveSettings

LIMIT = 1.01e-6  # in the unit of each condition: 1e-6, and rounding of our own integration
PATIENCE = 4  # missions that are drawn for each plan wanted


@dataclass(frozen=True, slots=True)
class Finding:
    """What came of one scene: the worst excess of each kind where there is a plan."""

    verdict: str  # plan, infeasible, limit, or what went wrong
    excess: dict[str, float] = field(default_factory=dict)

    @property
    def worst(self) -> float:
        """Over all kinds."""
        return max(self.excess.values(), default=-float("inf"))

    def is_fault(self, scene: Scene) -> bool:
        """A plan that isn't one, or no answer at all."""
        if self.verdict == "plan":
            return scene.closed or self.worst > LIMIT
        return self.verdict not in ("infeasible", "limit")


def examine(scene: Scene, time_limit: float) -> Finding:
    """Solve a scene and simulate its plan."""
    settings = SolveSettings(time_limit=time_limit, gap=0.05, threads=1, seed=1, grace=2.0)
    try:
        outcome = solve(loads(scene.text(), name=f"{scene.family}.stl"), settings)
    except InfeasibleError:
        return Finding("infeasible")
    except NoPlanError:
        return Finding("limit")
    except MissionError as error:
        return Finding("refused: " + "; ".join(str(d) for d in error.diagnostics)[:300])
    except StlcError as error:
        return Finding(f"{type(error).__name__}: {error}"[:300])
    bodies = {body.name: body for body in scene.bodies}
    runs = outcome.plan.runs
    motions = {n: integrate(b, runs[n].inputs, scene.step) for n, b in bodies.items()}
    excess = judge(scene, motions)
    drift = max(float(abs(motions[n].states - runs[n].states).max()) for n in bodies)
    return Finding("plan", excess | {"drift": drift})


def run(plans: int, seed: int, families: list[str], time_limit: float, save: Path) -> int:
    """Plans of each family in turn; the number of faults."""
    share, faults = -(-plans // len(families)), 0
    print(f"{'family':12}{'plans':>6}{'infeas.':>8}{'limit':>6}{'faults':>7}  worst excess")
    for family in families:
        tally: Counter[str] = Counter()
        worst: dict[str, float] = {}
        for number in range(seed, seed + PATIENCE * share):
            scene = draw(family, number)
            found = examine(scene, time_limit)
            tally[
                found.verdict if found.verdict in ("plan", "infeasible", "limit") else "error"
            ] += 1
            worst |= {k: v for k, v in found.excess.items() if v > worst.get(k, -1.0)}
            if found.is_fault(scene):
                tally["fault"] += 1
                _report(scene, number, found, save)
            if tally["plan"] == share:
                break
        faults += tally["fault"]
        kinds = ", ".join(f"{k} {v:.1e}" for k, v in worst.items() if v > -0.9)
        counts = "".join(f"{tally[k]:>{w}}" for k, w in
                         (("plan", 6), ("infeasible", 8), ("limit", 6), ("fault", 7)))  # fmt: skip
        print(f"{family:12}{counts}  {kinds}", flush=True)
    return faults


def _report(scene: Scene, seed: int, found: Finding, save: Path) -> None:
    path = save / f"{scene.family}_{seed}.stl"
    path.write_text(scene.text(), encoding="utf-8")
    above = {k: f"{v:.3g}" for k, v in found.excess.items() if v > LIMIT}
    why = " closed" if scene.closed else ""
    print(f"  FAULT {path}: {found.verdict}{why} {above or ''}", flush=True)


def main() -> int:
    """Run and report."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("plans", type=int, nargs="?", default=300)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--family", nargs="*", choices=list(FAMILIES), default=list(FAMILIES))
    parser.add_argument("--time-limit", type=float, default=10.0)
    parser.add_argument("--save", type=Path, help="Folder for the missions with faults.")
    words = parser.parse_args()
    save = words.save or Path(tempfile.mkdtemp(prefix="continuous_truth_"))
    save.mkdir(parents=True, exist_ok=True)
    faults = run(words.plans, words.seed, words.family, words.time_limit, save)
    print(f"{faults} faults; {process_time():.0f} CPU s")
    return int(faults > 0)


if __name__ == "__main__":
    sys.exit(main())
