"""Channels that know more: what was measured on the way is added to what was known before."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path

from stlc.errors import UsageError
from stlc.mission import Channel, Mission
from stlc.radio.errors import DataError, RadioError
from stlc.radio.gp import extended
from stlc.radio.read import SampleOptions, read_samples
from stlc.radio.samples import Samples


def reestimated(mission: Mission, heard: Mapping[str, Samples]) -> Mission:
    """The mission with channels conditioned on further samples of each, by name.

    Parameters stay; the posterior is that of all samples, old and new. A new sample of a link that
    had been measured before counts as another link as far as its own deviation goes. Raises
    UsageError for a channel that isn't there or has no model, or samples that it cannot take.
    """
    channels = dict(mission.channels)
    for name, samples in heard.items():
        channel = channels.get(name)
        if channel is None or channel.model is None:
            known = ", ".join(c.name for c in channels.values() if c.model is not None)
            text = "has no model to condition" if channel else "is not in the mission"
            raise UsageError(f"channel {name!r} {text}; those with a model: {known or 'none'}")
        if len(samples):
            channels[name] = _conditioned(channel, samples)
    return replace(mission, channels=channels)


def _conditioned(channel: Channel, samples: Samples) -> Channel:
    assert channel.model is not None
    try:
        return replace(channel, model=extended(channel.model, samples))
    except RadioError as error:
        raise UsageError(f"channel {channel.name!r}: {error}") from None


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
