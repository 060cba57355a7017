"""Conflicts as a person reads them: a diagnostic at the clauses, notes at their partners."""

from __future__ import annotations

from typing import TYPE_CHECKING, ClassVar

from stlc.cli.common import GRACE, complain, show_diagnostics
from stlc.diagnostics import Diagnostic, Note

if TYPE_CHECKING:
    from stlc.explain.conflict import Conflict
    from stlc.mission import Bound, Mission

_SHOWN = 12  # members of a conflict; one that time didn't suffice to cut down may have hundreds


class ConflictingClauses(Diagnostic):
    """No plan exists because these clauses cannot hold together.

    Dynamics always hold. Of the requirements, and of the bounds, starts, workspace and partitions
    named, those shown cannot all be satisfied by any run. Where the set is minimal, leaving out any
    one of them makes the rest satisfiable: relax one (a later deadline, a larger region, a lower
    threshold, a wider bound). `stlc explain FILE --fix` offers such changes.
    """

    code: ClassVar[str] = "E0801"
    title: ClassVar[str] = "no plan exists: {what} cannot be satisfied{together}"
    label: ClassVar[str] = "{first}"
    help: ClassVar[str] = "{remedy}"
    what: str
    together: str
    first: str
    remedy: str


class NoRunAtAll(Diagnostic):
    """No plan exists because an agent has no run, whatever is required.

    Its dynamics always hold. Of its start, its bounds and the workspace, those named here cannot
    all be kept until the horizon: without any one of them there is a run. Widen a bound or the
    workspace, move the start, or end the mission earlier.
    """

    code: ClassVar[str] = "E0808"
    title: ClassVar[str] = "no plan exists: `{agent}` has no run at all: no requirement is to blame"
    label: ClassVar[str] = "{first} cannot be kept"
    help: ClassVar[str] = "widen a bound or the workspace, move the start, or shorten the horizon"
    agent: str
    first: str


def show_conflict(mission: Mission, backend: str, seconds: float, told: str) -> list[str]:
    """Print what conflicts in a mission that is proven infeasible, as found within `seconds`.
    Returns the names of its clauses.

    `told` is what the person has read of the proof already.
    """
    from stlc.explain.conflict import Verdict, explain

    result = explain(mission, backend=backend, time_limit=seconds, proven=True, grace=GRACE)
    if isinstance(result, Verdict):
        return []
    show(result, told)
    return [clause.name for clause in result.clauses]


def show(conflict: Conflict, told: str = "") -> None:
    """The clauses that conflict; without any, starts, dynamics and bounds rule out every run."""
    if conflict.clauses:
        return show_diagnostics([_diagnostic(conflict, told)])
    if any(g.span is not None for g in conflict.givens):
        return show_diagnostics([_no_run(conflict, told)])
    known = "" if told and told in conflict.confirmation else f" ({conflict.confirmation})"
    complain(
        f"no requirement is to blame: starts, dynamics, bounds and workspace alone rule out "
        f"every run{known}"
    )


def _no_run(conflict: Conflict, told: str) -> Diagnostic:
    """The agent that has no run, at the first of its own bounds that is in the way, or its start;
    the others as notes. What was `told` already isn't said twice."""
    placed = [g for g in conflict.givens if g.span is not None]
    first = next((g for g in placed if g.owner), placed[0])
    remarks = [Note(f"with this: {g}", g.span) for g in conflict.givens if g is not first]
    remarks += _others(conflict)
    if not told or told not in conflict.confirmation:
        reason = conflict.cause.text.partition(": ")[2]
        remarks.append(Note(f"cause: {reason}"))
        proof = conflict.confirmation
        remarks.append(Note(proof.removesuffix(reason).removesuffix(": ")))
    (agent,) = conflict.agents
    return NoRunAtAll(span=first.span, agent=agent, first=str(first), notes=tuple(remarks))


def _others(conflict: Conflict) -> list[Note]:
    """Further bounds that count as one with what is given."""
    each = [(g, span) for g in conflict.givens for span in g.others]
    return [Note(f"with this: `{span.text}` of {g.owner}", span) for g, span in each]


def _remedy(several: bool, by_cells: Bound | None) -> str:
    from stlc.solve.blame import remedy

    if by_cells is not None:
        return remedy(by_cells)
    what = "one of them" if several else "it"
    return f"relax {what}, or a bound named here; `stlc explain FILE --fix` offers changes"


def _diagnostic(conflict: Conflict, told: str) -> Diagnostic:
    """The conflict as a diagnostic at its first clause, the others as notes at theirs.

    `told` is what was confirmed above already: it isn't said twice.
    """
    from stlc.explain.words import clause

    clauses = list(zip(conflict.clauses, conflict.spans, strict=True))
    several = len(clauses) > 1
    first = clause(clauses[0][0])
    return ConflictingClauses(
        span=clauses[0][1],
        what=f"these {len(clauses)} clauses" if several else f"`{clauses[0][0].name}`",
        together=(" together" if several else "")
        + (" cell by cell" if conflict.by_cells is not None else ""),
        first=f"`{clauses[0][0].name}`: {first}" if several else f"{first} cannot hold",
        remedy=_remedy(several, conflict.by_cells),
        notes=tuple(_notes(conflict, told)),
    )


def _notes(conflict: Conflict, told: str) -> list[Note]:
    """The cause, the other members, and what is known of the proof."""
    from stlc.explain.words import clause, parts_of, said
    from stlc.solve.blame import FACES, STEPS

    rest = list(zip(conflict.clauses[1:], conflict.spans[1:], strict=True))
    remarks = [Note(f"cause: {conflict.cause.text}")] if conflict.cause.text else []
    remarks += [Note(f"with this: `{c.name}`, {clause(c)}", span) for c, span in rest[:_SHOWN]]
    if len(rest) > _SHOWN:
        remarks.append(Note(f"and {len(rest) - _SHOWN} clauses more, which `--json` lists"))
    remarks += [
        Note(f"of which this: `{said(part)}`", part.span)
        for c in conflict.clauses[: _SHOWN + 1]
        for part in parts_of(c)
    ]
    remarks += [Note(f"given this: {g}", g.span) for g in conflict.givens]
    remarks += _others(conflict)
    if conflict.by_cells is not None:
        remarks.append(Note("the partition is the cause: points of its cells may have a plan"))
    if conflict.by_faces:
        remarks.append(Note(FACES))
    if conflict.by_steps:
        remarks.append(Note(STEPS))
    if not conflict.minimal:
        remarks.append(Note("the set may not be minimal: some proofs hit the time limit"))
    if not told or told not in conflict.confirmation:
        remarks.append(Note(conflict.confirmation))
    return remarks
