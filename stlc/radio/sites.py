"""Censored samples as Gaussian sites: one sweep of expectation propagation.

A site is what a sample tells about its link's strength, given what all the others tell: that is its
cavity, found from the diagonal of the inverse covariance.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from stlc.radio.problem import Problem
from stlc.radio.tobit import mills

Array = NDArray[np.float64]

DAMPING = 0.9


@dataclass(frozen=True, slots=True, eq=False)
class Sites:
    """Gaussian observations `target` (K,) [dBm] of variance `noise` (K,) [dB^2]."""

    target: Array
    noise: Array


def initial_sites(problem: Problem, fading: float, variance: float) -> Sites:
    """Observations as they are; censored ones as a weak Gaussian below their floor."""
    samples, hidden = problem.merged.samples, problem.censored
    target = np.where(hidden, samples.floor - np.sqrt(variance), samples.rssi)
    noise = np.where(hidden, variance, fading / problem.merged.count)
    return Sites(target, noise)


def cavity(
    target: Array, noise: Array, alpha: Array, diagonal: Array, floor: Array, fading: float
) -> tuple[Array, Array, Array, Array]:
    """Cavity mean and variance, spread s of the censored sample, and t = (floor - mean)/s."""
    mean = target - alpha / diagonal
    variance = np.maximum(1.0 / diagonal - noise, 1e-9)
    spread = np.sqrt(variance + fading)
    return mean, variance, spread, (floor - mean) / spread


def update_sites(
    problem: Problem, target: Array, noise: Array, alpha: Array, diagonal: Array, fading: float
) -> Sites:
    """One damped parallel EP sweep over the censored rows."""
    rows = np.flatnonzero(problem.censored)
    floor = problem.merged.samples.floor[rows]
    mean, variance, spread, t = cavity(
        target[rows], noise[rows], alpha[rows], diagonal[rows], floor, fading
    )
    _, ratio = mills(t)
    bend = np.clip(ratio * (t + ratio), 1e-9, 1.0)
    fresh = np.clip(spread**2 / bend - variance, 1e-6, 1e8)
    aim = mean - (fresh + variance) * ratio / spread
    precision = DAMPING / fresh + (1.0 - DAMPING) / noise[rows]
    moment = DAMPING * aim / fresh + (1.0 - DAMPING) * target[rows] / noise[rows]
    new_target, new_noise = target.copy(), noise.copy()
    new_noise[rows] = 1.0 / precision
    new_target[rows] = moment / precision
    return Sites(new_target, new_noise)
