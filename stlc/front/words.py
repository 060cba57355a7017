"""The words of the language as functions."""

from __future__ import annotations

from collections.abc import Iterable
from functools import reduce
from typing import Any

from stlc.front.expressions import Formula, Quantity
from stlc.front.text import interval, point, written


def formula(text: str) -> Formula:
    """A formula as the language writes it: `forall a in agents: a outside pillar`."""
    return Formula(text)


def quantity(text: str) -> Quantity:
    """A quantity as the language writes it: `ahead(r1.x, 2 s)`."""
    return Quantity(text)


def always(body: Formula | str, start: Any = None, end: Any = None) -> Formula:
    """At every step of the interval; steps are numbers, times are texts such as "2 s"."""
    return Formula(f"always{interval(start, end)} ({written(body)})")


def eventually(body: Formula | str, start: Any = None, end: Any = None) -> Formula:
    """At some step of the interval."""
    return Formula(f"eventually{interval(start, end)} ({written(body)})")


def all_of(parts: Iterable[Formula]) -> Formula:
    """All of them; ValueError for none."""
    return _joined(parts, "and")


def any_of(parts: Iterable[Formula]) -> Formula:
    """At least one of them; ValueError for none."""
    return _joined(parts, "or")


def _joined(parts: Iterable[Formula], word: str) -> Formula:
    found = list(parts)
    if not found:
        raise ValueError(f"there is nothing to join by `{word}`")
    return reduce(lambda a, b: a & b if word == "and" else a | b, found)


def _call(name: str, *arguments: Any) -> Quantity:
    return Quantity(f"{name}({', '.join(_argument(a) for a in arguments if a is not None)})")


def _argument(value: Any) -> str:
    return point(value) if isinstance(value, tuple | list) else written(value)


def distance(a: Any, b: Any) -> Quantity:
    """Euclidean distance [m] of two agents, stations or points."""
    return _call("distance", a, b)


def separation(a: Any, b: Any) -> Quantity:
    """The larger of the distances along the axes [m]."""
    return _call("separation", a, b)


def norm(*values: Any) -> Quantity:
    """Euclidean length of two or three signals."""
    return _call("norm", *values)


def abs_(value: Any) -> Quantity:
    """Absolute value; Python's own `abs` does too."""
    return _call("abs", value)


def minimum(*values: Any) -> Quantity:
    """The least of them."""
    return _call("min", *values)


def maximum(*values: Any) -> Quantity:
    """The largest of them."""
    return _call("max", *values)


def rssi(a: Any, b: Any, channel: Any = None) -> Quantity:
    """Mean received strength [dBm]."""
    return _call("rssi", a, b, channel)


def snr(a: Any, b: Any, channel: Any = None) -> Quantity:
    """Signal to noise [dB]."""
    return _call("snr", a, b, channel)


def ber(a: Any, b: Any, channel: Any = None) -> Quantity:
    """Bit error rate."""
    return _call("ber", a, b, channel)


def prr(a: Any, b: Any, channel: Any = None) -> Quantity:
    """Packet reception ratio."""
    return _call("prr", a, b, channel)


def probability(body: Formula | str) -> Quantity:
    """`P(..)`, of comparisons of links."""
    return Quantity(f"P({written(body)})")


def effort(*agents: Any) -> Quantity:
    """The cost of states and inputs, of some agents or all."""
    return _call("effort", *agents) if agents else Quantity("effort")


def link_cost(channel: Any, *pairs: tuple[Any, Any]) -> Quantity:
    """A channel's cost, of some pairs or all that the mission names."""
    return _call("link_cost", channel, *pairs)


def robustness(requirement: str | None = None) -> Quantity:
    """That of one requirement, or of all together; for `maximize`."""
    return Quantity("robustness" if requirement is None else f"robustness({requirement})")
