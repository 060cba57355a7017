"""Mistakes about radio channels (E06xx)."""

from __future__ import annotations

from typing import ClassVar

from stlc.diagnostics import Diagnostic


class MissingChannelValue(Diagnostic):
    """A channel lacks a value that the mission's use of it needs.

    Path loss needs L0 and n. SNR, BER and PRR need `noise_floor`, or `bandwidth` with
    `noise_figure`; BER and PRR need `modulation`; PRR, `etx` and `neg_log_prr` need `packet`;
    `outage` needs `sensitivity`; `energy` needs what `etx` needs, `power` and `rate`; a `frequency`
    in place of L0 needs `power`. Every predicate and cost needs `partition`.
    """

    code: ClassVar[str] = "E0601"
    title: ClassVar[str] = "channel `{channel}` has no `{what}`"
    label: ClassVar[str] = "{why}"
    help: ClassVar[str] = "add `{usage}` to the channel"
    channel: str
    what: str
    why: str
    usage: str


class BadChannel(Diagnostic):
    """The values of a channel don't go together."""

    code: ClassVar[str] = "E0602"
    title: ClassVar[str] = "channel `{channel}`: {problem}"
    label: ClassVar[str] = "here"
    help: ClassVar[str] = "{hint}"
    channel: str
    problem: str
    hint: str = "see the channel section of the language guide"


class RayleighWithFading(Diagnostic):
    """A Rayleigh-averaged modulation is combined with a fading variance.

    Both describe the same fluctuation from packet to packet, so it would be counted twice.
    """

    code: ClassVar[str] = "E0603"
    title: ClassVar[str] = "`{modulation}` already averages over fading"
    label: ClassVar[str] = "and the channel has fading {fading:g} dB^2"
    help: ClassVar[str] = "write `fading 0 dB^2`, or use `{plain}`"
    modulation: str
    fading: float
    plain: str


class WhichChannel(Diagnostic):
    """A link predicate or cost doesn't say which channel it means, and it isn't clear.

    With one channel in the mission its name may be left out.
    """

    code: ClassVar[str] = "E0604"
    title: ClassVar[str] = "which channel is meant?"
    label: ClassVar[str] = "{found}"
    help: ClassVar[str] = "{hint}"
    found: str
    hint: str


class BadProbability(Diagnostic):
    """A chance must lie strictly between 0 and 1."""

    code: ClassVar[str] = "E0605"
    title: ClassVar[str] = "a chance of {value:g} is not strictly between 0 and 1"
    label: ClassVar[str] = "no such probability"
    help: ClassVar[str] = "0 and 1 can't be promised over a fading channel; use 0.99, say"
    value: float


class BadLink(Diagnostic):
    """A link predicate is used in a way that has no linear meaning.

    A link quality is compared with a constant. Two qualities, or a quality and a signal, can't
    stand in one comparison; `min` and `max` of several links can.
    """

    code: ClassVar[str] = "E0606"
    title: ClassVar[str] = "{problem}"
    label: ClassVar[str] = "here"
    help: ClassVar[str] = "{hint}"
    problem: str
    hint: str = "compare each link quality with a constant and join them by `and`, `or`"
    itself: bool = False  # a radio with itself: a count leaves that one out


class BadNetwork(Diagnostic):
    """A condition on a network is not one that can be planned.

    `connected(radios, channel, condition)` joins the radios, `route(a, b, [relays], channel,
    hops <= 3, condition)` leads from one to another; the condition speaks of one link, with bare
    `rssi`, `snr`, `ber`, `prr` or `link_cost`, and comes last. Along a route `prr`, `ber` and
    additive costs are end-to-end values, anything else has to hold on every hop.
    """

    code: ClassVar[str] = "E0609"
    title: ClassVar[str] = "{problem}"
    label: ClassVar[str] = "here"
    help: ClassVar[str] = "{hint}"
    problem: str
    hint: str


class BadData(Diagnostic):
    """A data file that a channel names can't be used."""

    code: ClassVar[str] = "E0607"
    title: ClassVar[str] = "`{path}`: {problem}"
    label: ClassVar[str] = "named here"
    help: ClassVar[str] = "{hint}"
    path: str
    problem: str
    hint: str


class TableOnly(Diagnostic):
    """A channel that is given by tables of costs has no strength, SNR or error rate."""

    code: ClassVar[str] = "E0608"
    title: ClassVar[str] = "channel `{channel}` is a table of costs, it has no `{quantity}`"
    label: ClassVar[str] = "needs a channel model"
    help: ClassVar[str] = "compare `link_cost({channel}, (a, b))`, or give the channel `path_loss`"
    channel: str
    quantity: str
