"""The mission that is left: an ordinary one, whose step 0 is now.

Formulas are progressed over what happened, obstacles are where they are by now, windows of costs
begin earlier, and costs that are spent are left out. Every plan of it, joined to the past, has on
the whole mission the robustness and the violations that it has here.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import TypeVar

import numpy as np

from stlc.arrays import Floats
from stlc.channels import ChannelTables
from stlc.charges import Charge, Form
from stlc.ir.nodes import And, Const, Linear, Node, Or, Role, Signal
from stlc.mission import Mission, ObjectiveTerm, TermKind
from stlc.passes.horizon import last_steps
from stlc.places import Obstacle, Outline, Track
from stlc.plan import Plan, make_plan
from stlc.preferences import Preference
from stlc.renew.past import Past
from stlc.renew.progression import Progression
from stlc.scales import static_range
from stlc.verify.link_models import CellModel, TrueModel
from stlc.verify.requirements import swept_override
from stlc.verify.robots import heading_at
from stlc.verify.robustness import Evaluator
from stlc.verify.shapes import Body
from stlc.verify.subject import make_subject
from stlc.verify.trace import Trace

_TOLERANCE = 1e-6
T = TypeVar("T")


@dataclass(frozen=True, slots=True)
class Lost:
    """A requirement that the past has broken: what it is worth and the margin it had to reach."""

    name: str
    robustness: float
    margin: float

    def __str__(self) -> str:
        return f"{self.name} is lost: {self.robustness:.6g} < margin {self.margin:g} by now"


@dataclass(frozen=True, slots=True, eq=False)
class Remaining:
    """What is left of a mission; `done` hold whatever comes, `lost` cannot hold any more (what
    they ask for from now on is still asked for)."""

    mission: Mission
    done: tuple[str, ...]
    lost: tuple[Lost, ...]


def remaining(mission: Mission, past: Past) -> Remaining:
    """The mission that is left after `past`; links of the past are judged where agents were."""
    progression = _progression(mission, past)
    done, lost, requirements = [], [], []
    for requirement in mission.requirements:
        left, worth = _split(progression.of(requirement.formula), requirement.margin)
        if worth is not None:
            lost.append(Lost(requirement.name, worth, requirement.margin))
        elif _is_met(left, requirement.margin):
            done.append(requirement.name)
        requirements.append(replace(requirement, formula=left))
    left_over = replace(
        _started(mission, past),
        horizon=mission.horizon - past.step,
        obstacles={n: _later(o, past.step, mission.step) for n, o in mission.obstacles.items()},
        requirements=tuple(requirements),
        preferences=tuple(_preference(p, progression) for p in mission.preferences),
        objective=tuple(_terms(mission, past.step)),
        caps=(),
    )
    return Remaining(left_over, tuple(done), tuple(lost))


def _started(mission: Mission, past: Past) -> Mission:
    """With agents that begin where they were measured, by the laws from now on, robots with the
    heading that was measured, or that their controller has given them on the way."""
    agents = {
        name: replace(agent, start=past.states[name][-1], dynamics=agent.dynamics.since(past.step))
        for name, agent in mission.agents.items()
    }
    runs = _as_plan(replace(mission, horizon=past.step), past).runs
    for name, agent in mission.agents.items():
        if agent.robot is not None:
            heading = heading_at(agent.robot, runs[name], mission.step)
            agents[name] = replace(agents[name], robot=replace(agent.robot, heading=heading))
    return replace(mission, agents=agents)


def _progression(mission: Mission, past: Past) -> Progression:
    """Progression over what happened, as the verifier judges it."""
    judge = _judge(mission, past)
    formulas = (
        *(r.formula for r in mission.requirements),
        *(f for p in mission.preferences for f in (p.formula, *p.parts)),
    )

    def known(node: Node, step: int) -> float | None:
        values = judge.robustness(node)
        return float(values[step]) if step < len(values) else None

    def value(signal: Signal, step: int) -> float:
        kind = past.states if signal.role is Role.STATE else past.inputs
        return float(kind[signal.owner][step, signal.index])

    last = last_steps(formulas, mission.horizon)
    return Progression(past.step, known, value, last)


def _judge(mission: Mission, past: Past) -> Evaluator:
    """What predicates were worth: on samples, `swept` ones by the motion between them, links at
    the positions where agents were; before the first step as the verifier has them, by cells."""
    so_far = replace(mission, horizon=past.step)
    plan = _as_plan(so_far, past)
    subject = make_subject(so_far, plan, ChannelTables(so_far))
    cells = CellModel(subject)
    links = TrueModel(subject, cells) if past.step else cells
    trace = Trace(past.step + 1, subject.signals, links.robustness)
    return Evaluator(trace, swept_override(so_far, plan.runs, past.step) if past.step else _unknown)


def _unknown(node: Node) -> Floats | None:
    """Before the first step nothing is known of how anything moves between steps."""
    return None if node.swept is None else np.empty(0)


def _as_plan(mission: Mission, past: Past) -> Plan:
    plan = make_plan(mission, past.states, past.inputs)
    known = past.headings
    return replace(
        plan, runs={n: replace(r, headings=known.get(n, {})) for n, r in plan.runs.items()}
    )


def _split(formula: Node, margin: float) -> tuple[Node, float | None]:
    """What is left to ask for, and what the conjuncts are worth that the past has broken."""
    args = formula.args if isinstance(formula, And) else (formula,)
    broken = [_worth(a) for a in args if _worth(a) < margin - _TOLERANCE]
    if not broken:
        return formula, None
    kept = tuple(a for a in args if not _worth(a) < margin - _TOLERANCE)
    left: Node = Linear((), margin) if not kept else And(kept, span=formula.span)
    return (kept[0] if len(kept) == 1 else left), min(broken)


def _worth(node: Node) -> float:
    """Of a constant; nan of anything that is open."""
    match node:
        case Const(value=value):
            return np.inf if value else -np.inf
        case Linear(terms=(), constant=constant):
            return constant
    return np.nan


def _is_met(node: Node, margin: float) -> bool:
    """Whether a formula reaches the margin whatever comes."""
    if isinstance(node, Or):
        return any(_is_met(arg, margin) for arg in node.args)
    if isinstance(node, And):
        return all(_is_met(arg, margin) for arg in node.args)
    return _worth(node) >= margin - _TOLERANCE


def _preference(p: Preference, progression: Progression) -> Preference:
    parts = tuple(progression.of(part) for part in p.parts)
    return replace(p, formula=progression.of(p.formula), parts=parts)


def _terms(mission: Mission, now: int) -> Iterator[ObjectiveTerm]:
    """Costs that are still to come, normalised by the ranges of the whole mission."""
    tables = ChannelTables(mission)
    for term in mission.objective:
        if term.kind is TermKind.TOTAL:
            ahead = (c for c in term.charges if c.step >= now)
            yield replace(term, charges=tuple(_recharged(c, now) for c in ahead))
            continue
        scale = static_range(mission, term, tables)
        weighed = replace(term, weight=term.weight / scale, normalised=False)
        if term.window is None:
            yield weighed
        elif term.window[1] >= now:
            first, last = term.window
            yield replace(weighed, window=(max(first - now, 0), last - now))


def _recharged(charge: Charge, now: int) -> Charge:
    """What a step costs, its signals counted from now on."""
    peaks = tuple((f, tuple(_moved_form(x, now) for x in forms)) for f, forms in charge.peaks)
    return Charge(charge.step - now, _moved_form(charge.form, now), peaks)


def _moved_form(form: Form, now: int) -> Form:
    terms = tuple((s._replace(shift=s.shift - now), factor) for s, factor in form.terms)
    return replace(form, terms=terms)


def _later(obstacle: Obstacle, now: int, step: float) -> Obstacle:
    """The obstacle with its frames counted from now on."""
    track = obstacle.track
    return replace(
        obstacle,
        frames=_rest(obstacle.frames, now),
        bodies=_rest(obstacle.bodies, now),
        barrier=_rest(obstacle.barrier, now),
        sweeps=_rest(obstacle.sweeps, now),
        track=None if track is None else _track(track, now, step),
    )


def _rest(frames: tuple[T, ...], now: int) -> tuple[T, ...]:
    return frames[min(now, len(frames) - 1) :] if frames else frames


def _track(track: Track, now: int, step: float) -> Track:
    """Frames from the shape of now on; what carries all along has brought them to their place."""
    by = (track.velocity[0] * now * step, track.velocity[1] * now * step)
    first = Body(track, step).outlines(float(now))
    ahead = tuple(
        (t - now, tuple(_moved(o, by) for o in shape)) for t, shape in track.frames if t > now
    )
    return replace(track, frames=((0, first), *ahead))


def _moved(outline: Outline, by: tuple[float, float]) -> Outline:
    rings = [
        tuple((x + by[0], y + by[1]) for x, y in ring) for ring in (outline.ring, *outline.holes)
    ]
    return Outline(rings[0], tuple(rings[1:]))
