"""Mistakes about unicycles and cars: what they need, and what nothing could track (E0419..)."""

from __future__ import annotations

from typing import ClassVar

from stlc.diagnostics import Diagnostic


class RobotNeeds(Diagnostic):
    """A unicycle or a car lacks a property that its plan depends on.

    A unicycle needs `speed <= ..` and `turn_rate <= ..`, a car `speed <= ..`, `wheelbase ..` and
    `steering <= ..`; `heading`, `lookahead` and `period` have defaults. From these follow how fast
    a plan may be and how far the robot stays within it.
    """

    code: ClassVar[str] = "E0419"
    title: ClassVar[str] = "the {kind} `{name}` has no `{what}`"
    label: ClassVar[str] = "how it moves isn't known"
    help: ClassVar[str] = "add `{usage}` to its block, or to that of its dynamics"
    name: str
    kind: str
    what: str
    usage: str


class NotTracked(Diagnostic):
    """With these numbers nothing is promised of how a robot follows its plan.

    The controller must act often enough for the speed and the look-ahead distance, a whole number
    of times a step, and a car's directions must be so many that its steering allows a change from
    each to the next.
    """

    code: ClassVar[str] = "E0420"
    title: ClassVar[str] = "`{name}` can't be tracked: {problem}"
    label: ClassVar[str] = "here"
    help: ClassVar[str] = "{hint}"
    name: str
    problem: str
    hint: str
