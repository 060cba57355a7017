"""Variances and correlation length of greatest likelihood."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from stlc.radio.likelihood import Evaluation, evaluate
from stlc.radio.problem import Problem, make_blocks
from stlc.radio.samples import Merged
from stlc.radio.sites import Sites, initial_sites
from stlc.radio.tobit import Regression

Array = NDArray[np.float64]

BLOCK_ROWS = 300
SCREEN_ROWS = 600
"""Rows on which the restarts are run before the best end is polished."""

POLISH_ROWS = 4000
"""Rows whose blocks fix fading, shadowing and length; the mean and the likelihood use all."""

ENOUGH = 1e-3
"""A climb ends when a step gains less log likelihood than this."""

STEP = 1e-3
"""Step of theta in differences of the gradient."""

EDGE = 0.1
"""Entries of theta this close to a limit are at it: where the likelihood still rises there it does
so over whole units."""

LEAST_SHARE = 0.05
"""Share of the variance that each component has when it is climbed again: some subsets of the
campus measurements hold too few repeats to show the deviation that all of them do."""

CLOSE = 0.5
"""Ends nearer than this in all of theta are one; the campus likelihood has a second maximum at a
seventh of the length, which a subset may take for the first."""


def optimise(problem: Problem, alone: Regression, restarts: int, seed: int) -> Array:
    """Theta of greatest likelihood: starts compared on a subset drawn by `seed`, the best
    `restarts` of them climbed, the best end polished on more rows. `alone`: path loss alone."""
    small = _screen(problem, seed, SCREEN_ROWS)
    part = small.restricted()
    starts = _starts(problem, alone)
    starts.sort(key=lambda s: -evaluate(part, s, start_sites(part, s, alone)).value)
    ends = [_climb(small, start, alone, problem) for start in starts[:restarts]]
    ends.sort(key=lambda end: -end[1])
    if small is problem:
        return ends[0][0]
    large = _screen(problem, seed, POLISH_ROWS)
    again = [_lifted(theta) for theta, _ in ends]
    apart = [s for k, s in enumerate(again) if not any(_close(s, r) for r in again[:k])]
    return max((_climb(large, s, alone, problem) for s in apart), key=lambda end: end[1])[0]


def _lifted(theta: Array) -> Array:
    """Theta off its lower limits, where the likelihood of more rows could not move it."""
    variances = np.delete(theta, 2)
    least = np.log(LEAST_SHARE * np.exp(variances).sum())
    return np.insert(np.maximum(variances, least), 2, theta[2])


def _close(one: Array, other: Array) -> bool:
    return bool(np.abs(one - other).max() < CLOSE)


def start_sites(problem: Problem, theta: Array, alone: Regression) -> Sites:
    """Sites to begin with at theta."""
    return initial_sites(problem, float(np.exp(theta[0])), alone.variance)


def standard_errors(
    problem: Problem, theta: Array, last: Evaluation, alone: Regression
) -> tuple[tuple[str, float], ...]:
    """Errors of l0, exponent and theta's entries (log_fading, ...): square roots of the
    inverse observed information (differences of the gradient). Entries at a limit are taken as
    given, inf."""
    limits = _limits(problem, alone)
    free = [k for k, (low, high) in enumerate(limits) if low + EDGE < theta[k] < high - EDGE]
    spread = np.full(len(theta), np.inf)
    information = np.zeros((len(free), len(theta)))
    for row, k in enumerate(free):
        move = STEP * np.eye(len(theta))[k]
        up = evaluate(problem, theta + move, last.sites).gradient
        down = evaluate(problem, theta - move, last.sites).gradient
        information[row] = (down - up) / (2.0 * STEP)
    square = information[:, free]
    value, vector = np.linalg.eigh((square + square.T) / 2.0)
    spread[free] = np.sqrt((vector**2) @ (1.0 / np.maximum(value, 1e-30)))
    linear = np.sqrt(np.diag(last.covariance)[:2])
    names = ("l0", "exponent", *(f"log_{name}" for name in problem.names))
    return tuple(zip(names, map(float, [*linear, *spread]), strict=True))


def _limits(problem: Problem, alone: Regression) -> list[tuple[float, float]]:
    """Least and greatest value of theta's entries."""
    size, variance = float(np.log(_scale(problem))), float(np.log(alone.variance))
    spread = (variance - 9.0, variance + 3.0)
    return [(size - 6.0, size + 3.0) if n == "length" else spread for n in problem.names]


def _screen(problem: Problem, seed: int, most: int) -> Problem:
    """Whole blocks that hold about `most` rows, drawn at random; all rows where they fit."""
    if len(problem.features) <= most:
        return problem
    blocks = make_blocks(problem.merged.samples.links, BLOCK_ROWS)
    order = np.random.default_rng(seed).permutation(len(blocks))
    picked = [blocks[i] for i in order[: max(2, most // BLOCK_ROWS)]]
    return replace(problem, blocks=tuple(picked))


def _scale(problem: Problem) -> float:
    """Extent [m] of the positions: the largest standard deviation of a coordinate."""
    return max(float(problem.merged.samples.links.std(axis=0).max()), 1e-3)


def _starts(problem: Problem, alone: Regression) -> list[Array]:
    base = [(f, s) for s in (0.5, 0.8) for f in (0.1, 0.3, 1.0, 0.03)]
    starts = [_start(problem.merged, alone.variance, s) for _, s in base]
    squares = np.append(alone.coefficients[problem.fixed :] ** 2, alone.variance)
    offset = float(squares.mean())
    for start, (share, _) in zip(starts, base, strict=True):
        start.update(length=_scale(problem) * share, offset=offset)
    return [np.log([start[name] for name in problem.names]) for start in starts]


def _start(merged: Merged, variance: float, share: float) -> dict[str, float]:
    """Shadowing takes `share` of the variance; fading the scatter of the repeats, and the
    links' deviations the rest."""
    rest = variance * (1.0 - share)
    if not merged.repeated:
        return {"fading": rest, "shadowing": variance * share}
    surplus = float((merged.count - 1.0).sum())
    within = float(merged.scatter.sum()) / surplus if surplus else rest / 2.0
    fading = min(max(within, 1e-3 * variance), rest)
    deviation = max(rest - fading, 0.1 * rest)
    return {"fading": fading, "shadowing": variance * share, "deviation": deviation}


def _climb(
    problem: Problem, start: Array, alone: Regression, whole: Problem
) -> tuple[Array, float]:
    """L-BFGS-B from `start`; returns the end and its log likelihood."""
    from scipy.optimize import minimize

    active = problem.restricted()
    sites = [start_sites(active, start, alone)]

    def objective(theta: Array) -> tuple[float, Array]:
        got = evaluate(active, theta, sites[0])
        sites[0] = got.sites
        return -got.value, -got.gradient

    limits = _limits(whole, alone)
    options = {"maxiter": 60, "ftol": ENOUGH / max(abs(alone.log_likelihood), 1.0), "gtol": 1e-3}
    found = minimize(objective, start, jac=True, method="L-BFGS-B", bounds=limits, options=options)
    return np.asarray(found.x, dtype=np.float64), -float(found.fun)
