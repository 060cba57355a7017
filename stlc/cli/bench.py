"""`stlc bench`: runs benchmark suites; `stlc bench report`: what came out of it."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from stlc.cli.amount import THREADS, Amount
from stlc.cli.interrupt import INTERRUPTED, interruptible

if TYPE_CHECKING:
    from stlc.bench.job import Job, Limits
    from stlc.bench.problem import Suite
    from stlc.bench.record import Record
    from stlc.bench.schedule import Choice
    from stlc.bench.store import Store

_STORE = Path("out/bench.sqlite")
_QUICK_SECONDS = 10.0


class _RunUnlessReport(click.Group):
    """`stlc bench paper` means `stlc bench run paper`; only `report` is a command of its own."""

    def parse_args(self, ctx: click.Context, args: list[str]) -> list[str]:
        known = args and args[0] in self.commands
        return super().parse_args(ctx, args if known else ["run", *args])


@click.group("bench", cls=_RunUnlessReport)
def bench_command() -> None:
    """Run benchmark suites in processes of their own, and report on them."""


def _words(ctx: click.Context, param: click.Parameter, value: str) -> tuple[str, ...]:
    """A list of words, separated by commas."""
    return tuple(filter(None, (word.strip() for word in value.split(","))))


def _seconds(ctx: click.Context, param: click.Parameter, value: str) -> dict[str, float]:
    """Time limits by encoding; '' is for all others."""
    found = {}
    for word in _words(ctx, param, value):
        name, _, number = word.rpartition("=")
        try:
            found[name.strip()] = float(number)
        except ValueError:
            raise click.BadParameter(f"'{word}' is neither seconds nor ENCODING=SECONDS") from None
        if not 0 < found[name.strip()] < math.inf:
            raise click.BadParameter(f"'{word}': seconds must be greater than 0 and finite")
    return found


@dataclass(frozen=True, slots=True)
class _Words:
    """The options of `stlc bench run` as click hands them over; seconds by encoding, GB."""

    encodings: tuple[str, ...]
    backends: tuple[str, ...]
    passes: tuple[str, ...]
    strategies: tuple[str, ...]
    peer: Path | None
    only: tuple[str, ...]
    quick: bool
    time_limit: dict[str, float]
    repeat: int
    gap: float
    threads: int
    memory: float | None
    workers: int
    cluster: str | None
    store: Path
    registry: Path | None
    listing: bool


@bench_command.command("run", options_metavar="[OPTIONS]")
@click.argument("suites", nargs=-1, metavar="[SUITE]...")
@click.option("--encodings", callback=_words, default="", metavar="A,B+C",
              help="Instead of each suite's: auto, literal:milp, stl=log+link=hull")  # fmt: skip
@click.option("--backends", callback=_words, default="highs", show_default=True, metavar="A,B",
              help="See `stlc backends`.")  # fmt: skip
@click.option("--passes", callback=_words, default="all", show_default=True, metavar="A,B",
              help="all, none, no-X, no-X+Y, or 'each': all, then without each one.")  # fmt: skip
@click.option("--strategies", callback=_words, default="auto", show_default=True, metavar="A,B",
              help="auto, milp; see `stlc solve --help`.")  # fmt: skip
@click.option("--peer", type=click.Path(path_type=Path), metavar="DIR",
              help="Solve DIR/PROBLEM__NAME.mps[.xz] beside ours.")  # fmt: skip
@click.option(
    "--only", callback=_words, default="", metavar="A,B", help="Problems with these in their name."
)
@click.option("--quick", is_flag=True, help="Only problems that take seconds; time limit 10 s.")
@click.option("--time-limit", callback=_seconds, default="", metavar="S[,ENCODING=S]",
              help="Of the solver, for each run; 'literal=783' and 'peer=120' are for those alone. "
              " [default: 60, quick: 10]")  # fmt: skip
@click.option("--repeat", type=click.IntRange(min=1), default=1, show_default=True, metavar="N",
              help="Only what was solved the first time is repeated.")  # fmt: skip
@click.option("--gap", type=Amount(min=0), default=1e-4, show_default=True,
              help="Relative distance from the optimum that is good enough.")  # fmt: skip
@click.option("--threads", type=THREADS, default=1, show_default=True,
              help="Of the solver.")  # fmt: skip
@click.option("--memory", type=Amount(min=0, min_open=True), metavar="GB", help="For each run.")
@click.option("--workers", type=click.IntRange(min=1), default=1, show_default=True,
              help="Runs at once; more than one disturb each other's times.")  # fmt: skip
@click.option("--cluster", metavar="ADDRESS", help="Run on a dask.distributed cluster.")
@click.option("--store", type=click.Path(path_type=Path), default=_STORE, show_default=True,
              help="Finished runs; those already in it are not made again.")  # fmt: skip
@click.option("--registry", type=click.Path(path_type=Path), metavar="DIR",
              help="Folder of registry.py and missions/.  [default: the checkout's]")  # fmt: skip
@click.option("--list", "listing", is_flag=True, help="List suites and problems, run nothing.")
def run_command(suites: tuple[str, ...], **words: Any) -> int:
    """Run benchmark suites (all of them, if none is named), each solve in its own process.

    A run that was interrupted or killed goes on where it was when the same command is given
    again. `stlc bench report --help` says how to look at the results.
    """
    from stlc.bench.registry import chosen_suites, default_folder, load_suites
    from stlc.bench.schedule import schedule
    from stlc.bench.store import Store
    from stlc.database import make_folder

    given = _Words(**words)
    folder = given.registry or default_folder()
    chosen = chosen_suites(load_suites(folder), suites)
    if given.listing:
        click.echo(_listing(chosen))
        return 0
    jobs = schedule(folder, chosen, _choice(given), _limits(given))
    store = Store(given.store)
    if given.store == _STORE:
        make_folder(_STORE)
    store.create()
    complete = _make(jobs, store, given)
    click.echo(_closing(jobs, store))
    return 0 if complete else INTERRUPTED


def _choice(given: _Words) -> Choice:
    from stlc.bench.schedule import Choice

    return Choice(
        given.encodings, given.backends, given.passes, given.strategies,
        given.repeat, given.quick, given.only, given.peer,
        {name: seconds for name, seconds in given.time_limit.items() if name},
    )  # fmt: skip


def _limits(given: _Words) -> Limits:
    from stlc.bench.job import Limits

    seconds = given.time_limit.get("", _QUICK_SECONDS if given.quick else 60.0)
    memory = None if given.memory is None else int(given.memory * 2**30)
    return Limits(seconds, given.gap, given.threads, memory)


def _make(jobs: tuple[Job, ...], store: Store, given: _Words) -> bool:
    """Make the runs that are left, one repeat after the other; False when interrupted."""
    from dataclasses import replace

    from stlc.bench.rounds import pending, rounds

    command, done = _command(), 0
    with interruptible() as stop:
        for members in rounds(jobs):
            left = pending(members, store.records())
            done += len(members) - len(left)
            for record in _executor(left, given, stop):
                done += 1
                store.add(replace(record, command=command))
                click.echo(f"[{done}/{len(jobs)}] {_line(record)}", err=True)
            if stop():
                return False
        return True


def _executor(left: list[Job], given: _Words, stop: Callable[[], bool]) -> Iterable[Record]:
    if given.cluster:
        from stlc.bench.cluster import run_on_cluster

        return run_on_cluster(given.cluster, left, stop)
    from stlc.bench.local import run_local

    return run_local(left, given.workers, stop)


def _command() -> str:
    """As it was given; of absolute paths the last part alone, for reports are shown to others."""
    import shlex
    import sys

    words = (Path(w).name if Path(w).is_absolute() else w for w in sys.argv[1:])
    return shlex.join(["stlc", *words])


def _line(record: Record) -> str:
    value = "-" if record.objective is None else f"{record.objective:.6g}"
    seconds = record.proof or record.wall_seconds or 0.0
    name = f"{record.suite}/{record.problem}"
    return (
        f"{name:42} {record.label:28} {record.status:13} {value:>10} {seconds:8.2f} s"
        f"{'  ' + record.message[:60] if record.message and not record.certified else ''}"
    )


def _closing(jobs: tuple[Job, ...], store: Any) -> str:
    """What the store now holds of this suite, and how to look at it."""
    from stlc.bench.rounds import pending

    keys = {job.key for job in jobs}
    ours = [r for r in store.records() if r.key in keys]
    solved = sum(r.solved for r in ours)
    rest = len(pending(jobs, ours))
    left = f", {rest} are left" if rest else ""
    return (
        f"{len(ours)} runs are in {store.path}, {solved} solved to proof{left}; "
        f"see them with: stlc bench report --store {store.path}"
    )


def _listing(suites: tuple[Suite, ...]) -> str:
    lines = []
    for suite in suites:
        lines.append(f"{suite.name}: {suite.title} (encodings: {', '.join(suite.encodings)})")
        for problem in suite.problems:
            quick = "quick" if problem.quick else ""
            lines.append(f"  {problem.name:36} {quick:6} {problem.generator}".rstrip())
    return "\n".join(lines)


@bench_command.command("report")
@click.option("--store", type=click.Path(path_type=Path), default=_STORE, show_default=True,
              help="A store, or a CSV that this command wrote.")  # fmt: skip
@click.option("-o", "--output", type=click.Path(path_type=Path), metavar="FILE.html",
              help="Tables and figures on one page.")  # fmt: skip
@click.option("--csv", "csv_path", type=click.Path(path_type=Path), metavar="FILE.csv",
              help="Every figure of every run.")  # fmt: skip
@click.option("--suite", "suites", callback=_words, default="", metavar="A,B", help="Only these.")
@click.option("--against", type=click.Path(path_type=Path), metavar="OLD",
              help="Name what got worse since the runs of this store or CSV.")  # fmt: skip
def report_command(
    store: Path, output: Path | None, csv_path: Path | None, suites: tuple[str, ...],
    against: Path | None,
) -> int:  # fmt: skip
    """Say what the runs of a store came to: a summary here, an HTML page, a CSV."""
    from stlc.bench.groups import groups_of
    from stlc.bench.summary import changes_text, summary_text
    from stlc.bench.table import read_runs, to_csv
    from stlc.errors import UsageError
    from stlc.files import write_atomic

    records = [r for r in read_runs(store) if not suites or r.suite in suites]
    if not records:
        raise UsageError(f"there are no such runs in {store}")
    found = None if against is None else _against(groups_of(records), against)
    click.echo(summary_text(records))
    if found is not None:
        click.echo(changes_text(*found))
    if csv_path is not None:
        write_atomic(csv_path, to_csv(records))
    if output is not None:
        from stlc.bench.page import page

        write_atomic(output, page(records, found))
        click.echo(f"{output} written")
    return 0


def _against(now: Any, path: Path) -> tuple[str, Any]:
    from stlc.bench.compare import changes
    from stlc.bench.groups import groups_of
    from stlc.bench.table import read_runs

    return path.name, changes(now, groups_of(read_runs(path)))
