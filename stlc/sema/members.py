"""Signals of agents: `r1.vx`, `r1.x`, `r1.u[0]`, `uav[2]`."""

from __future__ import annotations

from stlc.ir.nodes import Role, Signal
from stlc.mission import Agent, Array, Station
from stlc.sema.deliveries import windowed
from stlc.sema.name_errors import NoPosition, UnknownMember, WrongKind
from stlc.sema.report import Mistake, suggested_fix, suggestion
from stlc.sema.scope import Scope
from stlc.sema.unit_errors import WrongUnit
from stlc.sema.units import METRE, Unit, parse_unit
from stlc.sema.values import Delivery, Env, Items, Members, Place, Radio, Scalar, Value, describe
from stlc.source import Span
from stlc.syntax import ast


def attribute(expr: ast.Attribute, env: Env, scope: Scope) -> Value:
    """A signal of an agent, or a coordinate of a station."""
    base = scope.value(expr.base, env)
    name, span = expr.attr.text, expr.attr.span
    match base:
        case Radio(thing=Agent() as agent):
            return agent_member(agent, name, span)
        case Radio(thing=Station() as station):
            if name in AXES:
                return Scalar(float(station.place[AXES.index(name)]), unit=METRE)
            owner = f"station `{station.name}`"
            raise Mistake(_unknown(owner, name, list(AXES), span))
    raise Mistake(_unknown(describe(base), name, [], span))


def agent_member(agent: Agent, name: str, span: Span) -> Value:
    """The signal of that name."""
    dynamics = agent.dynamics
    if name in dynamics.states:
        return state(agent, dynamics.states.index(name))
    if name in dynamics.inputs:
        return control(agent, dynamics.inputs.index(name))
    if name in dynamics.outputs:
        return output(agent, name)
    axes = axes_of(agent)
    if name == "position" and axes:
        return Items(place(agent, span)[: len(axes)], "tuple")
    if name in axes:
        return _coordinate(agent, axes.index(name))
    if name == "state":
        return Members(tuple(state(agent, k) for k in range(len(dynamics.states))))
    if name == "u":
        return Members(tuple(control(agent, k) for k in range(len(dynamics.inputs))))
    if name in ("v", "velocity") and dynamics.velocity is not None:
        return Members(tuple(state(agent, k) for k in dynamics.velocity))
    known = [*dynamics.states, *dynamics.inputs, *dynamics.outputs, "u", "state"]
    known += axes
    raise Mistake(_unknown(f"agent `{agent.name}`", name, known, span))


def _unknown(owner: str, name: str, known: list[str], span: Span) -> UnknownMember:
    listed = ", ".join(f"`{k}`" for k in known)
    otherwise = f"it has {listed}" if known else "only agents and stations have members"
    hint = suggestion(name, known, otherwise)
    fix = suggested_fix(span, name, known)
    return UnknownMember(span=span, owner=owner, name=name, hint=hint, fix=fix)


def unit_of(text: str) -> Unit | None:
    """The unit of a signal, as `Dynamics` spells it ('' fits everything)."""
    return parse_unit(text).unit if text else None


def state(agent: Agent, index: int) -> Scalar:
    """One state."""
    signal = Signal(agent.name, Role.STATE, index)
    return Scalar(terms=((signal, 1.0),), unit=unit_of(agent.dynamics.state_units[index]))


def control(agent: Agent, index: int) -> Scalar:
    """One input."""
    signal = Signal(agent.name, Role.INPUT, index)
    return Scalar(terms=((signal, 1.0),), unit=unit_of(agent.dynamics.input_units[index]))


def output(agent: Agent, name: str) -> Scalar:
    """c'x + d'u + constant."""
    c, d, constant, unit = agent.dynamics.outputs[name]
    terms = (*_row(agent, Role.STATE, c), *_row(agent, Role.INPUT, d))
    return Scalar(constant, terms, unit=unit_of(unit))


def _row(agent: Agent, role: Role, row: Array) -> tuple[tuple[Signal, float], ...]:
    return tuple((Signal(agent.name, role, k), row.item(k)) for k in row.nonzero()[0].tolist())


AXES = "xyz"
Place3 = tuple[Scalar, Scalar, Scalar]
"""Coordinates [m]: x, y, height."""


def axes_of(thing: Agent | Station) -> list[str]:
    """Coordinates that are its signals: none, x and y, or these and z."""
    if isinstance(thing, Station):
        return list(AXES)
    if thing.dynamics.position is None:
        return []
    return list(AXES if thing.dynamics.altitude is not None else AXES[:2])


def place(thing: Agent | Station, span: Span) -> Place3:
    """Where it is; an agent without a height is at 0. Raises Mistake if it is nowhere."""
    if isinstance(thing, Station):
        x, y, z = (Scalar(float(c), unit=METRE) for c in thing.place)
        return x, y, z
    if thing.dynamics.position is None:
        raise Mistake(NoPosition(span=span, name=thing.name))
    return _coordinate(thing, 0), _coordinate(thing, 1), _coordinate(thing, 2)


def _coordinate(agent: Agent, axis: int) -> Scalar:
    """x, y or the height of an agent that is somewhere."""
    dynamics = agent.dynamics
    assert dynamics.position is not None
    row = dynamics.position[axis] if axis < 2 else dynamics.altitude
    return Scalar(terms=() if row is None else _row(agent, Role.STATE, row), unit=METRE)


def flies(value: Value) -> bool:
    """Whether its height is one of its signals, or given with it as a third coordinate."""
    if isinstance(value, Radio):
        return isinstance(value.thing, Agent) and value.thing.dynamics.altitude is not None
    return isinstance(value, Items) and len(value.items) == 3


def point(value: Value, span: Span) -> tuple[Scalar, ...]:
    """An agent, a station or a tuple as coordinates [m]: three, or two for a tuple of two."""
    if isinstance(value, Radio):
        return place(value.thing, span)
    if isinstance(value, Items) and len(value.items) in (2, 3):
        found = tuple(_metres(i, span) for i in value.items if isinstance(i, Scalar))
        if len(found) == len(value.items):
            return found
    hint = "write `a in region` or `a outside region`" if isinstance(value, Place) else ""
    raise Mistake(
        WrongKind(span=span, expected="an agent or a point", found=describe(value), hint=hint)
    )


def _metres(scalar: Scalar, span: Span) -> Scalar:
    if scalar.unit is not None and scalar.unit != METRE:
        raise Mistake(WrongUnit(span=span, expected="m", found=str(scalar.unit)))
    return scalar


def index(expr: ast.Index, env: Env, scope: Scope) -> Value:
    """A member of a family (by its number) or of a vector of signals (from 0)."""
    base = scope.value(expr.base, env)
    if isinstance(base, Delivery):
        return windowed(base, expr, env, scope)
    if isinstance(base, Members | Items) and len(expr.indices) == 1:
        return _member(base, scope.whole(expr.indices[0], env), expr.span)
    hint = "families `uav[1]` and vectors `r1.u[0]` can be indexed"
    found = describe(base)
    raise Mistake(WrongKind(span=expr.span, expected="something to index", found=found, hint=hint))


def _member(base: Members | Items, number: int, span: Span) -> Value:
    """`base[number]`: the member of that number in a family, counted from 0 elsewhere."""
    if isinstance(base, Items) and base.what == "family":
        for item in base.items:
            if isinstance(item, Radio) and item.name.endswith(f"[{number}]"):
                return item
    elif 0 <= number < len(base.items):
        return base.items[number]
    raise Mistake(
        WrongKind(
            span=span,
            expected=f"one of {len(base.items)} members",
            found=f"number {number}",
            hint="families keep their own numbers, everything else counts from 0",
        )
    )
