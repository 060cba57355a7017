"""A world to try closed loops in: channels drawn once, agents that are pushed off their way."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from stlc.arrays import Floats
from stlc.channels import needed
from stlc.link_places import true_links
from stlc.mission import Agent, Mission
from stlc.radio.gp import ChannelModel, extended
from stlc.radio.samples import make_samples
from stlc.renew.receding import Heard, Measured
from stlc.verify.link_models import named_pairs

Pair = tuple[str, str]


@dataclass(slots=True)
class TrueChannel:
    """One draw of a channel's posterior, link by link as they are asked for.

    What was drawn conditions what is drawn next, so that all values together are one joint draw.
    """

    model: ChannelModel
    rng: np.random.Generator
    _known: ChannelModel = field(init=False)

    def __post_init__(self) -> None:
        self._known = replace(self.model, fading=0.0, deviation=0.0)

    def mean(self, link: Floats) -> float:
        """What many packets over the link (2 D,) [m] are received with [dBm]."""
        mean, variance = self._known.predict(link[None, :], False)
        level = float(mean[0] + np.sqrt(variance[0]) * self.rng.standard_normal())
        if self._known.shadowing:
            self._known = extended(self._known, make_samples(link[None, :], np.array([level])))
        return level

    def packet(self, mean: float) -> float:
        """The strength of one packet [dBm] over a link of that mean."""
        return mean + float(np.sqrt(self.model.fading) * self.rng.standard_normal())


@dataclass(slots=True)
class SimulatedWorld:
    """Carries inputs out, with the noise that agents declare, and measures links as packets.

    Channels are drawn from what `mission` knows of them at the beginning. Links are those that its
    requirements and its objective name, one packet a step.
    """

    mission: Mission
    rng: np.random.Generator
    channels: dict[str, TrueChannel] = field(init=False)
    pairs: Sequence[tuple[str, Pair]] = field(init=False)
    means: dict[tuple[str, Pair], list[float]] = field(default_factory=dict)
    now: int = 0  # the step that it is at

    def __post_init__(self) -> None:
        self.pairs = [
            (name, pair)
            for name, pair in named_pairs(self.mission)
            if self.mission.channels[name].model is not None
        ]
        self.channels = {
            name: TrueChannel(needed(self.mission.channels[name])[0], self.rng)
            for name in dict.fromkeys(name for name, _ in self.pairs)
        }

    def begin(self) -> Measured:
        """Where agents start, off by their `start_noise`."""
        states, self.now = {}, 0
        for name, agent in self.mission.agents.items():
            off = agent.start_noise
            push = 0.0 if off is None else off * self.rng.standard_normal(len(off))
            states[name] = agent.start + push
        return self._measured(states)

    def step(self, states: Mapping[str, Floats], inputs: Mapping[str, Floats]) -> Measured:
        """One step on from the states by the inputs, off by `control_noise`."""
        after = {
            name: self._moved(agent, states[name], inputs[name])
            for name, agent in self.mission.agents.items()
        }
        self.now += 1
        return self._measured(after)

    def _moved(self, agent: Agent, x: Floats, u: Floats) -> Floats:
        law, shake = agent.dynamics.law(self.now), agent.input_noise
        push = 0.0 if shake is None else shake * self.rng.standard_normal(len(shake))
        return np.asarray(law.A @ x + law.B @ (u + push) + law.drift)

    def _measured(self, states: Mapping[str, Floats]) -> Measured:
        heard = []
        for name, pair in self.pairs:
            link = self.link(name, pair, states)
            mean = self.channels[name].mean(link)
            self.means.setdefault((name, pair), []).append(mean)
            heard.append(Heard(name, pair, link, self.channels[name].packet(mean)))
        return Measured(states, tuple(heard))

    def link(self, channel: str, pair: Pair, states: Mapping[str, Floats]) -> Floats:
        """The link (2 D,) [m] of a pair where its ends are now."""
        model, _ = needed(self.mission.channels[channel])
        ends = [self._place(name, states)[None, :] for name in pair]
        return np.asarray(true_links(self.mission, model, pair, ends[0], ends[1])[0])

    def _place(self, name: str, states: Mapping[str, Floats]) -> Floats:
        station = self.mission.stations.get(name)
        if station is not None:
            return station.place
        space = self.mission.agents[name].dynamics.space
        assert space is not None, "a link's end is somewhere"
        return np.asarray(space @ states[name])
