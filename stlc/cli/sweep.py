"""`stlc sweep`."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from stlc.cli.amount import Amount
from stlc.cli.answer import answer
from stlc.cli.common import check_outputs, complain
from stlc.cli.completion import backend_option
from stlc.cli.interrupt import INTERRUPTED, interruptible
from stlc.errors import MissionError, SolverError
from stlc.files import real

if TYPE_CHECKING:
    from stlc.sweep.axes import Axis, Point
    from stlc.sweep.executors import Finished
    from stlc.sweep.store import Store
    from stlc.sweep.table import Table
    from stlc.sweep.work import Found, Keep, Task

_STORE = Path("out/sweep.sqlite")
_FAULTS = {"mistakes": MissionError.exit_status, "failed": SolverError.exit_status}


@dataclass(frozen=True, slots=True)
class _Words:
    """The options of `stlc sweep` as click hands them over; seconds, and a relative gap."""

    define: tuple[str, ...]
    allow_path: tuple[Path, ...]
    pareto: str | None
    points: int
    backend: str
    time_limit: float | None
    gap: float
    csv_path: Path | None
    output: Path | None
    store: Path
    no_store: bool
    workers: int
    cluster: str | None
    as_json: bool


@click.command("sweep")
@click.argument("file", type=click.Path(path_type=Path))
@click.option("-D", "define", multiple=True, metavar="NAME=VALUES",
              help="A `param` and its values: v=1..3:0.5, v=1,2,5, 'v=1..3:1 m/s'.")  # fmt: skip
@click.option("--allow-path", multiple=True, type=click.Path(path_type=Path),
              help="Also read imports and data from this folder.")  # fmt: skip
@click.option("--pareto", metavar="COST,COST",
              help="The trade-off of two costs, such as effort,link_cost(radio).")  # fmt: skip
@click.option("--points", type=click.IntRange(2, 1000), default=9, show_default=True,
              help="Of each trade-off curve, its ends included.")  # fmt: skip
@backend_option
@click.option("--time-limit", type=Amount(min=0, min_open=True), metavar="S",
              help="Seconds for each solve; the best plan so far counts.")  # fmt: skip
@click.option("--gap", type=Amount(min=0), default=1e-4, show_default=True,
              help="Relative distance from the optimum that is good enough.")  # fmt: skip
@click.option("--csv", "csv_path", type=click.Path(path_type=Path), help="The table as CSV.")
@click.option("-o", "--output", type=click.Path(path_type=Path),
              help="A picture: .png, .svg or .pdf.")  # fmt: skip
@click.option("--store", type=click.Path(path_type=Path), default=_STORE, show_default=True,
              help="Finished solves; those already in it are not made again.")  # fmt: skip
@click.option("--no-store", is_flag=True, help="Keep nothing.")
@click.option("--workers", type=click.IntRange(1), default=1, show_default=True,
              help="Processes at once.")  # fmt: skip
@click.option("--cluster", metavar="ADDRESS", help="Run on a dask.distributed cluster.")
@click.option("--json", "as_json", is_flag=True, help="Print one JSON object.")
def sweep_command(file: Path, **words: Any) -> int:
    """Solve FILE for every combination of its parameters' values.

    Every plan is certified and verified. With --pareto, the trade-off curve of two costs for each
    combination. A sweep that was interrupted goes on where it was when it is called again.
    """
    from stlc.database import make_folder
    from stlc.sweep.axes import Axis, points
    from stlc.sweep.store import Store

    given = _Words(**words)
    axes = [Axis.parse(text) for text in given.define]
    grid = points(axes)
    tasks = _tasks(file, grid, given)
    _check_values(file, axes, given)
    check_outputs(given.csv_path, given.output)
    if given.output is not None:
        from stlc.sweep.picture import check_name

        check_name(given.output)
    store = Store(None if given.no_store else given.store)
    if given.store == _STORE and not given.no_store:
        make_folder(_STORE)
    store.create()
    with interruptible() as stop:
        found = dict(_found(tasks, store, given, stop))
    results = [(point, found[k]) for k, point in enumerate(grid) if k in found]
    _show(axes, tasks[0].costs, results, given)
    return _faults(results) if len(found) == len(grid) else INTERRUPTED


def _tasks(file: Path, grid: Sequence[Point], given: _Words) -> list[Task]:
    """One for each point; the first is read at once, so that mistakes are told before a solve."""
    from stlc import backends
    from stlc.sweep.ask import Question, digest
    from stlc.sweep.costs import split
    from stlc.sweep.work import Task

    backends.get(given.backend)
    costs = None if given.pareto is None else split(given.pareto)
    files = digest(file, grid[0], given.allow_path)
    if costs is not None:
        _check_costs(file, grid[0], costs, given)
    allowed = tuple(str(real(path)) for path in given.allow_path)
    path = str(real(file))
    limits = (None, None, given.time_limit, given.gap, given.backend, allowed)
    return [Task(Question(path, point, files, *limits), costs, given.points) for point in grid]


@contextmanager
def _beyond_proof() -> Iterator[None]:
    """A mission that says by itself that it has no plan is a point like any other."""
    from stlc.sweep.ask import is_proof

    try:
        yield
    except MissionError as error:
        if not is_proof(error):
            raise


def _check_values(file: Path, axes: Sequence[Axis], given: _Words) -> None:
    """MissionError at the first value that the mission doesn't take, beside the first of others."""
    from stlc.api import load

    first = {axis.name: axis.values[0] for axis in axes}
    for axis in axes:
        for value in axis.values[1:]:
            with _beyond_proof():
                load(file, params=first | {axis.name: value}, allow_paths=given.allow_path)


def _faults(results: Sequence[tuple[Point, Found]]) -> int:
    """Tell why points couldn't be asked for, or no solver answered; the exit status."""
    from stlc.sweep.frontier import Frontier

    status = 0
    for point, found in results:
        said = found.why if isinstance(found, Frontier) else found
        if said is None or said.status not in _FAULTS:
            continue
        complain(f"{_named(point)}: {said.message}")
        status = status or _FAULTS[said.status]
    return status


def _named(point: Point) -> str:
    return ", ".join(f"{name}={value}" for name, value in point)


def _check_costs(file: Path, point: Point, costs: tuple[str, str], given: _Words) -> None:
    """MissionError or UsageError where one isn't a cost of the mission."""
    from stlc.api import load
    from stlc.sweep.costs import priced

    with _beyond_proof():
        mission = load(file, params=dict(point), allow_paths=given.allow_path)
        for cost in costs:
            priced(mission, cost, real(file).parent, given.allow_path)


def _found(
    tasks: Sequence[Task], store: Store, given: _Words, stop: Callable[[], bool]
) -> Iterator[tuple[int, Found]]:
    """Results by the number of their point: those that the store knows, then as they come."""
    from stlc.sweep.work import recalled

    open_: list[tuple[int, Task]] = []
    for number, task in enumerate(tasks):
        task, known = recalled(task, store.get)
        if known is None:
            open_.append((number, task))
        else:
            yield number, known
    done = len(tasks) - len(open_)
    if done:
        click.echo(f"{done} of {len(tasks)} points are in {store.path}", err=True)
    for number, result in _made([task for _, task in open_], given, stop, store.add):
        done += 1
        click.echo(f"[{done}/{len(tasks)}] {_named(open_[number][1].question.params)}", err=True)
        yield open_[number][0], result.found


def _made(tasks: Sequence[Task], given: _Words, stop: Callable[[], bool], keep: Keep) -> Finished:
    from stlc.sweep.executors import run_apart, run_here, run_on_cluster

    if given.cluster is not None:
        return run_on_cluster(given.cluster, tasks, stop, keep)
    if given.workers > 1:
        return run_apart(tasks, given.workers, stop, keep)
    return run_here(tasks, stop, keep)


def _show(
    axes: Sequence[Axis],
    costs: tuple[str, str] | None,
    results: list[tuple[Point, Found]],
    given: _Words,
) -> None:
    """The table on standard output, and the files that were asked for."""
    from stlc.files import write_atomic

    table = _table([axis.name for axis in axes], costs, results)
    if given.csv_path is not None:
        write_atomic(given.csv_path, table.csv())
    if given.output is not None:
        from stlc.sweep.picture import draw

        draw(given.output, axes, costs, results)
    if given.as_json:
        answer({"costs": costs, "rows": table.as_dicts()})
    else:
        click.echo(table.text())


def _table(
    names: list[str], costs: tuple[str, str] | None, results: list[tuple[Point, Found]]
) -> Table:
    from stlc.sweep.table import grid_table, trade_table

    return grid_table(names, results) if costs is None else trade_table(names, costs, results)
