"""`stlc explain`: which parts of the file conflict, and why."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from stlc.cli.amount import Amount
from stlc.cli.answer import answer
from stlc.cli.common import (
    GRACE,
    check_outputs,
    load,
    mission_options,
    parse_defines,
)
from stlc.cli.completion import backend_option
from stlc.cli.planned import load_planned
from stlc.errors import InfeasibleError, NoPlanError, ViolationError
from stlc.files import real

if TYPE_CHECKING:
    from stlc.explain.conflict import Conflict
    from stlc.explain.edits import Change
    from stlc.explain.oracle import Oracle
    from stlc.explain.repair import Load
    from stlc.mission import Mission

_OFFERED = 5  # changes
_EXPLAINING = 0.5  # part of the time, where changes are looked for afterwards


@click.command("explain")
@mission_options
@click.argument("plan", type=click.Path(path_type=Path), required=False)
@backend_option
@click.option("--time-limit", type=Amount(min=0), default=60.0, show_default=True,
              metavar="S", help="Seconds for all solves together.")  # fmt: skip
@click.option("--all", "every", is_flag=True, help="Every minimal conflict, not one.")
@click.option("--fix", is_flag=True, help="Offer the smallest changes that give a plan.")
@click.option("--apply", "out", type=click.Path(path_type=Path), metavar="OUT",
              help="Write a copy of FILE with a change made (implies --fix).")  # fmt: skip
@click.option("--pick", type=click.IntRange(1, _OFFERED), default=1, show_default=True, metavar="K",
              help="Which of the changes `--apply` makes.")  # fmt: skip
@click.option("--json", "as_json", is_flag=True, help="Print one JSON object.")
def explain_command(
    file: Path,
    define: tuple[str, ...],
    allow_path: tuple[Path, ...],
    plan: Path | None,
    **words: Any,
) -> int:
    """Say which parts of FILE cannot hold together, and why; exit 3 when there are such.

    Exit 0 when a plan was found possible; 4 when neither was proven within the limit. With a PLAN:
    which requirements are tight, which predicate decides each and when, its slack, and what its
    margin costs; exit 6 when the plan violates the mission.
    """
    given = _Words(**words)
    if plan is not None:
        return _explain_plan(file, define, allow_path, plan, given)
    if given.out is not None and str(given.out) == "-":
        raise click.UsageError("--apply writes a file: standard output has the list of changes")
    check_outputs(given.out)
    mission = load(file, define, allow_path)
    check_outputs(given.out)  # now that it is known what was read

    def again(text: str) -> Mission:
        from stlc.api import loads

        folder = real(file).parent
        return loads(
            text, name=str(file), params=parse_defines(define), folder=folder,
            allow_paths=allow_path,
        )  # fmt: skip

    return _explain(mission, again, given)


@dataclass(frozen=True, slots=True)
class _Words:
    """The options of `stlc explain` as click hands them over; seconds."""

    backend: str
    time_limit: float
    every: bool
    fix: bool
    out: Path | None
    pick: int
    as_json: bool

    @property
    def fixes(self) -> bool:
        """Whether changes are asked for."""
        return self.fix or self.out is not None


def _explain_plan(
    file: Path, define: tuple[str, ...], allow_path: tuple[Path, ...], plan: Path, given: _Words
) -> int:
    """Print what of a plan is tight; the exit status of `stlc explain FILE PLAN`."""
    from stlc.explain.tight import explain_plan

    if given.every or given.fix or given.out is not None:
        raise click.UsageError("--all, --fix and --apply are for missions without a plan")
    found = explain_plan(*load_planned(file, plan, define, allow_path))
    answer(found.as_dict()) if given.as_json else click.echo(found.text())
    return 0 if found.report.ok else ViolationError.exit_status


def _explain(mission: Mission, load_text: Load, given: _Words) -> int:
    """Print the conflict, or every one, and changes; the exit status of `stlc explain`."""
    from stlc.explain.oracle import Oracle, Verdict
    from stlc.explain.repair import Repairer
    from stlc.explain.whole import begin, undecided
    from stlc.solve.deadline import Deadline

    end = Deadline.after(given.time_limit)
    part = end.share(_EXPLAINING) if given.fixes else end
    oracle = Oracle(mission, given.backend, part, GRACE)
    verdict = begin(oracle)
    if verdict is Verdict.UNKNOWN:
        known = undecided(oracle)
        text = f"not decided within {given.time_limit:g} s"
        raise NoPlanError(f"{text}: {known}" if known else text)
    if verdict is Verdict.FEASIBLE:
        text = "no conflict: the requirements can be satisfied together"
        answer({"status": "feasible", "conflicts": []}) if given.as_json else click.echo(text)
        return 0
    found, complete = _conflicts(oracle, given.every)
    repairer = Repairer(load_text, given.backend, end, GRACE)
    changes = repairer.changes(mission, found[0], _OFFERED) if found and given.fixes else ()
    if given.as_json:
        answer(_as_dict(found, complete, changes))
    else:
        _print(found, complete, given)
        _offer(changes, repairer.open, given)
        _held(mission, given)
    if given.out is not None:
        _apply(changes, given)
    return InfeasibleError.exit_status


def _apply(changes: Sequence[Change], given: _Words) -> None:
    """Write the changed text, and say so; NoPlanError without any change, UsageError where there
    are fewer than the one that was picked."""
    from stlc.files import write_atomic

    assert given.out is not None
    if not changes:
        raise NoPlanError(f"{_offers(0)}: nothing was written to {given.out}")
    if len(changes) < given.pick:
        few = f"--pick {given.pick} of {_offers(len(changes))}"
        raise click.UsageError(f"{few}: nothing was written to {given.out}")
    change = changes[given.pick - 1]
    write_atomic(given.out, change.text)
    click.echo(f"wrote {given.out}: change {given.pick}, {change}", err=given.as_json)


def _as_dict(
    found: Sequence[Conflict], complete: bool, changes: Sequence[Change]
) -> dict[str, Any]:
    return {
        "status": "infeasible",
        "complete": complete,
        "conflicts": [c.as_dict() for c in found],
        "changes": [c.as_dict() for c in changes],
    }


def _print(found: Sequence[Conflict], complete: bool, given: _Words) -> None:
    """Conflicts on standard error, their number on standard output."""
    from stlc.cli.conflicts import show

    for conflict in found:
        show(conflict)
    if given.every:
        click.echo(_count(len(found), complete))


def _offer(changes: Sequence[Change], is_open: bool, given: _Words) -> None:
    """Changes on standard output, where they are asked for."""
    if changes:
        click.echo(f"{_offers(len(changes))}, each with a verified plan; the smallest first:")
        for number, change in enumerate(changes, start=1):
            click.echo(f"  {number}. {change}")
    elif given.fixes and is_open:
        click.echo("no change of the file's numbers was found within the limit to give a plan")
    elif given.fixes:
        click.echo("no single number of those named here gives a plan, nor any set of them tried")


def _held(mission: Mission, given: _Words) -> None:
    """Say which numbers are none of the file's to change: those of `-D`."""
    if given.fixes and mission.params:
        names = ", ".join(f"`{name}`" for name in mission.params)
        click.echo(f"  {names} {'is' if len(mission.params) == 1 else 'are'} set by -D and kept")


def _offers(number: int) -> str:
    return f"{number} change{'' if number == 1 else 's'} of the file"


def _conflicts(oracle: Oracle, every: bool) -> tuple[Sequence[Conflict], bool]:
    """One conflict or all of them; whether there can be no other."""
    from stlc.explain.conflict import all_conflicts, conflict_of

    if not every:
        return [conflict_of(oracle, oracle.mission.requirements)], False
    found = list(all_conflicts(oracle))
    return found, not (oracle.open or oracle.deadline.over())


def _count(number: int, complete: bool) -> str:
    more = "" if complete else "; there may be others: some questions took too long"
    return f"{number} minimal conflict{'' if number == 1 else 's'}{more}"
