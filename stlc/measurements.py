"""Missions whose channels know what was measured on the way."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

from stlc.errors import UsageError
from stlc.mission import Channel, Mission
from stlc.radio.errors import RadioError
from stlc.radio.learned import Learned, taught


def with_learned(mission: Mission, learned: Mapping[str, Learned]) -> Mission:
    """The mission with channels that know what was `learned`, by name; the same where they do.

    Raises UsageError for a channel that isn't there or has no model, samples that it cannot take,
    and one that has learnt something else before.
    """
    channels = dict(mission.channels)
    for name, what in learned.items():
        channel = channels.get(name)
        if channel is None or channel.model is None:
            known = ", ".join(c.name for c in channels.values() if c.model is not None)
            text = "has no model to condition" if channel else "is not in the mission"
            raise UsageError(f"channel {name!r} {text}; those with a model: {known or 'none'}")
        if not what.same(channel.learned):
            channels[name] = _taught(channel, what)
    return replace(mission, channels=channels)


def _taught(channel: Channel, what: Learned) -> Channel:
    if channel.learned is not None:
        raise UsageError(f"channel {channel.name!r} has learnt from other samples already")
    assert channel.model is not None
    try:
        model = taught(channel.model, channel.samples, what)
    except RadioError as error:
        raise UsageError(f"channel {channel.name!r}: {error}") from None
    return replace(channel, model=model, learned=what)


def lessons(mission: Mission) -> dict[str, Learned]:
    """What the mission's channels have learnt, by name."""
    found = {name: channel.learned for name, channel in mission.channels.items()}
    return {name: what for name, what in found.items() if what is not None}
