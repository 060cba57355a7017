"""Channels that know more: what was measured on the way is added to what was known before."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path

from stlc.errors import UsageError
from stlc.measurements import with_learned
from stlc.mission import Channel, Mission
from stlc.radio.errors import DataError, RadioError
from stlc.radio.learned import Learned, together
from stlc.radio.likelier import fitted_anew
from stlc.radio.read import SampleOptions, read_samples
from stlc.radio.samples import Samples, joined


def reestimated(
    mission: Mission,
    heard: Mapping[str, Samples],
    known: Mapping[str, Learned] | None = None,
    *,
    refit: bool = False,
) -> Mission:
    """The mission with channels that know further samples of each, by name.

    `known` is what they had learnt before. Their posterior is that of all samples, old and new;
    parameters stay, but with `refit` where `stlc.radio.likelier` finds others. Raises UsageError
    for a channel that isn't there or has no model, or samples that it cannot take.
    """
    learned = dict(known or {})
    for name, samples in heard.items():
        if samples.censored.any():
            raise UsageError(f"channel {name!r}: censored samples can't be conditioned on")
        if not len(samples) and name in mission.channels:
            continue
        before = [learned[name]] if name in learned else []
        try:
            learned[name] = together([*before, Learned(samples.links, samples.rssi)])
        except RadioError as error:
            raise UsageError(f"channel {name!r}: {error}") from None
    found = with_learned(mission, learned)
    if not refit:
        return found
    return with_learned(mission, {n: _anew(mission.channels[n], x) for n, x in learned.items()})


def _anew(channel: Channel, learned: Learned) -> Learned:
    """What a channel has learnt, with parameters fitted to all samples where they are worth it."""
    model, given, fresh = channel.model, channel.samples, learned.samples
    assert model is not None
    prior = model if learned.parameters is None else learned.parameters.prior(model)
    everything = fresh if given is None else joined(given, fresh)
    found = fitted_anew(prior, given, fresh, everything)
    return learned if found is None else replace(learned, parameters=found)


def read_heard(path: str | Path) -> Samples:
    """Samples from a CSV file as channels have them. Raises UsageError with the place."""
    try:
        return read_samples(path, SampleOptions())
    except DataError as error:
        raise UsageError(str(error)) from None


def channel_of(mission: Mission, text: str) -> tuple[str, Path]:
    """`new.csv`, or `radio=new.csv` where a mission has several channels with a model.

    Raises UsageError where it is not plain which one is meant.
    """
    name, sign, file = text.partition("=")
    if sign and name in mission.channels:
        return name, Path(file)
    known = [c.name for c in mission.channels.values() if c.model is not None]
    if len(known) != 1:
        listed = ", ".join(known) or "none"
        raise UsageError(f"say whose samples {text} holds: NAME={text}; channels: {listed}")
    return known[0], Path(text)
