"""Objective terms as columns and coefficients.

    effort      sum_{t >= 1} q'|x_t| + sum_{t <= T-1} r'|u_t|: for each entry whose range crosses 0
                a column s >= 0 with s >= y and s >= -y; y or -y itself where the sign is known
    link cost   see `stlc.milp.tables`
    robustness  the column of its goal
    total       see `stlc.milp.totals`

`normalised` divides a cost by the width of its static range (`stlc.scales`).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from stlc.analysis.goals import Goal
from stlc.analysis.link_tables import LinkTables
from stlc.arrays import Floats, Ints
from stlc.errors import UsageError
from stlc.milp.context import Context
from stlc.milp.model import Origin
from stlc.milp.totals import add_total
from stlc.mission import Agent, ObjectiveTerm, TermKind
from stlc.scales import static_range


@dataclass(frozen=True, slots=True, eq=False)
class _Entries:
    """Weighted columns of an effort: cols (k,), weights (k,) >= 0, lower and upper (k,)."""

    cols: Ints
    weights: Floats
    lower: Floats
    upper: Floats


def add_objective(ctx: Context, tables: LinkTables, encoding: str) -> tuple[str, ...]:
    """Add every cost term; returns remarks on the encodings that were chosen."""
    notes: list[str] = []
    for term in ctx.mission.objective:
        ctx.builder.origin = Origin(f"objective {term.kind.value}", term.span)
        match term.kind:
            case TermKind.EFFORT | TermKind.LINK_COST:
                notes += _add_cost(ctx, term, tables, encoding)
            case TermKind.TOTAL:
                add_total(ctx, term)
            case TermKind.ROBUSTNESS | TermKind.VIOLATION:
                continue  # its column carries the weight; violations were lowered
    return tuple(notes)


def _add_cost(ctx: Context, term: ObjectiveTerm, tables: LinkTables, encoding: str) -> list[str]:
    """Add what effort or links cost; remarks on the encodings that were chosen."""
    if term.kind is TermKind.LINK_COST:
        return list(_add_link_cost(ctx, term, tables, encoding))
    _add_effort(ctx, term, tables)
    return []


def add_caps(
    ctx: Context, rho: Mapping[Goal, int], tables: LinkTables, encoding: str
) -> tuple[str, ...]:
    """Add a row for each cap: its costs, encoded as those of the objective, add up to no more."""
    notes: list[str] = []
    for cap in ctx.mission.caps:
        ctx.builder.begin_sum()
        for term in cap.terms:
            ctx.builder.origin = Origin(f"cap on {cap.name}", term.span)
            match term.kind:
                case TermKind.EFFORT | TermKind.LINK_COST:
                    notes += _add_cost(ctx, term, tables, encoding)
                case TermKind.TOTAL:
                    add_total(ctx, term)
                case TermKind.ROBUSTNESS:
                    goal = next(g for g in rho if g.is_of(term))
                    ctx.builder.add_cost([rho[goal]], [term.weight])
                case TermKind.VIOLATION:
                    raise AssertionError("violations are lowered before anything is encoded")
        ctx.builder.end_sum("cap", cap.limit)
    return tuple(notes)


def reserve_link_costs(ctx: Context, tables: LinkTables, encoding: str) -> None:
    """Let link costs be the first users of the cell columns that the encodings share."""
    if encoding not in ("auto", "unary", "lifted"):
        return
    from stlc.milp.tables import reserve_link_cost

    for term in ctx.mission.objective:
        if term.kind is not TermKind.LINK_COST or term.channel is None or term.weight == 0:
            continue
        channel = ctx.mission.channels[term.channel]
        for pair in term.pairs:
            table = tables.cost(channel, pair)
            reserve_link_cost(ctx, channel, pair, table, _steps(ctx, term))


def _steps(ctx: Context, term: ObjectiveTerm) -> range:
    """Steps at which a link cost counts."""
    first, last = _window(ctx, term)
    return range(max(first, 1), last + 1)


def _window(ctx: Context, term: ObjectiveTerm) -> tuple[int, int]:
    return term.window if term.window is not None else (0, ctx.mission.horizon)


def _add_effort(ctx: Context, term: ObjectiveTerm, tables: LinkTables) -> None:
    first, last = _window(ctx, term)
    agents = [ctx.agent(name) for name in term.agents or ctx.mission.agents]
    weight = term.weight / static_range(ctx.mission, term, tables.channels)
    for agent in agents:
        for part in _agent_entries(ctx, agent, first, last):
            ctx.layout.add_effort(agent.name, _add_absolute(ctx, part, weight))


def _agent_entries(ctx: Context, agent: Agent, first: int, last: int) -> list[_Entries]:
    """Columns of an agent's states and inputs in a window, with weights and ranges."""
    r = ctx.ranges[agent.name]
    states = slice(max(first, 1), last + 1)
    inputs = slice(first, min(last, ctx.mission.horizon - 1) + 1)
    blocks = [
        (ctx.states[agent.name][states], agent.effort_state, r.state_lower[states],
         r.state_upper[states]),
        (ctx.inputs[agent.name][inputs], agent.effort_input, r.input_lower[inputs],
         r.input_upper[inputs]),
    ]  # fmt: skip
    return [_entries(cols, q, low, high) for cols, q, low, high in blocks if cols.size]


def _entries(cols: Ints, weights: Floats, lower: Floats, upper: Floats) -> _Entries:
    spread = np.broadcast_to(weights, cols.shape)
    used = spread != 0
    return _Entries(cols[used], spread[used].astype(float), lower[used], upper[used])


def _add_absolute(ctx: Context, part: _Entries, weight: float) -> Ints:
    """The columns that carry the cost."""
    with np.errstate(over="ignore"):  # `check_magnitudes` tells where
        costs = weight * part.weights
    known = (part.lower >= 0) | (part.upper <= 0)
    signs = np.where(part.lower >= 0, 1.0, -1.0)
    ctx.builder.add_cost(part.cols[known], (signs * costs)[known])
    cols, costs = part.cols[~known], costs[~known]
    if not len(cols) or weight == 0:
        return part.cols[known]
    if weight < 0:
        raise UsageError("effort can be minimised, not maximised: give it a positive weight")
    top = np.maximum(-part.lower, part.upper)[~known]
    size = ctx.builder.add_columns("abs", (len(cols),), 0.0, top)
    ctx.builder.add_cost(size, costs)
    pairs = np.column_stack([size, cols])
    for sign in (1.0, -1.0):
        ctx.builder.add_dense_rows("abs", pairs, [1.0, sign], 0.0, np.inf)
    return np.concatenate([part.cols[known], size])


def _add_link_cost(
    ctx: Context, term: ObjectiveTerm, tables: LinkTables, encoding: str
) -> Sequence[str]:
    """Add a term's link cost for each of its pairs; a note of the encoding chosen for each."""
    from stlc.milp.tables import add_link_cost

    assert term.channel is not None, "semantic analysis names the channel of every link cost"
    channel = ctx.mission.channels[term.channel]
    weight = term.weight / static_range(ctx.mission, term, tables.channels)
    notes = []
    for pair in term.pairs:
        table = tables.cost(channel, pair)
        choice = add_link_cost(ctx, channel, pair, table, _steps(ctx, term), weight, encoding)
        notes.append(f"link cost of {pair[0]}, {pair[1]}: {choice.encoding.name}, {choice.reason}")
    return notes
