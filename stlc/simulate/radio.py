"""Strengths of the packets that a plan's links carry, drawn jointly over pairs and steps."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import assert_never

import numpy as np
from numpy.typing import NDArray

from stlc.channels import needed
from stlc.ir.nodes import Link, Node, Quantity, Relation, walk
from stlc.link_places import dimensions, raised, receiver
from stlc.mission import Channel, Mission
from stlc.radio.costs import CostName, link_cost
from stlc.radio.gp import UNHEARD, ChannelModel
from stlc.radio.joint import joint
from stlc.radio.link_budget import LinkBudget
from stlc.simulate.runs import Runs
from stlc.simulate.tabled import tabled_cost

Array = NDArray[np.float64]
Pair = tuple[str, str]

_NUMBERS = 4_000_000
"""Doubles in the largest array of a block of worlds: 32 MB."""


@dataclass(frozen=True, slots=True, eq=False)
class Packets:
    """One packet for each ordered pair and step in each draw; `levels` (T+1, D) [dBm] by channel
    and pair."""

    mission: Mission
    runs: Runs
    levels: Mapping[tuple[str, Pair], Array]

    def robustness(self, link: Link, positive: bool) -> Array:
        """Robustness (T+1, D) of a link predicate for that packet, whatever the polarity; of
        `P(..)` that of the event itself."""
        channel = self.mission.channels[link.channel]
        pair = (link.sender, link.receiver)
        if _is_tabled(channel, link):
            value = tabled_cost(self.mission, channel, pair, self.runs.positions)
        else:
            level = self.levels[link.channel, pair]
            value = _quantity(link.quantity, level, channel, needed(channel)[1])
        excess = value - link.threshold
        return link.factor * (excess if link.relation is Relation.AT_LEAST else -excess)


def _is_tabled(channel: Channel, link: Link) -> bool:
    return link.quantity is Quantity.COST and channel.has_table((link.sender, link.receiver))


def _quantity(quantity: Quantity, level: Array, channel: Channel, budget: LinkBudget) -> Array:
    """What a link predicate measures, of packets received at `level` [dBm]."""
    match quantity:
        case Quantity.RSSI:
            return level
        case Quantity.SNR:
            return budget.snr(level)
        case Quantity.BER | Quantity.BER_AT_MEAN:
            return budget.ber(level)
        case Quantity.PRR:
            return budget.prr(level)
        case Quantity.COST:
            return link_cost(CostName(channel.cost), level, np.zeros_like(level), budget).values
        case _:
            assert_never(quantity)


def draw_packets(
    mission: Mission,
    runs: Runs,
    formulas: Sequence[Node],
    draws: int,
    rng: np.random.Generator,
    fading: bool = True,
) -> Packets:
    """Packets of every link that the formulas name.

    Shadowing, deviations and what calibration may be off by are drawn jointly over the pairs and
    steps of a channel, at the positions of each draw; `fading` for each packet by itself. Raises
    RadioError as the channel does.
    """
    wanted: dict[str, dict[Pair, None]] = {}
    for formula in formulas:
        for node in walk(formula):
            if isinstance(node, Link) and not _is_tabled(mission.channels[node.channel], node):
                wanted.setdefault(node.channel, {})[node.sender, node.receiver] = None
    levels: dict[tuple[str, Pair], Array] = {}
    for name, pairs in wanted.items():
        model, _ = needed(mission.channels[name])
        strengths = _strengths(mission, model, list(pairs), runs, draws, rng)
        for pair, level in zip(pairs, strengths, strict=True):
            own = np.sqrt(model.fading) * rng.standard_normal(level.shape) if fading else 0.0
            levels[name, pair] = level + own
    return Packets(mission, runs, levels)


def _strengths(
    mission: Mission,
    model: ChannelModel,
    pairs: Sequence[Pair],
    runs: Runs,
    draws: int,
    rng: np.random.Generator,
) -> Array:
    """Strengths (pairs, T+1, draws) [dBm] without fading; both directions of a link have one."""
    distinct = list(dict.fromkeys(_unordered(pair) for pair in pairs))
    links = _links(mission, model, distinct, runs)
    drawn = _in_blocks(model, links, draws, rng).reshape(len(distinct), -1, draws)
    strengths = drawn[[distinct.index(_unordered(pair)) for pair in pairs]]
    names = [receiver(model, pair) for pair in pairs]
    ears = [pair[1] if n == UNHEARD else n for n, pair in zip(names, pairs, strict=True)]
    spread = {e: np.sqrt(model.offset_variance(n)) for e, n in zip(ears, names, strict=True)}
    offs = {ear: size * rng.standard_normal(draws) for ear, size in spread.items()}
    for level, name, ear in zip(strengths, names, ears, strict=True):
        level += model.offset(name) + offs[ear]
    return strengths


def _unordered(pair: Pair) -> Pair:
    return (min(pair), max(pair))


def _links(mission: Mission, model: ChannelModel, pairs: Sequence[Pair], runs: Runs) -> Array:
    """The links (W, pairs (T+1), 2 D) [m] of all pairs in each world, one after the other; in space
    where any of them is, and in worlds of their own where any end of one is noisy."""
    axes = max(dimensions(mission, model, pair) for pair in pairs)
    ends = [
        tuple(runs.positions[name] + raised(mission, name)[:, None] for name in pair)
        for pair in pairs
    ]
    worlds = max(place.shape[2] for both in ends for place in both)
    links = []
    for both in ends:
        a, b = (np.moveaxis(place[:, :axes], 2, 0) for place in both)
        steps = a.shape[1]
        links.append(
            np.concatenate([np.broadcast_to(end, (worlds, steps, axes)) for end in (a, b)], axis=2)
        )
    return np.concatenate(links, axis=1)


def _in_blocks(model: ChannelModel, links: Array, draws: int, rng: np.random.Generator) -> Array:
    """Strengths (K, draws) of links (W, K, 2 D), a block of worlds at a time."""
    worlds, count, _ = links.shape
    if worlds == 1:
        return joint(model, links).draw(rng, draws)
    centres = 0 if model.posterior is None else len(model.posterior.centres)
    size = max(1, _NUMBERS // (count * max(count, centres, 1)))
    parts = [joint(model, links[k : k + size]) for k in range(0, worlds, size)]
    return np.concatenate([part.draw(rng, len(part.mean)) for part in parts], axis=1)
