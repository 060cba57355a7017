"""What a step costs, as a piecewise-linear function of states and inputs."""

from __future__ import annotations

from dataclasses import dataclass

from stlc.ir.signals import Signal


@dataclass(frozen=True, slots=True)
class Form:
    """constant + sum of factor * signal, signals at absolute steps (their `shift`)."""

    terms: tuple[tuple[Signal, float], ...]
    constant: float = 0.0


@dataclass(frozen=True, slots=True)
class Charge:
    """`form` plus, for each of `peaks`, a factor times the largest of some forms."""

    step: int
    form: Form
    peaks: tuple[tuple[float, tuple[Form, ...]], ...] = ()
