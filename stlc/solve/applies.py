"""Where each strategy may run: cheap questions to the work as it stands, by structure alone.

They stand apart from the searches, so that no search is imported that does not run.
"""

from __future__ import annotations

import numpy as np

from stlc.backends.base import Capability
from stlc.ir.networks import Count, Network
from stlc.ir.nodes import walk
from stlc.mission import TermKind
from stlc.solve import tuning
from stlc.solve.strategy import LIMITED, Work


def is_small(work: Work) -> bool:
    """`brief`: a team whose plain solve mostly ends, or has a plan, before any search has."""
    compiled = work.compiled
    small = not compiled.robustness and compiled.model.columns <= tuning.BRIEF.columns
    return _is_team(work) and small and work.can(Capability.TIME_LIMIT)


def may_plan(work: Work) -> bool:
    """`turns`: a team without a plan. Two agents that pay for their link have `links`."""
    known_soon = _is_planned_from_alone(work)
    return _is_costly_team(work) and work.x is None and not known_soon and work.can(LIMITED)


def may_descend(work: Work) -> bool:
    """`descents`: more than two agents that pay for their links, without a plan."""
    many = len(work.compiled.mission.agents) > 2 and work.x is None
    return many and _pays_for_pairs(work) and work.can(LIMITED)


def falls_apart(work: Work) -> bool:
    """`groups`: a team of two groups or more, whose costs add up."""
    mission = work.compiled.mission
    terms = [term for term in mission.objective if term.weight != 0]
    if not _is_team(work) or any(t.kind is TermKind.ROBUSTNESS for t in terms):
        return False
    stations = mission.stations.keys()
    if any(stations >= set(pair) for term in terms for pair in term.pairs):
        return False
    from stlc.solve.teams.couplings import groups_of

    return work.can(LIMITED) and len(groups_of(work.compiled)) > 1


def may_grid(work: Work) -> bool:
    """`grids`: a small team without a plan whose agents all go where their inputs say, for
    effort."""
    names = work.compiled.mission.agents
    if work.x is not None or not 1 < len(names) <= tuning.ROUTES.grid_agents or not _is_open(work):
        return False
    from stlc.solve.routes.loose import fits

    return all(fits(work.compiled, name) for name in names)


def may_route(work: Work) -> bool:
    """`routes`: no plan yet, or one agent alone."""
    late = work.x is not None and _is_team(work)
    return not late and not _is_planned_from_alone(work) and _is_open(work)


def may_box(work: Work) -> bool:
    """`boxes`: one agent that pays for links with stations, over cells of the plane."""
    mission = work.compiled.mission
    if _is_team(work) or not _is_open(work) or TermKind.LINK_COST not in work.kinds:
        return False
    terms = [term for term in mission.objective if term.weight != 0]
    flat = all(channel.partition.axes < 3 for channel in mission.channels.values())
    return flat and all(t.weight > 0 for t in terms) and work.kinds <= {
        TermKind.EFFORT, TermKind.LINK_COST
    }  # fmt: skip


def _is_open(work: Work) -> bool:
    """Open to beams: no robustness to maximise, no links that cost, no networks, agents that are
    somewhere, with bounded states and inputs and no turning rate."""
    compiled = work.compiled
    if compiled.robustness or not work.can(LIMITED) or _pays_for_pairs(work):
        return False
    formulas = (one.formula for one in compiled.layout.encoded)
    if any(isinstance(n, Count | Network) for formula in formulas for n in walk(formula)):
        return False
    return all(_is_movable(work, name) for name in compiled.states)


def _is_planned_from_alone(work: Work) -> bool:
    """Two agents or a crowd without a radio that spend effort alone: what each does by itself is
    mostly near a plan (`neighbourhoods`), and known sooner than one by any other way."""
    mission = work.compiled.mission
    crowd = len(mission.agents) >= tuning.LONE.crowd and not mission.channels
    return (len(mission.agents) == 2 or crowd) and has_lone_runs(work)


def has_lone_runs(work: Work) -> bool:
    """`lone`: a team that minimises nothing but effort, with some time."""
    team = _is_team(work) and work.kinds == {TermKind.EFFORT}
    return team and work.can(LIMITED) and work.deadline.left >= tuning.LONE.least


def may_improve(work: Work) -> bool:
    """`neighbourhoods`: a team with a plan, or with what its agents do alone, that costs effort or
    links; pairs that pay for their link have `links`."""
    known = work.x is not None or bool(work.lone)
    return _is_costly_team(work) and bool(work.kinds) and known and work.can(LIMITED)


def has_parts(work: Work) -> bool:
    """`parts`: more than two agents whose effort alone is known, and not nearly all of a plan's."""
    near = work.x is not None and work.value - work.bound < tuning.PARTS.worth * abs(work.value)
    return has_lone_runs(work) and len(work.lone) > 2 and not near


def may_search_links(work: Work) -> bool:
    """`links`: a team with a radio."""
    return _is_team(work) and bool(work.compiled.mission.channels) and work.can(LIMITED)


def may_dive(work: Work) -> bool:
    """`dive`: the robustness of all requirements is maximised, and no plan is known."""
    return work.x is None and None in work.compiled.robustness


def _is_team(work: Work) -> bool:
    return len(work.compiled.mission.agents) > 1


def _is_costly_team(work: Work) -> bool:
    """A team that maximises no robustness, but for two agents that pay for their link."""
    objective = work.kinds
    pair = len(work.compiled.mission.agents) == 2 and TermKind.LINK_COST in objective
    return _is_team(work) and not pair and TermKind.ROBUSTNESS not in objective


def _pays_for_pairs(work: Work) -> bool:
    """Whether some link between two agents costs."""
    mission = work.compiled.mission
    costs = (term for term in mission.objective if term.kind is TermKind.LINK_COST)
    return any(mission.agents.keys() >= set(pair) for term in costs for pair in term.pairs)


def _is_movable(work: Work, name: str) -> bool:
    """An agent that is somewhere, with bounded states and inputs and no turning rate."""
    agent, ranges = work.compiled.mission.agents[name], work.compiled.ranges[name]
    if agent.dynamics.position is None or agent.turn_rate is not None or not len(agent.input_lower):
        return False
    ends = (ranges.state_lower, ranges.state_upper, agent.input_lower, agent.input_upper)
    return all(bool(np.isfinite(end).all()) for end in ends)
