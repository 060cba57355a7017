"""Requirements as the page shows them: verdict, deciding step, cost, a curve, whom they name."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from stlc.explain.tight import Explained, Standing
from stlc.ir.nodes import Linear, Link, Node, walk
from stlc.ir.requirement import Requirement
from stlc.mission import Mission
from stlc.plan import Plan
from stlc.report.numbers import short
from stlc.verify.report import tidy
from stlc.verify.timeline import Timeline, timelines


@dataclass(frozen=True, slots=True)
class Curve:
    """Robustness less the margin over the steps (null where there is none), the step that decides
    and the steps that are asked about."""

    values: list[float | None]
    step: int
    window: tuple[int, int]


@dataclass(frozen=True, slots=True)
class Need:
    """A card of the page; texts are for a person, its fields are what the scripts read.

    `lines` are the first and the last of the file `source`; `names` are agents, stations and places
    that it speaks of, `about` those of the condition that decides it.
    """

    name: str
    ok: bool
    tight: bool
    says: str
    slack: str
    value: str
    unit: str
    step: int | None
    decides: str
    price: str
    source: str | None
    lines: tuple[int, int] | None
    names: list[str]
    about: list[str]
    curve: Curve | None


def needs(mission: Mission, plan: Plan, found: Explained) -> list[Need]:
    """One for each requirement, in the order of the file."""
    standings = {s.name: s for s in found.standings}
    curves = timelines(mission, plan)
    return [
        _need(r, standings[r.name], curve)
        for r, curve in zip(mission.requirements, curves, strict=True)
    ]


def _need(requirement: Requirement, standing: Standing, curve: Timeline | None) -> Need:
    """A requirement, how it stands, and its curve, if it has one."""
    span = requirement.span
    return Need(
        name=requirement.name,
        ok=standing.report.satisfied,
        tight=standing.tight,
        says=" ".join(span.text.split()) if span is not None else "",
        slack=_slack(standing),
        value=_value(standing),
        unit=standing.unit,
        step=standing.step,
        decides=standing.decides,
        price=_price(standing),
        source=None if span is None else span.source.name,
        lines=None if span is None else (span.line, span.source.position(span.end)[0]),
        names=_names(walk(requirement.formula)),
        about=[] if curve is None else _names(curve.deciders),
        curve=None if curve is None else _curve(curve, requirement.margin),
    )


def _slack(s: Standing) -> str:
    if s.slack is None:
        return "can't be judged"
    return f"{_words(s.slack)} {s.unit}".rstrip()


def _words(value: float) -> str:
    """Four digits; what is within the tolerance of requirements is 0."""
    return "0" if abs(value) <= 1e-6 else tidy(value, 4)


def _value(s: Standing) -> str:
    """Robustness in full, where it is more than the slack."""
    parts = []
    if s.margin and s.robustness is not None:
        parts.append(f"robustness {_words(s.robustness)}, margin {s.margin:g}")
    if s.report.swept is not None:
        parts.append(f"{_words(s.report.swept)} in continuous time")
    if s.report.true is not None:
        parts.append(f"{_words(s.report.true)} at true positions")
    return "; ".join(parts)


def _price(s: Standing) -> str:
    if s.price is None:
        return ""
    per = f" per {s.unit}" if s.unit else ""
    return f"{_words(s.price)}{per}"


def _curve(curve: Timeline, margin: float) -> Curve:
    """The curve less the margin, its deciding step and its window."""
    values = np.where(np.abs(curve.values - margin) <= 1e-9, 0.0, curve.values - margin)
    return Curve(short(values), curve.step, curve.window)


def _names(nodes: Iterable[Node]) -> list[str]:
    """Agents, stations and places that parts are about, by themselves."""
    names: set[str] = set()
    for node in nodes:
        if isinstance(node, Linear):
            names |= {signal.owner for signal, _ in node.terms}
        elif isinstance(node, Link):
            names |= {node.sender, node.receiver}
        if node.member is not None:
            names.add(node.member.place)
        if node.swept is not None:
            names |= {n for n in (node.swept.agent, node.swept.other, node.swept.place) if n}
    return sorted(names)
