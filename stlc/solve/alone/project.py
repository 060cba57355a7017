"""The mission of some of its agents, alone.

In negation normal form a formula is monotone in its predicates. Those that name an agent outside
the team are taken as true, so the team's part of any run of the whole mission satisfies what is
left: the least effort of the team alone is a lower bound of its share.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator
from dataclasses import replace

from stlc.channels import ChannelTables
from stlc.ir.networks import Network, uncomposed
from stlc.ir.nodes import Const, Linear, Link, Node, Not, walk
from stlc.ir.requirement import Requirement
from stlc.ir.rewrite import rewrite
from stlc.mission import Mission, ObjectiveTerm, TermKind
from stlc.scales import static_range
from stlc.solve.alone.pieces import Pieces

_TRUE = Const(True)


def project(
    mission: Mission,
    team: Collection[str],
    channels: ChannelTables,
    pieces: Pieces | None = None,
) -> Mission:
    """The relaxation of a mission to the agents of `team`; of its objective the effort alone. Its
    `pieces` are worked out where they are not known."""
    pieces = Pieces.of(mission) if pieces is None else pieces
    others = set(mission.agents) - set(team)
    asked = tuple(pieces.about(team))
    formulas = rewrite([one.formula for one in asked], lambda node: _taken(node, others))
    return replace(
        mission,
        agents={name: agent for name, agent in mission.agents.items() if name in team},
        requirements=tuple(_left(asked, formulas)),
        objective=tuple(_efforts(mission, team, channels)),
        caps=(),
    )


def _taken(node: Node, others: Collection[str]) -> Node:
    """True in place of a predicate that names another agent: what is asked is only ever less."""
    match node:
        case Linear(terms=terms):
            named = {signal.owner for signal, _ in terms}
        case Link() | Not(arg=Link()):
            link = node.arg if isinstance(node, Not) else node
            assert isinstance(link, Link)
            named = {link.sender, link.receiver}
        case Network(composed=True, args=args) if not all(isinstance(a, Link) for a in args):
            return uncomposed(node)
        case Not(arg=Const()):  # of a link that was taken as true a moment ago
            return _TRUE
        case _:
            return node
    return node if named.isdisjoint(others) else _TRUE


def _left(
    requirements: tuple[Requirement, ...], formulas: tuple[Node, ...]
) -> Iterator[Requirement]:
    for requirement, formula in zip(requirements, formulas, strict=True):
        if any(isinstance(node, Linear | Link) for node in walk(formula)):
            yield replace(requirement, formula=formula)


def _efforts(
    mission: Mission, team: Collection[str], channels: ChannelTables
) -> Iterator[ObjectiveTerm]:
    for term in mission.objective:
        names = tuple(name for name in term.agents or mission.agents if name in team)
        if term.kind is TermKind.EFFORT and names:
            weight = term.weight / static_range(mission, term, channels)
            yield replace(term, weight=weight, agents=names, normalised=False)
