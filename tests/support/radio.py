"""Channels and samples shared by the radio tests."""

import numpy as np

from stlc.radio.gp import ChannelModel, condition
from stlc.radio.prior import PAPER_CHANNEL, draw_samples
from stlc.radio.samples import Samples


def conditioned(count: int = 40, seed: int = 3) -> tuple[ChannelModel, Samples]:
    samples = draw_samples(PAPER_CHANNEL, -5.0, 5.0, count, seed)
    return condition(PAPER_CHANNEL, samples), samples


def uniform_links(count: int, seed: int, size: float = 5.0) -> np.ndarray:
    return np.random.default_rng(seed).uniform(-size, size, (count, 4))
