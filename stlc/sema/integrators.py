"""The named kinds of dynamics: double and single integrators in one to three dimensions, and
robots, whose plans are runs of a single integrator (`stlc/robots.py`)."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from stlc.dynamics import Dynamics, Flow
from stlc.robots import RobotKind
from stlc.sema import props
from stlc.sema.name_errors import UnknownName
from stlc.sema.report import Mistake, suggested_fix, suggestion
from stlc.sema.scope import Scope
from stlc.sema.units import ACCELERATION, METRE, SPEED
from stlc.syntax import ast

ROBOTS = tuple(kind.value for kind in RobotKind)
KINDS = ("double_integrator", "single_integrator", *ROBOTS)
AXES = "xyz"


def named(kind: ast.Ident, block: props.Block, scope: Scope) -> Dynamics:
    """A double or single integrator in one, two or three dimensions, a robot in two."""
    if kind.text not in KINDS:
        hint = suggestion(kind.text, list(KINDS), f"known: {', '.join(KINDS)}, or matrices A, B")
        fix = suggested_fix(kind.span, kind.text, list(KINDS))
        raise Mistake(UnknownName(span=kind.span, name=kind.text, hint=hint, fix=fix))
    item = block.get("dimensions")
    count = 2 if item is None else scope.whole(props.only(item, "dimensions 2"))
    if item is not None and not 1 <= count <= 3:
        raise props.bad(item, "must be 1, 2 or 3", "dimensions 2")
    if item is not None and kind.text in ROBOTS and count != 2:
        raise props.bad(item, f"of a {kind.text} are 2", "dimensions 2")
    make = double_integrator if kind.text == "double_integrator" else single_integrator
    robot = RobotKind(kind.text) if kind.text in ROBOTS else None
    return replace(make(count, scope.step), name=kind.text, robot=robot)


def double_integrator(count: int, dt: float) -> Dynamics:
    """p'' = u, discretised exactly: p + dt v + dt^2/2 u, v + dt u."""
    eye, zero = np.eye(count), np.zeros((count, count))
    axes = AXES[:count]
    return Dynamics(
        "double_integrator",
        A=np.block([[eye, dt * eye], [zero, eye]]),
        B=np.vstack([dt**2 / 2.0 * eye, dt * eye]),
        drift=np.zeros(2 * count),
        states=tuple(f"p{a}" for a in axes) + tuple(f"v{a}" for a in axes),
        inputs=tuple(f"u{a}" for a in axes),
        state_units=(str(METRE),) * count + (str(SPEED),) * count,
        input_units=(str(ACCELERATION),) * count,
        position=np.eye(2, 2 * count) if count >= 2 else None,
        velocity=tuple(range(count, 2 * count)) if count >= 2 else None,
        altitude=np.eye(2 * count)[2] if count == 3 else None,
        flow=Flow(
            np.block([[zero, eye], [zero, zero]]), np.vstack([zero, eye]), np.zeros(2 * count)
        ),
    )


def single_integrator(count: int, dt: float) -> Dynamics:
    """p' = u, discretised exactly: p + dt u."""
    axes = AXES[:count]
    return Dynamics(
        "single_integrator",
        A=np.eye(count),
        B=dt * np.eye(count),
        drift=np.zeros(count),
        states=tuple(f"p{a}" for a in axes),
        inputs=tuple(f"u{a}" for a in axes),
        state_units=(str(METRE),) * count,
        input_units=(str(SPEED),) * count,
        position=np.eye(2, count) if count >= 2 else None,
        altitude=np.eye(count)[2] if count == 3 else None,
        flow=Flow(np.zeros((count, count)), np.eye(count), np.zeros(count)),
    )
