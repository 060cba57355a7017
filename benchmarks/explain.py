"""Sixty planted conflicts: are they named, is nothing spare, do changes work, at what cost.

    python benchmarks/explain.py [--family F ..] [--no-changes]

For each mission: the processor time of one proof that there is no plan (`stlc solve`, with its
second solver), that of explaining, their ratio, and whatever is wrong. Exit status 1 when anything
is, or when explaining costs more than five times a proof in the median.
"""

from __future__ import annotations

import argparse
import sys
from statistics import median
from time import process_time

from conflicts.check import broken, faults, freeing, names_of, offered
from conflicts.planted import FAMILIES, everything

from stlc.api import loads, solve
from stlc.errors import InfeasibleError
from stlc.explain.conflict import Conflict, explain
from stlc.mission import Mission

DEAR = 5.0  # times one proof


def proof(mission: Mission) -> float:
    """Processor seconds until a solve says, with a second solver's word, that there is no plan."""
    began = process_time()
    try:
        solve(mission)
    except InfeasibleError:
        return process_time() - began
    raise AssertionError("the planted mission has a plan")


def _summary(ratios: list[float], wrong: int, changes: int, free: int, left: int) -> str:
    """The last two lines."""
    return (
        f"{len(ratios)} conflicts, {wrong} with something wrong, {changes} changes; "
        f"explaining takes {median(ratios):.2f} times one proof in the median, "
        f"{max(ratios):.2f} at most\n"
        f"of {free + left} members, removing one alone gives the mission a plan {free} times, and "
        f"leaves another conflict {left} times"
    )


def main() -> int:
    """Run all, print a line for each."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--family", nargs="*", choices=list(FAMILIES), default=list(FAMILIES))
    parser.add_argument("--no-changes", action="store_true")
    given = parser.parse_args()
    ratios, wrong, changes, free, left = [], 0, 0, 0, 0
    loads("agent a : single_integrator { start (0, 0); control |u| <= 1 }\nhorizon 1\n")
    for case in (c for c in everything() if c.family in given.family):
        mission = loads(case.text, name=f"{case.name}.stl")
        first = proof(mission)
        began = process_time()
        found = explain(mission)
        took = process_time() - began
        assert isinstance(found, Conflict), f"{case.name}: {found}"
        problems = list(faults(case, mission, found))
        freed = freeing(mission, found)
        free, left = free + freed[0], left + freed[1]
        made = () if given.no_changes else offered(case, mission, found)
        problems += list(broken(made))
        if not made and not given.no_changes:
            problems.append("no change is offered")
        ratios.append(took / first)
        wrong, changes = wrong + bool(problems), changes + len(made)
        print(
            f"{case.name:16} proof {first:6.2f} s  explained {took:6.2f} s  x {ratios[-1]:5.2f}  "
            f"{len(made)} changes  {','.join(sorted(names_of(found)))}: {found.cause.text}",
            flush=True,
        )
        for problem in problems:
            print(f"  WRONG: {problem}", flush=True)
    print(_summary(ratios, wrong, changes, free, left))
    return int(wrong > 0 or median(ratios) > DEAR)


if __name__ == "__main__":
    sys.exit(main())
