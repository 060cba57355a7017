"""Costs named on the command line, read as the mission's own file would read them."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

from stlc import api
from stlc.diagnostics import Diagnostic
from stlc.errors import MissionError, UsageError
from stlc.mission import Mission, ObjectiveTerm, TermKind
from stlc.record import changed
from stlc.source import Source, Span

Terms = tuple[ObjectiveTerm, ...]


def split(text: str) -> tuple[str, str]:
    """`effort,link_cost(radio, (r1, r2))` as its two costs. UsageError for another number."""
    parts, depth = [""], 0
    for char in text:
        depth += (char in "([") - (char in ")]")
        if char == "," and depth == 0:
            parts.append("")
        else:
            parts[-1] += char
    costs = [part.strip() for part in parts]
    if len(costs) != 2 or not all(costs):
        raise UsageError(f"--pareto takes two costs such as effort,link_cost(radio), not {text!r}")
    return costs[0], costs[1]


def priced(
    mission: Mission, cost: str, folder: Path | None, allow_paths: tuple[Path, ...]
) -> tuple[Mission, Terms]:
    """The terms of a cost in a mission's words, and the mission with what they are measured by.

    MissionError where it isn't one, located in the words of `--pareto`; UsageError for robustness,
    which is no cost.
    """
    before = f"{mission.source.text}\nminimize "
    params = dict(mission.params)
    name = mission.source.name
    try:
        longer = api.loads(
            f"{before}{cost}\n", name=name, params=params, folder=folder, allow_paths=allow_paths
        )
    except MissionError as error:
        told = Source("--pareto", cost)
        moved = [_in_option(d, told, name, len(before)) for d in error.diagnostics]
        raise MissionError(moved) from None
    first = len(_weighed(mission))
    found = tuple(_weighed(longer)[first:])
    if not found or any(term.kind is TermKind.ROBUSTNESS for term in found):
        raise UsageError(
            f"{cost!r} is no cost that can be traded: take efforts, link costs and times"
        )
    known = {p.name for p in mission.preferences}
    named = {term.requirement for term in found}
    times = (p for p in longer.preferences if p.name in named and p.name not in known)
    return replace(mission, preferences=(*mission.preferences, *times)), found


def _in_option(found: Diagnostic, told: Source, name: str, skip: int) -> Diagnostic:
    """A diagnostic that lies behind the mission's text, in that of the option."""

    def moved(span: Span | None) -> Span | None:
        """The place in the option; one in a file stays where it is."""
        if span is None or span.source.name != name or span.end <= skip:
            return span
        last = len(told.text)
        return told.span(min(max(span.start - skip, 0), last), min(span.end - skip, last))

    notes = tuple(changed(note, span=moved(note.span)) for note in found.notes)
    fix = None if moved(found.span) != found.span else found.fix
    return changed(found, span=moved(found.span), notes=notes, fix=fix)


def _weighed(mission: Mission) -> list[ObjectiveTerm]:
    """What `minimize` says, without the violations of preferences, which follow it."""
    times = {p.name for p in mission.preferences if p.cost}
    return [
        term
        for term in mission.objective
        if term.kind is not TermKind.VIOLATION or term.requirement in times
    ]
