"""`stlc explain`: which lines of the file conflict."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, ClassVar

import click

from stlc.cli.common import complain, load, mission_options, show_diagnostics
from stlc.diagnostics import Diagnostic, Note
from stlc.errors import InfeasibleError, NoPlanError

if TYPE_CHECKING:
    from stlc.explain.conflict import Conflict
    from stlc.mission import Bound, Mission

_GRACE = 0.4  # s that a solver may overrun its limit, or Ctrl-C, before it is left behind


class ConflictingClauses(Diagnostic):
    """No plan exists because these clauses cannot hold together.

    Dynamics, bounds and the workspace always hold; of the requirements, those shown cannot all be
    satisfied by any run. Where the set is minimal, leaving out any one of them makes the rest
    satisfiable: relax one (a later deadline, a larger region, a lower threshold), or the bounds of
    the agents it speaks of.
    """

    code: ClassVar[str] = "E0801"
    title: ClassVar[str] = "no plan exists: {what} cannot be satisfied{together}"
    label: ClassVar[str] = "{first}"
    help: ClassVar[str] = "{remedy}"
    what: str
    together: str
    first: str
    remedy: str


@click.command("explain")
@mission_options
@click.option("--backend", default="highs", show_default=True, help="See `stlc backends`.")
@click.option("--time-limit", type=click.FloatRange(min=0), default=60.0, show_default=True,
              metavar="S", help="Seconds for each of the solves.")  # fmt: skip
def explain_command(
    file: Path,
    define: tuple[str, ...],
    allow_path: tuple[Path, ...],
    backend: str,
    time_limit: float,
) -> int:
    """Say which requirements of FILE cannot hold together; exit 3 when there are such.

    Exit 0 when a plan was found possible; 4 when neither was proven within the limit.
    """
    return explain_mission(load(file, define, allow_path), backend, time_limit)


def explain_mission(mission: Mission, backend: str, time_limit: float) -> int:
    """Print the conflict; the exit status of `stlc explain`."""
    from stlc.explain.conflict import Verdict, explain

    result = explain(mission, backend=backend, time_limit=time_limit, grace=_GRACE)
    if not isinstance(result, Verdict):
        _show(result)
        return InfeasibleError.exit_status
    if result is Verdict.FEASIBLE:
        click.echo("no conflict: the requirements can be satisfied together")
        return 0
    raise NoPlanError(f"not decided within {time_limit:g} s")


def show_conflict(mission: Mission, backend: str, seconds: float, told: str) -> list[str]:
    """Print what conflicts in a mission that is proven infeasible, as found within `seconds`.
    Returns the names of its clauses.

    `told` is what the person has read of the proof already.
    """
    from stlc.explain.conflict import Verdict, explain

    limit = seconds / 4
    result = explain(
        mission, backend=backend, time_limit=limit, total=seconds, proven=True, grace=_GRACE
    )
    if isinstance(result, Verdict):
        return []
    _show(result, told)
    return [clause.name for clause in result.clauses]


def _show(conflict: Conflict, told: str = "") -> None:
    """The clauses that conflict; without any, starts, dynamics and bounds rule out every run."""
    if conflict.clauses:
        return show_diagnostics([_diagnostic(conflict, told)])
    known = "" if told and told in conflict.confirmation else f" ({conflict.confirmation})"
    complain(
        f"no requirement is to blame: starts, dynamics, bounds and workspace alone rule out "
        f"every run{known}"
    )


def _remedy(several: bool, by_cells: Bound | None) -> str:
    from stlc.solve.blame import remedy

    if by_cells is not None:
        return remedy(by_cells)
    if several:
        return "relax one of them, or the bounds of the agents they speak of"
    return "relax it, or the bounds of the agents it speaks of"


def _diagnostic(conflict: Conflict, told: str) -> Diagnostic:
    clauses = list(zip(conflict.clauses, conflict.spans, strict=True))
    several = len(clauses) > 1
    remarks = [Note(f"with this: `{c.name}`", span) for c, span in clauses[1:]]
    if conflict.by_cells is not None:
        remarks.append(Note("the partition is the cause: points of its cells may have a plan"))
    if several and not conflict.minimal:
        remarks.append(Note("the set may not be minimal: some proofs hit the time limit"))
    if not told or told not in conflict.confirmation:
        remarks.append(Note(conflict.confirmation))
    return ConflictingClauses(
        span=clauses[0][1],
        what=f"these {len(clauses)} clauses" if several else f"`{clauses[0][0].name}`",
        together=(" together" if several else "")
        + (" cell by cell" if conflict.by_cells is not None else ""),
        first=f"`{clauses[0][0].name}`" if several else "cannot hold",
        remedy=_remedy(several, conflict.by_cells),
        notes=tuple(remarks),
    )
