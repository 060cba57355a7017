"""Dynamics: named integrators, or matrices; continuous ones are discretised (zero-order hold)."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from stlc.dynamics import Dynamics, Flow, Law
from stlc.ir.nodes import Role, Signal
from stlc.mission import Array
from stlc.sema import props
from stlc.sema.compare import unit_name
from stlc.sema.discretise import discretised
from stlc.sema.files import Files
from stlc.sema.flow import held_flow
from stlc.sema.integrators import named
from stlc.sema.laws import given_laws
from stlc.sema.members import unit_of
from stlc.sema.name_errors import Redeclared, UnknownName
from stlc.sema.report import Mistake, suggested_fix, suggestion
from stlc.sema.scope import Scope
from stlc.sema.units import METRE, SPEED, UnknownUnitName, parse_unit
from stlc.sema.values import Env, Scalar, Value
from stlc.syntax import ast

STRUCTURE = (
    "A", "B", "c", "laws", "continuous", "straight", "states", "inputs", "state_units",
    "input_units", "position", "velocity", "output", "outputs", "dimensions",
)  # fmt: skip
_UNNAMED = re.compile(r"[xu]\d+|[pvu][xyz]")  # states and inputs that nobody named


def dynamics(
    statement: ast.DynamicsDecl, properties: Sequence[ast.Property], scope: Scope, files: Files
) -> Dynamics:
    """The dynamics that a declaration means. Raises Mistake."""
    plain, outputs = split_outputs(properties)
    owner = f"dynamics `{statement.name.text}`"
    structure = [item for item in plain if item.key.text in STRUCTURE]
    block = props.block(owner, structure, STRUCTURE, scope)
    rest = [item for item in plain if item.key.text not in STRUCTURE]
    bounds = [item for item in rest if _may_be_named(item.key.text, block)]
    _report_unknown(owner, [item for item in rest if item not in bounds], (), scope)
    if statement.kind is None:
        base = from_matrices(statement, block, scope, files)
    else:
        base = named(statement.kind, block, scope)
    _report_unknown(owner, bounds, (*base.states, *base.inputs), scope)
    return with_outputs(base, outputs, scope)


def _may_be_named(key: str, block: props.Block) -> bool:
    """Whether a state or input may turn out to have this name: then the property bounds it."""
    given = [item for item in (block.get("states"), block.get("inputs")) if item is not None]
    listed = {a.text for item in given for a in _flat(item.args) if isinstance(a, ast.Name)}
    return key in listed or _UNNAMED.fullmatch(key) is not None


def _flat(args: tuple[ast.Expr, ...]) -> tuple[ast.Expr, ...]:
    first = args[0] if args else None
    return first.items if isinstance(first, ast.Tuple | ast.List) else args


def _report_unknown(
    owner: str, items: Sequence[ast.Property], limits: Sequence[str], scope: Scope
) -> None:
    for item in items:
        if item.key.text not in limits:
            scope.report.add(props.unknown_property(owner, item, (*STRUCTURE, *limits)))


def split_outputs(
    properties: Sequence[ast.Property],
) -> tuple[list[ast.Property], list[ast.Property]]:
    """`output s = ..` reads as a bare `output` and an assignment: the latter are the outputs."""
    plain: list[ast.Property] = []
    outputs: list[ast.Property] = []
    after = False
    for item in properties:
        if item.key.text in ("output", "outputs") and not item.args:
            after = True
        elif after and item.assigned and item.key.text not in STRUCTURE:
            outputs.append(item)
        else:
            after = False
            plain.append(item)
    return plain, outputs


# --- matrices ------------------------------------------------------------------------------------


def from_matrices(
    statement: ast.DynamicsDecl, block: props.Block, scope: Scope, files: Files
) -> Dynamics:
    """x(t+1) = A x + B u + c, or x' = A x + B u + c when `continuous`; by step where it varies."""
    given = given_laws(statement, block, scope, files)
    n, m = given[0].B.shape
    first = Flow(given[0].A, given[0].B, given[0].drift)
    flow, straight = _between(block, None if len(given) > 1 else first, scope.step)
    if block.get("continuous") is not None:
        name, span = statement.name.text, block.get("A", "laws")
        where = statement.name.span if span is None else span.span
        given = [
            Law(*discretised(law.A, law.B, law.drift, scope.step, name, where)) for law in given
        ]
    a, b, drift = given[0].A, given[0].B, given[0].drift
    states = _names(block, "states", "x", n)
    inputs = _names(block, "inputs", "u", m, taken=states)
    position = _indices(block, "position", states) or _default(states, ("px", "py", "pz"))
    velocity = _indices(block, "velocity", states) or _default(states, ("vx", "vy", "vz"))
    rows = None if position is None else np.eye(n)[list(position)]
    altitude = None if rows is None or len(rows) == 2 else rows[2]
    return Dynamics(
        statement.name.text,
        a,
        b,
        drift,
        states,
        inputs,
        _units(block, "state_units", states, position, velocity),
        _units(block, "input_units", inputs, None, None),
        None if rows is None else rows[:2],
        velocity,
        flow,
        straight,
        span=statement.name.span,
        altitude=altitude,
        laws=tuple(given) if len(given) > 1 else (),
    )


def _between(block: props.Block, given: Flow | None, dt: float) -> tuple[Flow | None, bool]:
    """What is known of the motion between samples: its flow, or that it is straight. Nothing but
    the latter of what varies."""
    item, continuous = block.get("straight"), block.get("continuous") is not None
    if item is not None and continuous:
        raise props.bad(item, "contradicts `continuous`, which says how it moves", "continuous")
    if item is not None:
        return None, True
    if given is None:
        return None, False
    return (given if continuous else held_flow(given, dt)), False


def _names(
    block: props.Block, key: str, letter: str, count: int, taken: Sequence[str] = ()
) -> tuple[str, ...]:
    """`count` distinct names, or the letter numbered from 0 where the file gives none."""
    item = block.get(key)
    if item is None:
        return tuple(f"{letter}{k}" for k in range(count))
    found = props.names(item, f"{key} px py vx vy")
    texts = tuple(n.text for n in found)
    for k, name in enumerate(found):
        if name.text in (*taken, *texts[:k]):
            raise Mistake(Redeclared(span=name.span, name=name.text))
    if len(texts) != count:
        raise props.bad(item, f"gives {len(texts)} names, the matrices have {count}", f"{key} ..")
    return texts


def _indices(block: props.Block, key: str, states: tuple[str, ...]) -> tuple[int, ...] | None:
    """Indices of the two or three states that `key` names, or None where it isn't given."""
    item = block.get(key)
    if item is None:
        return None
    usage = f"{key} {states[0]} {states[-1]}"
    found = props.names(item, usage)
    for name in found:
        if name.text not in states:
            hint = suggestion(name.text, list(states), f"states are {', '.join(states)}")
            fix = suggested_fix(name.span, name.text, list(states))
            raise Mistake(UnknownName(span=name.span, name=name.text, hint=hint, fix=fix))
    if len(found) not in (2, 3):
        raise props.bad(item, f"needs two states, or three, not {len(found)}", usage)
    return tuple(states.index(name.text) for name in found)


def _default(states: tuple[str, ...], names: tuple[str, ...]) -> tuple[int, ...] | None:
    """Indices of all the names that are states, or of the first two; None where these are none."""
    for wanted in (names, names[:2]):
        if all(n in states for n in wanted):
            return tuple(states.index(n) for n in wanted)
    return None


def _units(
    block: props.Block,
    key: str,
    names: tuple[str, ...],
    position: tuple[int, ...] | None,
    velocity: tuple[int, ...] | None,
) -> tuple[str, ...]:
    """Declared units; else m for the position, m/s for the velocity, nothing for the rest."""
    item = block.get(key)
    if item is None:
        known = {k: str(METRE) for k in position or ()} | {k: str(SPEED) for k in velocity or ()}
        return tuple(known.get(k, "") for k in range(len(names)))
    texts = [a.span.text.strip() for a in item.args]
    if len(texts) != len(names):
        raise props.bad(item, f"gives {len(texts)} units for {len(names)} names", f"{key} m m/s")
    try:
        return tuple(str(parse_unit(t).unit) for t in texts)
    except UnknownUnitName as error:
        raise props.bad(item, f"has the unknown unit `{error.name}`", f"{key} m m/s") from None


# --- outputs -------------------------------------------------------------------------------------


def with_outputs(base: Dynamics, outputs: Sequence[ast.Property], scope: Scope) -> Dynamics:
    """The dynamics with further named linear signals."""
    if not outputs:
        return base
    props.distinct([item.key for item in outputs])
    env = Env(_signals(base))
    found = {item.key.text: _output(base, item, env, scope) for item in outputs}
    return replace(base, outputs=found)


def _signals(base: Dynamics) -> dict[str, Value]:
    bound: dict[str, Value] = {}
    for role, texts, units in (
        (Role.STATE, base.states, base.state_units),
        (Role.INPUT, base.inputs, base.input_units),
    ):
        for k, text in enumerate(texts):
            bound[text] = Scalar(terms=((Signal("", role, k), 1.0),), unit=unit_of(units[k]))
    return bound


def _output(
    base: Dynamics, item: ast.Property, env: Env, scope: Scope
) -> tuple[Array, Array, float, str]:
    """The row c, d, constant and unit of an output y = c x + d u + constant."""
    usage = f"output {item.key.text} = {base.states[0]}"
    scalar = scope.scalar(props.only(item, usage), env)
    if scalar.folds:
        raise props.bad(item, "must be linear in the states and inputs", usage)
    c, d = np.zeros(len(base.states)), np.zeros(len(base.inputs))
    for atom, coefficient in scalar.terms:
        if not isinstance(atom, Signal) or atom.owner:
            raise props.bad(item, "may use the agent's own states and inputs only", usage)
        (c if atom.role is Role.STATE else d)[atom.index] = coefficient
    return c, d, scalar.constant, unit_name(scalar)
