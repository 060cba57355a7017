"""Preferences as requirements and costs of an ordinary mission, before anything is encoded.

A violation of robustness, max(0, margin - rho(phi)), is the margin less the robustness of

    phi and (margin)                   a requirement that asks for no more than phi's static least

which is maximised with the weight of the preference. For `late` and `share` each part i gets an
input s_i in [0, 1] of an agent that stands for the preference, and the requirement

    part_i or s_i >= 1                 s_i costs weight * worth / scale, at step 0 alone

Either is exact: at an optimum what is paid is what the run violates. Only what the objective or a
cap counts is lowered.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from stlc.analysis.link_tables import LinkTables
from stlc.analysis.ranges import Ranges
from stlc.analysis.reach import reach
from stlc.dynamics import Dynamics
from stlc.errors import UsageError
from stlc.ir.nodes import And, Linear, Link, Node, Not, Or, Role, Signal, walk
from stlc.ir.requirement import Requirement
from stlc.mission import Agent, Cap, Mission, ObjectiveTerm, TermKind
from stlc.preferences import Measure, Preference


@dataclass(frozen=True, slots=True, eq=False)
class Lowered:
    """An ordinary mission and its ranges; `offset` is what its objective leaves out, `stand_ins`
    are agents that no plan has."""

    mission: Mission
    ranges: Mapping[str, Ranges]
    offset: float = 0.0
    stand_ins: frozenset[str] = frozenset()


def lowered(mission: Mission, ranges: Mapping[str, Ranges], tables: LinkTables) -> Lowered:
    """The mission without preferences, with the same plans and costs.

    Raises UsageError where nothing bounds how far a preference may be violated.
    """
    counted = {t.requirement for t in _all_terms(mission) if t.kind is TermKind.VIOLATION}
    wanted = {p.name: p for p in mission.preferences if p.name in counted}
    if not wanted:
        return Lowered(mission, ranges)
    agents, extra = dict(mission.agents), []
    for p in wanted.values():
        if p.measure is Measure.ROBUSTNESS:
            extra.append(_soft(p, _least(p.formula, ranges, tables, p)))
            continue
        agents[_owner(p)] = _payer(p)
        extra += [_payable(p, k, part) for k, part in enumerate(p.parts)]
    caps = tuple(
        Cap(c.name, _terms(mission, c.terms, wanted), c.limit - _offset(c.terms, wanted))
        for c in mission.caps
    )
    plain = replace(
        mission,
        agents=agents,
        requirements=(*mission.requirements, *extra),
        objective=_terms(mission, mission.objective, wanted),
        preferences=(),
        caps=caps,
    )
    stand_ins = frozenset(agents.keys() - mission.agents.keys())
    return Lowered(plain, reach(plain), _offset(mission.objective, wanted), stand_ins)


def _all_terms(mission: Mission) -> list[ObjectiveTerm]:
    return [*mission.objective, *(t for cap in mission.caps for t in cap.terms)]


def _terms(
    mission: Mission, terms: tuple[ObjectiveTerm, ...], wanted: Mapping[str, Preference]
) -> tuple[ObjectiveTerm, ...]:
    """Terms in the words of an ordinary mission; efforts of all agents name them."""
    found = []
    for term in terms:
        if term.kind is TermKind.EFFORT and not term.agents:
            term = replace(term, agents=tuple(mission.agents))
        if term.kind is TermKind.VIOLATION:
            assert term.requirement is not None
            term = _paid(term, wanted[term.requirement])
        found.append(term)
    return tuple(found)


def _paid(term: ObjectiveTerm, p: Preference) -> ObjectiveTerm:
    if p.measure is Measure.ROBUSTNESS:
        weight = -term.weight / p.scale
        return ObjectiveTerm(TermKind.ROBUSTNESS, weight, requirement=p.name, span=term.span)
    return ObjectiveTerm(
        TermKind.EFFORT, term.weight, agents=(_owner(p),), window=(0, 0), span=term.span
    )


def _offset(terms: tuple[ObjectiveTerm, ...], wanted: Mapping[str, Preference]) -> float:
    """What the terms of violated robustness leave out: weight * margin / scale."""
    return math.fsum(
        term.weight * p.margin / p.scale
        for term in terms
        if term.kind is TermKind.VIOLATION
        and (p := wanted[term.requirement or ""]).measure is Measure.ROBUSTNESS
    )


def _soft(p: Preference, least: float) -> Requirement:
    enough = Linear((), p.margin, p.unit)
    return Requirement(p.name, And((p.formula, enough)), min(least, p.margin), p.span)


def _owner(p: Preference) -> str:
    return f"({p.name})"


def _payer(p: Preference) -> Agent:
    """An agent that is nowhere and stands still; its inputs say which parts are given up."""
    count = len(p.parts)
    zero, one = np.zeros(1), np.ones(count)
    inputs = tuple(f"part{k}" for k in range(count))
    model = Dynamics(
        "preference", np.zeros((1, 1)), np.zeros((1, count)), zero, ("rest",), inputs, ("",),
        ("",) * count,
    )  # fmt: skip
    worth = np.full(count, p.worth / p.scale)
    return Agent(_owner(p), model, zero, zero, zero, 0.0 * one, one, zero, worth, span=p.span)


def _payable(p: Preference, number: int, part: Node) -> Requirement:
    paid = Signal(_owner(p), Role.INPUT, number)
    given_up = Linear(((paid, 1.0),), p.margin - 1.0)
    return Requirement(f"{p.name}_{number + 1}", Or((part, given_up)), p.margin, p.span)


def _least(formula: Node, ranges: Mapping[str, Ranges], tables: LinkTables, p: Preference) -> float:
    """No predicate, nor its negation, is ever worth less: neither is the formula."""
    found = 0.0
    for node in walk(formula):
        if isinstance(node, Linear):
            low, high = _anywhere(node, ranges)
        elif isinstance(node, Link):
            low = float(tables.robustness(node).min())
            high = -float(tables.robustness(Not(node)).min())
        else:
            continue
        found = min(found, low, -high)
    if not math.isfinite(found):
        raise UsageError(
            f"nothing bounds how far `{p.name}` may be violated: give the mission a workspace, or "
            "bounds to the states and inputs that it is about"
        )
    return found


def _anywhere(node: Linear, ranges: Mapping[str, Ranges]) -> tuple[float, float]:
    """Interval of a predicate's value at whatever step it is judged."""
    low = high = node.constant
    for signal, value in node.terms:
        r = ranges[signal.owner]
        state = signal.role is Role.STATE
        least = (r.state_lower if state else r.input_lower)[:, signal.index].min()
        most = (r.state_upper if state else r.input_upper)[:, signal.index].max()
        low += value * (least if value > 0 else most)
        high += value * (most if value > 0 else least)
    return float(low), float(high)
