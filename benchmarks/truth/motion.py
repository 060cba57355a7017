"""Where an agent really is: its inputs integrated from its start, and at any time in between.

Closed forms for integrators, the matrix exponential for continuous matrices, and for discrete ones
that of their real logarithm: they are the zero-order hold of one flow that turns little in a step.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from truth.scene import DOUBLE, SINGLE, Array, Body


@dataclass(frozen=True, slots=True)
class Motion:
    """States (T+1, n) that the inputs (T, m) lead to, `step` seconds apart."""

    body: Body
    states: Array
    inputs: Array
    step: float

    def at(self, k: int, s: Array) -> Array:
        """Positions (K, 2) at the fractions s (K,) of the step from k to k + 1."""
        model, place = self.body.model, list(self.body.model.position)
        x, u, t = self.states[k], self.inputs[k], s[:, None] * self.step
        if model.kind == SINGLE:
            return np.asarray(x[place] + t * u)
        if model.kind == DOUBLE:
            return np.asarray(x[place] + t * x[[2, 3]] + 0.5 * t**2 * u)
        if model.continuous:
            return _flow(_augmented(self.body), s * self.step, x, u)[:, place]
        return _flow(_logarithm(self.body), s, x, u)[:, place]

    @property
    def velocities(self) -> Array | None:
        """(T+1, 2), where the agent has such states."""
        pair = self.body.model.velocity
        return None if pair is None else self.states[:, list(pair)]


def integrate(body: Body, inputs: Array, step: float) -> Motion:
    """Follow the inputs from the start that the mission gives."""
    x = np.zeros(_width(body))
    x[: len(body.start)] = body.start
    states = [x]
    for u in inputs:
        states.append(_next(body, states[-1], u, step))
    return Motion(body, np.array(states), inputs, step)


def _width(body: Body) -> int:
    return len(body.model.A) or {SINGLE: 2, DOUBLE: 4}[body.model.kind]


def _next(body: Body, x: Array, u: Array, step: float) -> Array:
    model = body.model
    if model.kind == SINGLE:
        return np.asarray(x + step * u)
    if model.kind == DOUBLE:
        return np.concatenate([x[:2] + step * x[2:] + 0.5 * step**2 * u, x[2:] + step * u])
    if model.continuous:
        return np.asarray(_flow(_augmented(body), np.array([step]), x, u)[0])
    drift = np.array(model.c) if model.c else 0.0
    return np.asarray(np.array(model.A) @ x + np.array(model.B) @ u + drift)


def _augmented(body: Body) -> Array:
    """d/dt of (x, u, 1), u held."""
    model = body.model
    a, b = np.array(model.A), np.array(model.B)
    n, m = b.shape
    whole = np.zeros((n + m + 1, n + m + 1))
    whole[:n, :n], whole[:n, n : n + m] = a, b
    whole[:n, -1] = model.c if model.c else 0.0
    return whole


def _logarithm(body: Body) -> Array:
    """d/ds of (x, u, 1), s the share of a step, of discrete matrices."""
    from scipy.linalg import expm, logm

    whole = _augmented(body)
    size = len(body.model.A)
    whole[size:, size:] = np.eye(len(whole) - size)
    found = np.asarray(logm(whole))
    assert np.allclose(found.imag, 0.0, atol=1e-9)
    assert np.allclose(expm(found.real), whole, atol=1e-9)
    return np.asarray(found.real, dtype=np.float64)


def _flow(whole: Array, times: Array, x: Array, u: Array) -> Array:
    """States (K, n) at times (K,) [s] after x, under a held input."""
    from scipy.linalg import expm

    exponentials = np.asarray(expm(whole[None] * times[:, None, None]))
    return np.asarray((exponentials @ np.concatenate([x, u, [1.0]]))[:, : len(x)])
