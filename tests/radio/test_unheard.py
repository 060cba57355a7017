"""Links and receivers that were never measured: what is known of them, and how wide it is."""

from dataclasses import replace

import numpy as np
import pytest
from support.radio import PAPER_CHANNEL

from stlc.link_places import receiver
from stlc.radio.fit import FitOptions, fit_channel
from stlc.radio.gp import UNHEARD, ChannelModel, condition
from stlc.radio.link_budget import z_quantile
from stlc.radio.link_ends import LinkEnds
from stlc.radio.pairs import predict_pairs
from stlc.radio.partition import grid
from stlc.radio.samples import Samples, make_samples
from stlc.radio.table import bound_ends

RNG = np.random.default_rng(5)
ANCHORS = RNG.uniform(0, 20, (12, 2))


def _world(seed: int, spread: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Links from 25 places to each anchor, their strengths, the anchor's number: offsets and
    deviations drawn, three packets of each link."""
    rng = np.random.default_rng(seed)
    true = replace(PAPER_CHANNEL, shadowing=9.0, length=3.0, fading=4.0, deviation=4.0)
    links = np.array([[*p, *a] for p in rng.uniform(0, 20, (25, 2)) for a in ANCHORS])
    number = np.tile(np.arange(len(ANCHORS)), 25)
    level = replace(true, fading=0.0).sample_prior(links, rng)
    level += np.sqrt(spread) * rng.standard_normal(len(ANCHORS))[number]
    packets = level + 2.0 * rng.standard_normal((3, len(level)))
    return np.tile(links, (3, 1)), packets.ravel(), np.tile(number, 3)


def test_links_that_were_never_measured_are_covered() -> None:
    """Between transmitters and receivers that no sample joins, the interval holds what every link
    has of its own: 90 % intervals hold about 90 %."""
    inside, narrow = [], []
    for seed in range(4):
        links, rssi, number = _world(seed, 0.0)
        seen = number < 8
        model = fit_channel(make_samples(links[seen], rssi[seen]), FitOptions(restarts=1)).model
        mean, variance = model.predict(links[~seen], True)
        off = np.abs(rssi[~seen] - mean)
        inside.append((off <= z_quantile(0.95) * np.sqrt(variance)).mean())
        narrow.append((off <= z_quantile(0.95) * np.sqrt(variance - model.deviation)).mean())
    assert 0.86 <= np.mean(inside) <= 0.96
    assert np.mean(narrow) < np.mean(inside) - 0.02  # without the links' own deviation


def test_receivers_that_were_never_heard_are_as_uncertain_as_receivers_differ() -> None:
    links, rssi, number = _world(1, 16.0)
    names = tuple(f"anchor{k}" for k in range(8))
    seen = number < 8
    floor = np.full(int(seen.sum()), -np.inf)
    samples = Samples(links[seen], rssi[seen], floor, number[seen], names)
    model = fit_channel(samples, FitOptions(receiver_offsets=True, restarts=1)).model
    assert 4.0 < model.offset_spread < 60.0
    assert receiver(model, ("robot", "anchor3")) == "anchor3"
    assert receiver(model, ("robot", "new")) == UNHEARD
    at = links[:1]
    known, new = (model.predict(at, False, name)[1][0] for name in ("anchor3", UNHEARD))
    assert new - known > 0.5 * model.offset_spread
    mean, variance = model.predict(links[~seen], True, UNHEARD)
    off = np.abs(rssi[~seen] - mean)
    assert (off <= z_quantile(0.975) * np.sqrt(variance)).mean() > 0.85


@pytest.mark.parametrize("name", ["mast", UNHEARD])
def test_bounds_over_cells_know_how_far_off_receivers_may_be(name: str) -> None:
    model = condition(PAPER_CHANNEL, make_samples(RNG.uniform(0, 5, (6, 4)), RNG.normal(-40, 4, 6)))
    model = replace(
        model, offsets=(("mast", 3.0),), offset_variances=(("mast", 5.0),), offset_spread=9.0
    )
    ends = LinkEnds(grid([0.0, 1.0, 2.0], [0.0, 1.0, 2.0]), np.array([4.0, 4.0]), None, name)
    found = bound_ends(model, ends, 1.0)
    boxes, place = ends.boxes()
    for _ in range(10):
        points = boxes.centre + RNG.uniform(-1, 1, boxes.centre.shape) * boxes.half
        mean, variance = predict_pairs(model, points, place.centre, True, name)
        sigma = np.sqrt(variance)
        assert (found.sigma[0] <= sigma + 1e-9).all()
        assert (sigma <= found.sigma[1] + 1e-9).all()
        assert (found.level[0] <= mean - sigma + 1e-9).all()


def test_no_offsets_no_spread() -> None:
    assert receiver(ChannelModel(-40.0, 2.0, 1.0, 1.0, 1.0), ("a", "b")) is None
