"""The mission of some of its agents against runs that others are held to.

Held agents are constants: a predicate on a free and a held agent becomes one on the free agent
alone, another at each step (moving obstacles), and a link to a held agent becomes a table over the
cells of the free one, like that of a station. What names an agent that is neither free nor held is
taken as true, as in `project`. What a free agent does in this mission, it may do in the whole one
while the held agents keep to their runs and the rest is left out.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from functools import partial

import numpy as np

from stlc.analysis.tubes import Tubes
from stlc.arrays import Floats, Ints
from stlc.channels import ChannelTables
from stlc.ir.networks import Network, uncomposed
from stlc.ir.nodes import (
    Const,
    Linear,
    Link,
    Node,
    Not,
    Quantity,
    Relation,
    Role,
    Signal,
    Timed,
    walk,
)
from stlc.ir.requirement import Requirement
from stlc.ir.rewrite import named, rewrite
from stlc.mission import Channel, Mission, ObjectiveTerm, Station, TermKind
from stlc.scales import static_range
from stlc.solve.alone.pieces import Pieces
from stlc.solve.alone.run import Run

_TRUE = Const(True)
_MISS = 1e-6  # of a predicate between agents that are all held: the tolerance of a certified plan


def against(
    mission: Mission,
    team: Collection[str],
    runs: Mapping[str, Run],
    channels: ChannelTables,
    *,
    costs: bool = True,
    pieces: Pieces | None = None,
) -> Mission:
    """The mission of `team` with the agents of `runs` held; without `costs`, no objective. Its
    `pieces` are worked out where they are not known.

    Of the objective it keeps effort and link costs. The result is to be compiled only: its links
    are tables of channels that no file knows.
    """
    held = _Held(mission, frozenset(team), runs, channels)
    pieces = Pieces.of(mission) if pieces is None else pieces
    requirements = tuple(held.left(pieces.about(team)))
    objective = tuple(held.objective()) if costs else ()
    return replace(
        mission,
        agents={name: agent for name, agent in mission.agents.items() if name in team},
        stations={**mission.stations, **held.stations},
        channels=held.channels,
        requirements=requirements,
        objective=objective,
        caps=(),
    )


@dataclass(slots=True)
class _Held:
    """Agents held to runs; channels and stations that stand for links."""

    mission: Mission
    team: frozenset[str]
    runs: Mapping[str, Run]
    tables: ChannelTables
    channels: dict[str, Channel] = field(default_factory=dict)
    stations: dict[str, Station] = field(default_factory=dict)
    _known: dict[tuple[object, ...], str] = field(default_factory=dict)
    _tubes: Tubes = field(init=False)

    def __post_init__(self) -> None:
        held = {name: a for name, a in self.mission.agents.items() if name in self.runs}
        self._tubes = Tubes.of(held, self.mission.horizon)

    def left(self, requirements: Iterable[Requirement]) -> Iterator[Requirement]:
        """What the requirements ask of the free agents."""
        for requirement in requirements:
            formula = requirement.formula
            for visit in (self._negated, self._settled):
                (formula,) = rewrite((formula,), partial(visit, margin=requirement.margin))
            if any(isinstance(node, Linear | Link) for node in walk(formula)):
                yield replace(requirement, formula=formula)

    def _negated(self, node: Node, margin: float) -> Node:
        if isinstance(node, Not) and isinstance(node.arg, Link):
            return self._link(node.arg, -self.tables.thresholds(node.arg).high, margin)
        return node

    def _settled(self, node: Node, margin: float) -> Node:
        match node:
            case Linear():
                return self._linear(node, margin)
            case Link() if node.channel not in self.channels:
                return self._link(node, self.tables.thresholds(node).low, margin)
            case Network(composed=True):
                return uncomposed(node)
        return node

    def _linear(self, node: Linear, margin: float) -> Node:
        """The predicate with held agents' runs put in as constants, one case a step, at the worst
        that their tubes hold.

        What names agents that are neither free nor held is left out: they aren't planned yet.
        """
        owners = named(node)
        if owners <= self.team:
            return node
        if not owners <= self.team | self.runs.keys():
            return _TRUE
        kept = tuple((s, v) for s, v in node.terms if s.owner in self.team)
        last = self.mission.horizon - max(_late(s) for s, _ in node.terms)
        cases: list[Node] = []
        for t in range(last + 1):
            constant = (
                node.constant
                + sum(v * self._value(s, t) for s, v in node.terms if s.owner in self.runs)
                - self._tubes.off(node.terms, t)
            )
            fine = Const(constant >= margin - _MISS)
            bare = replace(node, swept=None, norms=None)
            cases.append(replace(bare, terms=kept, constant=constant) if kept else fine)
        return self._timed(cases)

    def _value(self, signal: Signal, step: int) -> float:
        run = self.runs[signal.owner][0 if signal.role is Role.STATE else 1]
        return float(run[step + signal.shift, signal.index])

    def _timed(self, cases: list[Node]) -> Node:
        """Case by case up to the last step at which the predicate can be judged."""
        if len(cases) <= self.mission.horizon:
            agent = min(self.team)
            end = Signal(agent, Role.STATE, 0, self.mission.horizon + 1 - len(cases))
            cases = [*cases, Linear(((end, 1.0),), 0.0)]
        return Timed(tuple(cases))

    def _link(self, link: Link, table: Floats, margin: float) -> Node:
        """A predicate of robustness `table` over the cells of the moving ends."""
        ends = (link.sender, link.receiver)
        if not self._moving(named(link)) <= self.team | self.runs.keys():
            return _TRUE
        if not any(name in self.runs for name in ends):
            return self._over_cells(link, ends, table, ())
        cases: list[Node] = []
        for t in range(self.mission.horizon + 1 - link.shift):
            cells = self._cells(link.channel, ends, t + link.shift)
            if any(name in self.team for name in ends):
                cases.append(self._over_cells(link, ends, table, cells))
            else:
                cases.append(Const(bool(_seen(table, cells, np.max) >= margin - _MISS)))
        return self._timed(cases)

    def _over_cells(
        self, link: Link, ends: tuple[str, str], table: Floats, cells: tuple[Ints | None, ...]
    ) -> Node:
        row = _seen(table, cells, np.max)
        channel, pair = self._channel(link.channel, ends, row)
        return Link(
            channel, Quantity.COST, *pair, Relation.AT_LEAST, 0.0, shift=link.shift, span=link.span
        )

    def _cells(self, channel: str, ends: tuple[str, str], step: int) -> tuple[Ints | None, ...]:
        """For each moving end the cells that it touches at a step, None for one that is free."""
        return tuple(
            self._touched(channel, name, step) if name in self.runs else None
            for name in ends
            if name in self.team or name in self.runs
        )

    def _touched(self, channel: str, name: str, step: int) -> Ints:
        space = self.mission.agents[name].dynamics.space
        assert space is not None, "whoever has a link is somewhere"
        partition = self.mission.channels[channel].partition
        point = (space @ self.runs[name][0][step])[: partition.axes]
        return np.asarray(partition.touching(point, point), dtype=np.int64)

    def _moving(self, names: Iterable[str]) -> frozenset[str]:
        return frozenset(name for name in names if name in self.mission.agents)

    def _channel(
        self, channel: str, ends: tuple[str, str], table: Floats
    ) -> tuple[str, tuple[str, str]]:
        """A channel whose cost is a table over the cells of the free ends, and its pair."""
        pair = tuple(self._end(name) for name in ends)
        key = (channel, pair, table.tobytes())
        if key not in self._known:
            name = self._known[key] = f"{channel} {len(self.channels)}"
            partition = self.mission.channels[channel].partition
            both = (pair[0], pair[1])
            self.channels[name] = Channel(name, partition, tables={both: table})
        return self._known[key], (pair[0], pair[1])

    def _end(self, name: str) -> str:
        """The free end itself; a station in place of a held one, wherever it may be."""
        if name not in self.runs:
            return name
        stand_in = f"{name} held"
        self.stations.setdefault(stand_in, Station(stand_in, np.zeros(2)))
        return stand_in

    def objective(self) -> Iterator[ObjectiveTerm]:
        """Effort of the free agents, and the cost of their links among themselves, to stations
        and to held agents."""
        for term in self.mission.objective:
            if term.kind is TermKind.ROBUSTNESS or term.weight == 0:
                continue
            weight = term.weight / static_range(self.mission, term, self.tables)
            plain = replace(term, weight=weight, normalised=False)
            if term.kind is TermKind.EFFORT:
                names = tuple(n for n in term.agents or self.mission.agents if n in self.team)
                if names:
                    yield replace(plain, agents=names)
                continue
            for pair in term.pairs:
                yield from self._link_costs(plain, pair)

    def _link_costs(self, term: ObjectiveTerm, pair: tuple[str, str]) -> Iterator[ObjectiveTerm]:
        """Costs between team and held agents: a term a step, over the held one's cells then."""
        moving = self._moving(pair)
        if self.team.isdisjoint(moving) or not moving <= self.team | self.runs.keys():
            return
        assert term.channel is not None, "every link cost names its channel"
        table = self.tables.cost(term.channel, pair)
        if moving <= self.team:
            channel, ends = self._channel(term.channel, pair, table)
            yield replace(term, channel=channel, pairs=(ends,))
            return
        first, last = term.window or (0, self.mission.horizon)
        for t in range(max(first, 1), last + 1):
            row = _seen(table, self._cells(term.channel, pair, t), np.min)
            channel, ends = self._channel(term.channel, pair, row)
            yield replace(term, channel=channel, pairs=(ends,), window=(t, t))


def _late(signal: Signal) -> int:
    return signal.shift + (1 if signal.role is Role.INPUT else 0)


def _seen(table: Floats, cells: tuple[Ints | None, ...], best: Callable[..., Floats]) -> Floats:
    """The best of a table over the touched cells of held ends; axes of free ends stay."""
    for axis in reversed(range(len(cells))):
        own = cells[axis]
        if own is not None:
            table = best(np.take(table, own, axis=axis), axis=axis)
    return np.asarray(table, dtype=np.float64)
