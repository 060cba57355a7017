"""Makes the runs behind `results/`: `python benchmarks/record.py [SUITE ...] [--peer DIR]`.

The commands are the data below. Runs go to `out/SUITE.sqlite`, and what is there is not made again,
so a recording that was interrupted goes on. Then the report is written: text and CSV to `results/`,
the page to `out/SUITE.html`. Figures to compare by the clock are made one at a time; `--workers 2`
stands where sizes, bounds and gaps matter more.
"""

from __future__ import annotations

import argparse
import os
import shlex
import subprocess
import sys
from pathlib import Path

from peer_effort import convert

from stlc.files import write_atomic

FOLDER = Path(__file__).parent
CHECKOUT = FOLDER.parent
COMMANDS = {
    "paper": (
        "--encodings auto,auto:milp --repeat 3 --time-limit 120",
        "--encodings literal-tight:milp,literal:milp --time-limit 783 --workers 2",
    ),
    "headline": (
        "--only two_agents_t8,links_a2_t8_c10 --time-limit 60",
        "--time-limit 60 --workers 2",
    ),
    "stlpy": ("--quick --repeat 3 --time-limit 45",),
    "radio": ("--time-limit 10 --workers 2",),
    "teams": ("--time-limit 20 --workers 2",),
    "scaling": ("--time-limit 20 --workers 2",),
    "long": ("--time-limit 60",),
    "published": ("--time-limit 60",),
    "ablation": (
        "--repeat 3 --time-limit 20 --workers 2",
        "--encodings auto:milp --passes each --repeat 3 --time-limit 20 --workers 2",
    ),
}
_ENTRY = "import sys; from stlc.cli import main; sys.argv[0] = 'stlc'; main()"


def stlc(*words: str) -> str:
    """Run a command of stlc from the checkout; what it says on standard output."""
    env = os.environ | {"PYTHONPATH": os.pathsep.join([str(CHECKOUT), *filter(None, sys.path)])}
    print(shlex.join(["stlc", *words]), file=sys.stderr, flush=True)
    done = subprocess.run(
        [sys.executable, "-c", _ENTRY, *words], cwd=CHECKOUT, env=env, check=True,
        stdout=subprocess.PIPE, text=True,
    )  # fmt: skip
    return done.stdout


def _peers(suite: str, peer: Path) -> Path:
    """The folder of another tool's models, made over where the suite minimises effort."""
    if suite == "stlpy":
        return peer.absolute()
    target = CHECKOUT / "out" / "frugal"
    convert(peer, target)
    return target


def record(suite: str, peer: Path | None) -> None:
    """Make the runs of a suite and write their report."""
    store = f"out/{suite}.sqlite"
    beside = ["--peer", str(_peers(suite, peer))] if peer and suite in ("stlpy", "long") else []
    for options in COMMANDS[suite]:
        stlc("bench", suite, *options.split(), *beside, "--store", store)
    page, table = f"out/{suite}.html", FOLDER / "results" / f"{suite}.csv"
    said = stlc("bench", "report", "--store", store, "-o", page, "--csv", str(table))
    write_atomic(table.with_suffix(".txt"), said.replace(f"{page} written\n", ""))


def main() -> None:
    """Record the suites that are named, all if none is."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("suites", nargs="*", metavar="SUITE", help=", ".join(COMMANDS))
    parser.add_argument("--peer", type=Path, help="folder of stlpy's models, for stlpy and long")
    asked = parser.parse_args()
    for suite in asked.suites or COMMANDS:
        if suite not in COMMANDS:
            parser.error(f"there is no suite {suite}; known: {', '.join(COMMANDS)}")
        record(suite, asked.peer)


if __name__ == "__main__":
    main()
