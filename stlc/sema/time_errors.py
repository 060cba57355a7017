"""Mistakes about time (E05xx)."""

from __future__ import annotations

from typing import ClassVar

from stlc.diagnostics import Diagnostic


class NotWholeSteps(Diagnostic):
    """A time isn't a whole number of steps. It is never rounded silently."""

    code: ClassVar[str] = "E0501"
    title: ClassVar[str] = "{value} is not a whole number of steps"
    label: ClassVar[str] = "one step is {step:g} s"
    help: ClassVar[str] = "use {below} or {above}, or change the step"
    value: str
    step: float
    below: str
    above: str


class ReversedInterval(Diagnostic):
    """An interval ends before it begins."""

    code: ClassVar[str] = "E0502"
    title: ClassVar[str] = "the interval ends before it begins"
    label: ClassVar[str] = "from step {start} to step {end}"
    help: ClassVar[str] = "swap the two ends"
    start: int
    end: int


class NegativeTime(Diagnostic):
    """A time is negative. Formulas look from the present step into the future."""

    code: ClassVar[str] = "E0503"
    title: ClassVar[str] = "times can't be negative"
    label: ClassVar[str] = "negative"
    help: ClassVar[str] = "start at 0; for something earlier, state the earlier event first"


class PastHorizon(Diagnostic):
    """A bounded operator looks past the end of the mission.

    A formula with nested intervals needs the sum of their ends. An operator with no interval
    instead ranges over the steps at which its body can still be judged.
    """

    code: ClassVar[str] = "E0504"
    title: ClassVar[str] = "this needs {needed} steps, but the horizon is {horizon}"
    label: ClassVar[str] = "looks as far as step {needed}"
    help: ClassVar[str] = "write `horizon {needed}`, or shorten the interval"
    needed: int
    horizon: int


class SignalEnds(Diagnostic):
    """A signal that is known beforehand ends before the mission does.

    Its file has a row for each step, from 0 to the horizon at least, and further where `ahead`
    looks further.
    """

    code: ClassVar[str] = "E0513"
    title: ClassVar[str] = "the signal is known up to step {last}; step {needed} is needed"
    label: ClassVar[str] = "asks for more"
    help: ClassVar[str] = "add rows to its file, or give a shorter `horizon`"
    last: int
    needed: int


class NoHorizon(Diagnostic):
    """Nothing says how long the mission is.

    The horizon is the furthest step that a bounded interval looks at, unless `horizon` gives it.
    With unbounded operators alone there is no such step.
    """

    code: ClassVar[str] = "E0505"
    title: ClassVar[str] = "how long is the mission?"
    label: ClassVar[str] = "{reason}"
    help: ClassVar[str] = "add a line such as `horizon 20`, or give an interval"
    reason: str = "unbounded, and no other requirement has an interval"


class BadStep(Diagnostic):
    """The step or horizon isn't a positive duration."""

    code: ClassVar[str] = "E0506"
    title: ClassVar[str] = "`{name}` must be {expected}"
    label: ClassVar[str] = "not valid"
    help: ClassVar[str] = "write for example `{usage}`"
    name: str
    expected: str
    usage: str


class NotSteps(Diagnostic):
    """A time has a unit that isn't a time."""

    code: ClassVar[str] = "E0507"
    title: ClassVar[str] = "a time is needed here, not {found}"
    label: ClassVar[str] = "not a time"
    help: ClassVar[str] = "give whole steps (`8`) or a time with its unit (`4 s`, `500 ms`)"
    found: str


class HugeTime(Diagnostic):
    """A number of steps is beyond any plan that can be solved."""

    code: ClassVar[str] = "E0508"
    title: ClassVar[str] = "{steps} steps are more than {limit}"
    label: ClassVar[str] = "too long"
    help: ClassVar[str] = "use a longer `step`"
    steps: str
    limit: int
