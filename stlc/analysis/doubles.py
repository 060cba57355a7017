"""States that grow beyond what doubles can hold: a located error, never 'infeasible'."""

from __future__ import annotations

from typing import ClassVar

import numpy as np

from stlc.arrays import Floats
from stlc.diagnostics import Diagnostic
from stlc.errors import MissionError
from stlc.mission import Agent

WHOLE = 2.0**53
"""From here on doubles skip whole units: no bound on a state says anything."""

COARSE = 2.0**31
"""From here on four roundings are worth more than the 1e-6 to which requirements are judged."""


class LostRange(Diagnostic):
    """A state can grow beyond what doubles can hold, and nothing bounds it.

    x(t+1) = A x(t) + B u(t) multiplies by A at every step, so where A has an eigenvalue above 1 a
    state and every rounding in it grow exponentially. Requirements are judged to within 1e-6,
    which doubles resolve up to 2^31 (2.1e9).
    """

    code: ClassVar[str] = "E0803"
    title: ClassVar[str] = "`{name}` of agent `{agent}` can be {value:.3g} at step {step}"
    label: ClassVar[str] = "doubles are {spacing:.2g} apart there, and 1e-06 is judged"
    help: ClassVar[str] = (
        "bound the state (`{name} in [-100, 100]`), shorten the horizon, or check the dynamics"
    )
    name: str
    agent: str
    step: int
    value: float
    spacing: float


class RangeLost(MissionError):
    """The mission can't be analysed in doubles; nothing is said of its feasibility."""


def check_held(
    agent: Agent, step: int, declared: Floats, reached: Floats, *, bounded_inputs: bool
) -> None:
    """Raise RangeLost where the states at a step grow beyond what doubles can hold.

    `declared` (2, n) are the states' lower and upper bounds, `reached` (2, n) what the dynamics
    alone allow: infinite for a good reason only where inputs are unbounded.
    """
    low = np.fmax(declared[0], reached[0])
    high = np.fmin(declared[1], reached[1])
    coarse = (low <= high) & ((low > COARSE) | (high < -COARSE))
    grown = np.isnan(reached) | (np.isfinite(reached) & (np.abs(reached) > WHOLE))
    if bounded_inputs:
        grown |= np.isinf(reached)
    lost = coarse | ((low <= high) & (grown & (np.abs(declared) > WHOLE)).any(axis=0))
    if lost.any():
        raise RangeLost([_diagnostic(agent, step, int(lost.argmax()), reached)])


def check_products(
    agent: Agent, states: tuple[Floats, Floats], inputs: tuple[Floats, Floats]
) -> None:
    """Raise RangeLost where a step from finite ends overflows.

    `states` (T+1, n) and `inputs` (T, m) are lower and upper ends.
    """
    x, u = (np.fmax(*(finite_size(end) for end in ends)) for ends in (states, inputs))
    with np.errstate(over="ignore"):
        A, B, drift = (np.abs(part) for part in agent.dynamics.over(len(u)))
        size = np.einsum("tij,tj->ti", A, x[:-1]) + np.einsum("tij,tj->ti", B, u) + drift
    broken = ~np.isfinite(size)
    if broken.any():
        step, index = np.unravel_index(int(broken.argmax()), broken.shape)
        reached = np.full((2, size.shape[1]), np.inf)
        raise RangeLost([_diagnostic(agent, int(step) + 1, int(index), reached)])


def finite_size(values: Floats) -> Floats:
    """Absolute values, 0 for what is infinite or NaN: what a rounding error is measured by."""
    return np.where(np.isfinite(values), np.abs(values), 0.0)


def _diagnostic(agent: Agent, step: int, index: int, reached: Floats) -> LostRange:
    """The error that names the state's greatest value and how far apart doubles lie there."""
    sizes = np.where(np.isnan(reached[:, index]), np.inf, reached[:, index])
    value = float(sizes[np.abs(sizes).argmax()])
    return LostRange(
        span=agent.span,
        name=agent.dynamics.states[index],
        agent=agent.name,
        step=step,
        value=value,
        spacing=float(np.spacing(abs(value))) if np.isfinite(value) else float("inf"),
    )
