"""Mistakes about the objective (E07xx)."""

from __future__ import annotations

from typing import ClassVar

from stlc.diagnostics import Diagnostic


class BadObjective(Diagnostic):
    """The objective isn't a weighted sum of costs.

    Costs are `effort`, `effort(agent)`, `link_cost(channel)`, `link_cost(channel, (a, b))`, each
    with an optional interval `effort[0, 4]`, `normalised(cost)`, `time(requirement)`, and
    `robustness`, `robustness(requirement)`. Weights are plain numbers.
    """

    code: ClassVar[str] = "E0701"
    title: ClassVar[str] = "{problem}"
    label: ClassVar[str] = "not a weighted cost"
    help: ClassVar[str] = "{hint}"
    problem: str
    hint: str = "write a sum such as `0.1 * effort + 0.9 * link_cost(radio)`"


class MixedRobustness(Diagnostic):
    """Robustness is maximised over requirements in different units.

    The smallest of metres and decibels means nothing until each unit has a scale: how much of it
    counts as one.
    """

    code: ClassVar[str] = "E0702"
    title: ClassVar[str] = "robustness mixes {units}"
    label: ClassVar[str] = "no common unit"
    help: ClassVar[str] = "give one of each that counts alike: `robustness(scale({usage}))`"
    units: str
    usage: str


class BadPreference(Diagnostic):
    """A `prefer` whose weight, priority, scale or measure has no meaning.

    `prefer name weight 2 priority 1 scale 2 dB: ..` measures what the robustness lacks; with `late`
    it counts seconds past a deadline, with `share` the parts that fail. Weights are 0 or more,
    scales above 0, priorities 1, 2, .., and 1 comes first.
    """

    code: ClassVar[str] = "E0706"
    title: ClassVar[str] = "{problem}"
    label: ClassVar[str] = "not a preference"
    help: ClassVar[str] = "{hint}"
    problem: str
    hint: str = "write for example `prefer close weight 2 scale 1 m: always distance(a, b) <= 3 m`"


class NegativeWeight(Diagnostic):
    """A cost has a negative weight, or robustness is minimised: the optimum would be unbounded.

    Efforts and link costs are minimised, robustness is maximised.
    """

    code: ClassVar[str] = "E0703"
    title: ClassVar[str] = "{what} would be {direction}"
    label: ClassVar[str] = "weight {weight:g}"
    help: ClassVar[str] = "{hint}"
    what: str
    direction: str
    weight: float
    hint: str


class NoTime(Diagnostic):
    """An objective's window holds no step of the mission."""

    code: ClassVar[str] = "E0704"
    title: ClassVar[str] = "the window [{start}, {end}] leaves the mission's {horizon} steps"
    label: ClassVar[str] = "beyond the horizon"
    help: ClassVar[str] = "end it at {horizon} or earlier, or write `horizon {end}`"
    start: int
    end: int
    horizon: int


class NeverTrue(Diagnostic):
    """A requirement can't hold, whatever the agents do: bounds alone exclude it.

    Interval reasoning over the workspace and the declared bounds gives its best robustness, which
    is below the required margin.
    """

    code: ClassVar[str] = "E0705"
    title: ClassVar[str] = "requirement `{name}` can never hold"
    label: ClassVar[str] = "at best {best:.6g}, required {margin:g}"
    help: ClassVar[str] = "check its numbers against the workspace and the bounds of the agents"
    name: str
    best: float
    margin: float


class EndToEndRobustness(Diagnostic):
    """Robustness is maximised over a route with an end-to-end quality.

    The product of reception ratios along a path, or a sum of costs, is planned against a threshold;
    how far beyond it goes is no linear function of the model. Routes by `rssi` or `snr`, which hold
    on every hop, can be maximised, and so can any other requirement by itself.
    """

    code: ClassVar[str] = "E0710"
    title: ClassVar[str] = "the end-to-end quality of a route can't be maximised"
    label: ClassVar[str] = "over requirement `{name}`"
    help: ClassVar[str] = (
        "give that requirement a `margin` and maximise another, or route by `rssi` or `snr`"
    )
    name: str
