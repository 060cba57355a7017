"""Each agent alone: dynamics, start, bounds, norms, turning rate, integers."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace

import numpy as np

from stlc.mission import Agent, NormBound, PolygonKind
from stlc.plan import Run
from stlc.source import Span
from stlc.verify.report import Violation
from stlc.verify.subject import TOLERANCE, Array, Subject
from stlc.verify.tubes import half_widths

Describe = Callable[[int, int], str]


def motion_violations(subject: Subject) -> Iterator[Violation]:
    """Every condition on an agent alone that is broken, each once, at its worst step.

    What was carried out already is as it was measured: states are judged after it.
    """
    past = subject.plan.executed
    for name, agent in subject.mission.agents.items():
        run = subject.plan.runs[name]
        ahead = replace(run, states=run.states[past:], inputs=run.inputs[past:])
        yield from _dynamics(agent, ahead, past)
        if not past:
            yield from _start(agent, run)
        room = half_widths(agent, subject.mission.horizon - past)
        yield from _bounds(agent, run, past, room)
        yield from _integers(agent, ahead, past)
        first = 1 if past else 0
        states, inputs = ahead.states[first:], ahead.inputs
        if room is not None:  # the corner of the tube that is furthest out
            states, inputs = np.abs(states) + room[0][first:], np.abs(inputs) + room[1]
        for bound in agent.state_norms:
            yield from _norm(agent, bound, states, run.state_names, past + first)
        for bound in agent.input_norms:
            yield from _norm(agent, bound, inputs, run.input_names, past)
        yield from _turn_rate(agent, ahead, past)


def residual(agent: Agent, run: Run, first: int = 0) -> Array:
    """|x(t+1) - A_t x(t) - B_t u(t) - drift_t| (T, n) of a run that begins at step `first`."""
    model, predicted = agent.dynamics, np.empty_like(run.states[1:])
    with np.errstate(over="ignore", invalid="ignore"):  # NaN is as far off as infinity
        for t, (x, u) in enumerate(zip(run.states[:-1], run.inputs, strict=True)):
            law = model.law(first + t)
            predicted[t] = law.A @ x + law.B @ u + law.drift
        gap = np.abs(run.states[1:] - predicted)
    return np.asarray(np.where(np.isnan(gap), np.inf, gap), dtype=np.float64)


def _worst(
    excess: Array,
    allowed: Array | float,
    kind: str,
    agent: Agent,
    describe: Describe,
    first: int = 0,
    span: Span | None = None,
) -> Iterator[Violation]:
    """At most one violation: the largest of `excess` (steps, width) where it passes `allowed`."""
    excess = np.where(np.isnan(excess), np.inf, excess)  # infinite on both sides: not as it should
    excess = np.where(excess > allowed, excess, -np.inf)
    if not excess.size or excess.max() == -np.inf:
        return
    step, column = np.unravel_index(int(np.argmax(excess)), excess.shape)
    amount = float(excess[step, column])
    when = int(step) + first
    text = f"{agent.name} at step {when}: {describe(int(step), int(column))}"
    yield Violation(kind, text, amount, float(when), agent.name, span or agent.span)


def _slack(size: Array | float) -> Array:
    return TOLERANCE * np.maximum(1.0, np.abs(size))


def _dynamics(agent: Agent, run: Run, first: int) -> Iterator[Violation]:
    gap = residual(agent, run, first)
    names = agent.dynamics.states

    def describe(step: int, column: int) -> str:
        """How far a state is off its dynamics."""
        return f"{names[column]} doesn't follow from its dynamics (off by {gap[step, column]:.3g})"

    yield from _worst(gap, _slack(run.states[1:]), "dynamics", agent, describe, first + 1)


def _start(agent: Agent, run: Run) -> Iterator[Violation]:
    gap = np.abs(run.states[:1] - agent.start)

    def describe(step: int, column: int) -> str:
        """Where a state starts, and where it should."""
        name, want = agent.dynamics.states[column], agent.start[column]
        return f"{name} is {run.states[0, column]:.6g}, the mission starts it at {want:.6g}"

    yield from _worst(gap, _slack(agent.start), "start", agent, describe)


def _bounds(
    agent: Agent, run: Run, past: int, room: tuple[Array, Array] | None
) -> Iterator[Violation]:
    """States and inputs beyond their bounds, the worst of each bound; `room` is what they may be
    off by on top."""
    early = past + 1 if past else 0  # the state that was measured is none that a plan chose
    states, inputs = run.states[early:], run.inputs[past:]
    off = (0.0 * states, 0.0 * inputs) if room is None else (room[0][early - past :], room[1])
    boxes = (
        ("state bound", states, agent.state_lower, agent.state_upper, run.state_names, early,
         off[0]),
        ("input bound", inputs, agent.input_lower, agent.input_upper, run.input_names, past,
         off[1]),
    )  # fmt: skip
    for kind, nominal, lower, upper, names, first, width in boxes:
        for sign, limit, word in ((1.0, upper, "above"), (-1.0, lower, "below")):
            values = nominal + sign * width

            def describe(
                step: int, column: int, values: Array = values, limit: Array = limit,
                names: tuple[str, ...] = names, word: str = word,
            ) -> str:  # fmt: skip
                """Which value is beyond which bound."""
                value = values[step, column]
                return f"{names[column]} = {value:.6g} is {word} its bound {limit[column]:.6g}"

            finite = np.where(np.isfinite(limit), limit, sign * np.inf)
            slack = _slack(np.where(np.isfinite(limit), limit, 0.0))
            yield from _worst(sign * (values - finite), slack, kind, agent, describe, first)


def _integers(agent: Agent, run: Run, first: int) -> Iterator[Violation]:
    if not agent.integer_inputs:
        return

    def describe(step: int, column: int) -> str:
        """Which input is no integer."""
        return f"{run.input_names[column]} = {run.inputs[step, column]:.9g} is not an integer"

    off = np.abs(run.inputs - np.rint(run.inputs))
    yield from _worst(off, TOLERANCE, "integer input", agent, describe, first)


def _norm(
    agent: Agent, bound: NormBound, values: Array, names: tuple[str, ...], first: int
) -> Iterator[Violation]:
    """Norms above their limits, by the polygon where the mission asks for the outer one."""
    size = norm_measure(bound, values)
    label = " and ".join(names[i] for i in bound.indices)
    shape = "norm" if bound.kind is PolygonKind.INSCRIBED else f"{bound.sides}-sided polygon"

    def describe(step: int, column: int) -> str:
        """Which norm is above which limit."""
        return f"the {shape} of {label} is {size[step]:.6g}, above its limit {bound.limit:.6g}"

    excess = (size - bound.limit)[:, None]
    yield from _worst(excess, _slack(bound.limit), "norm", agent, describe, first, bound.span)


def norm_measure(bound: NormBound, values: Array) -> Array:
    """What a norm bound is judged by (steps,): the Euclidean norm, or for OUTER its polygon."""
    pair = values[:, list(bound.indices)]
    if bound.kind is PolygonKind.INSCRIBED:
        return np.asarray(np.linalg.norm(pair, axis=1), dtype=np.float64)
    angles = 2.0 * np.pi * np.arange(1, bound.sides + 1) / bound.sides
    return np.asarray((pair @ np.array([np.sin(angles), np.cos(angles)])).max(axis=1))


def norm_notes(subject: Subject) -> Iterator[str]:
    """How far an outer polygon lets a norm exceed its limit."""
    for name, agent in subject.mission.agents.items():
        run = subject.plan.runs[name]
        kinds = [(b, run.states[1:]) for b in agent.state_norms]
        for bound, values in kinds + [(b, run.inputs) for b in agent.input_norms]:
            if bound.kind is not PolygonKind.OUTER or not len(values):
                continue
            size = float(np.linalg.norm(values[:, list(bound.indices)], axis=1).max())
            if size > bound.limit + TOLERANCE:
                share = 100.0 * (size / bound.limit - 1.0)
                yield (
                    f"{name}: the outer polygon lets the norm reach {size:.6g}, "
                    f"{share:.2f} % above {bound.limit:.6g}"
                )


def _turn_rate(agent: Agent, run: Run, first: int) -> Iterator[Violation]:
    """||u|| <= (u_max / v_max) ||v|| by the Euclidean formula, or at rest."""
    rate, velocity = agent.turn_rate, agent.dynamics.velocity
    if rate is None or velocity is None:
        return
    force = np.linalg.norm(run.inputs, axis=1)
    speed = np.linalg.norm(run.states[:-1][:, list(velocity)], axis=1)
    excess = force - rate.u_max / rate.v_max * speed
    if not rate.literal:
        excess = np.where(speed <= rate.rest_speed + TOLERANCE, -np.inf, excess)

    def describe(step: int, column: int) -> str:
        """How sharp the turn is, and what the speed allows."""
        allowed = rate.u_max / rate.v_max * speed[step]
        return f"|u| = {force[step]:.6g} turns too sharply at speed {speed[step]:.6g} " + (
            f"(at most {allowed:.6g})"
        )

    yield from _worst(excess[:, None], TOLERANCE, "turn rate", agent, describe, first, rate.span)
