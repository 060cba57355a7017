"""Damaged missions through `check`, `compile` and `solve`: no crash, no hang, no wrong verdict.

    python benchmarks/fuzz_missions.py [COUNT] [--seed S] [--out FOLDER] [--only NUMBER]

Missions of the examples, the documentation, the benchmarks and the tests are changed in their
tokens, numbers, units, shapes, windows and data files. Every input is checked; of those without
errors all are compiled (of the benchmarks' and examples' own one in four), and those that give at
most 600 columns are solved with a limit of 5 s. Every hundredth input is a random scene beside an
equivalent one (moved, scaled, mirrored, cut up, its rings turned), and a quarter of the solved
mutants have a twin in another order or with other names: verdicts and optima must agree.

A fault is a crash or exit 70, an error without line and column, a status that isn't documented for
such an input, `--json` output that isn't JSON, `check` above 5 CPU s or 1 GB, `compile` above
20 s, `solve` above 30 s, and a verdict that differs from the twin's. Inputs run one after the
other in a worker process, for speed; one that shows a fault there runs again in a child process
for each command, as for a user, and only what goes wrong in these counts (what an input leaves
behind in the worker, such as a solver's thread, may spoil another's output). Each kind's first
inputs are saved to FOLDER, shortened by deleting lines. A run that was cut short goes on where it
ended.
"""

from __future__ import annotations

import argparse
import json
import shutil
import sys
import tempfile
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from pathlib import Path
from time import monotonic
from typing import Any, Protocol

from fuzz.corpus import corpus
from fuzz.faults import Fault, faults
from fuzz.fresh import Fresh
from fuzz.inputs import Input, drawn
from fuzz.pool import Worker
from fuzz.shorten import shortened
from fuzz.worker import Ran

COLUMNS = 600
SAVED = 3  # inputs of each signature
CPU = {"check": 20.0, "compile": 60.0, "solve": 60.0}  # s, then the watchdog ends it
_SOLVE = ("--json", "--time-limit", "5", "--threads", "1", "--no-explain", "--progress", "none")


@dataclass(slots=True)
class Examined:
    """What one input came to."""

    faults: list[Fault] = field(default_factory=list)
    ends: list[str] = field(default_factory=list)
    seconds: float = 0.0


class Runs(Protocol):
    """What runs a command in a folder, within CPU seconds."""

    def run(self, folder: Path, words: tuple[str, ...], cpu_limit: float) -> Ran: ...


@dataclass(slots=True)
class Examiner:
    """Runs the commands on inputs."""

    worker: Runs
    folder: Path
    solves: bool = True
    again: Runs | None = field(default_factory=Fresh)

    def examine(self, given: Input) -> Examined:
        """All commands that the input is due; what shows a fault is examined `again`."""
        found = self._examined(given)
        if not found.faults or self.again is None:
            return found
        alone = Examiner(self.again, self.folder, self.solves, None).examine(given)
        return replace(alone, seconds=alone.seconds + found.seconds)

    def _examined(self, given: Input) -> Examined:
        shutil.rmtree(self.folder, ignore_errors=True)
        self.folder.mkdir(parents=True)
        given.write(self.folder)
        found = Examined()
        verdict = self._commands(given, "m.stl", found)
        if given.twin is not None and verdict is not None and self.solves and not found.faults:
            twin = self._commands(given, "twin.stl", found)
            found.faults += _compared(given, verdict, twin)
        return found

    def _commands(self, given: Input, name: str, found: Examined) -> tuple[int, Any] | None:
        """Status and objective of `solve`, where it was solved."""
        if self._run(found, "check", name, "--format", "json").status or not given.compiled:
            return None
        compiled = self._run(found, "compile", name, "--json")
        if compiled.status == 3:
            return 3, None
        large = name == "m.stl" and _columns(compiled) > COLUMNS
        if compiled.status or large or not self.solves:
            return None
        solved = self._run(found, "solve", name, *_SOLVE)
        return solved.status, _objective(solved)

    def _run(self, found: Examined, command: str, name: str, *more: str) -> Ran:
        ran = self.worker.run(self.folder, (command, name, *more), CPU[command])
        found.faults += faults(ran)
        found.ends.append(f"{command} {ran.status}")
        found.seconds += ran.seconds
        return ran


def _columns(ran: Ran) -> int:
    try:
        told = json.loads(ran.stdout)
    except ValueError:
        return COLUMNS + 1
    return int(told.get("columns", COLUMNS + 1))


def _objective(ran: Ran) -> float | None:
    try:
        told = json.loads(ran.stdout)
    except ValueError:
        return None
    return told["objective"] if told.get("status") == "optimal" else None


def _compared(given: Input, one: tuple[int, Any], other: tuple[int, Any] | None) -> Iterator[Fault]:
    """A twin that has another verdict."""
    statuses = {one[0], None if other is None else other[0]}
    if other is None:
        yield Fault("twin", "solve", f"{given.change}: the twin isn't solved")
    elif statuses == {0, 3}:
        yield Fault("verdict", "solve", f"{given.change}: {one[0]} and {other[0]}")
    elif one[1] is not None and other[1] is not None:
        want = one[1] * given.factor
        if abs(other[1] - want) > given.close * max(given.factor, abs(want)):
            yield Fault("optimum", "solve", f"{given.change}: {want:.6g} and {other[1]:.6g}")


@dataclass(slots=True)
class Campaign:
    """A run with its log of what is done, and the inputs that it saved."""

    seed: int
    out: Path
    examiner: Examiner
    tally: Counter[str] = field(default_factory=Counter)
    kinds: Counter[str] = field(default_factory=Counter)
    seconds: float = 0.0

    @property
    def log(self) -> Path:
        """One JSON line an input."""
        return self.out / f"seed_{self.seed}.jsonl"

    def resume(self) -> set[int]:
        """Numbers that are done, counted again."""
        done = set()
        for line in self.log.read_text().splitlines() if self.log.exists() else ():
            entry = json.loads(line)
            done.add(entry["number"])
            self._count(entry)
        return done

    def run(self, count: int) -> None:
        """Every input that isn't done."""
        done, seeds, began = self.resume(), corpus(), monotonic()
        for number in range(count):
            if number in done:
                continue
            given = drawn(number, self.seed, seeds)
            found = self.examiner.examine(given)
            entry = {
                "number": number, "origin": given.origin, "ends": found.ends,
                "seconds": round(found.seconds, 3), "faults": [f.signature for f in found.faults],
            }  # fmt: skip
            for fault in found.faults:
                if self.kinds[fault.signature] < SAVED:
                    self._save(number, given, fault)
            self._count(entry)
            with self.log.open("a") as file:
                file.write(json.dumps(entry) + "\n")
            if number % 500 == 499:
                print(f"{number + 1}: {monotonic() - began:.0f} s, {dict(self.kinds)}", flush=True)

    def _count(self, entry: dict[str, Any]) -> None:
        self.tally.update(entry["ends"])
        self.kinds.update(entry["faults"])
        self.seconds += entry["seconds"]

    def _save(self, number: int, given: Input, fault: Fault) -> None:
        """The input in a folder of its own, shortened, with what is wrong."""
        alone = replace(given, twin=None)
        own = any(f.signature == fault.signature for f in self.examiner.examine(alone).faults)
        small = shortened(alone, fault, self.examiner) if own else given
        kind = "".join(c if c.isalnum() else "_" for c in f"{fault.command} {fault.kind}")
        folder = self.out / f"{kind}_{self.seed}_{number}"
        folder.mkdir(parents=True, exist_ok=True)
        small.write(folder)
        (folder / "fault.txt").write_text(f"{given.origin}\n{fault.signature}\n{fault.detail}\n")

    def summary(self) -> str:
        """Ends of the commands and signatures of the faults."""
        lines = [f"{end:14} {count}" for end, count in sorted(self.tally.items())]
        lines += [f"FAULT {count:5} x {kind}" for kind, count in self.kinds.most_common()]
        return "\n".join([*lines, f"{self.kinds.total()} faults; {self.seconds:.0f} CPU s"])


def main() -> int:
    """Run and report."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("count", type=int, nargs="?", default=2000)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--out", type=Path, default=Path("out") / "fuzz")
    parser.add_argument("--no-solve", action="store_true", help="Check and compile alone.")
    parser.add_argument("--only", type=int, help="Examine this input alone, and show it.")
    words = parser.parse_args()
    words.out.mkdir(parents=True, exist_ok=True)
    worker = Worker()
    with tempfile.TemporaryDirectory(prefix="fuzz_") as folder:
        examiner = Examiner(worker, Path(folder) / "case", not words.no_solve)
        if words.only is not None:
            given = drawn(words.only, words.seed, corpus())
            print(given.origin, given.text, examiner.examine(given), sep="\n")
            worker.stop()
            return 0
        campaign = Campaign(words.seed, words.out, examiner)
        campaign.run(words.count)
        worker.stop()
    print(campaign.summary())
    return int(campaign.kinds.total() > 0)


if __name__ == "__main__":
    sys.exit(main())
