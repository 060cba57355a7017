from dataclasses import replace

import numpy as np
import pytest
from support.radio import conditioned, uniform_links

from stlc.radio.evaluate import approximation_error
from stlc.radio.evidence import Evidence
from stlc.radio.gp import condition
from stlc.radio.nearest import NearestForecast
from stlc.radio.pathloss import swap_ends
from stlc.radio.samples import make_samples

MODEL = replace(conditioned(10)[0], posterior=None)


def evidence(count, seed):
    rng = np.random.default_rng(seed)
    links = uniform_links(count, seed)
    links[0, 2:] = links[0, :2]  # its own mirror image: found twice
    samples = make_samples(links, MODEL.sample_prior(links, rng))
    noise = np.full(count, MODEL.fading)
    return Evidence(links, samples.rssi - MODEL.mean(links), noise), condition(MODEL, samples)


def test_with_all_links_as_neighbours_it_is_exact():
    known, exact = evidence(40, 3)
    forecast = NearestForecast(MODEL, known, 80)
    asked = np.vstack([uniform_links(25, 9), known.links[:3]])
    for fading in (False, True):
        for got, expected in zip(
            forecast.predict(asked, fading), exact.predict(asked, fading), strict=True
        ):
            np.testing.assert_allclose(got, expected, atol=1e-5)


def test_exchanging_the_ends_changes_nothing():
    known, _ = evidence(60, 4)
    forecast = NearestForecast(MODEL, known, 12)
    asked = uniform_links(20, 5)
    for got, expected in zip(
        forecast.predict(asked, False), forecast.predict(swap_ends(asked), False), strict=True
    ):
        np.testing.assert_allclose(got, expected, atol=1e-9)


def test_more_neighbours_come_closer_to_exact():
    known, _ = evidence(120, 6)
    gaps = [
        approximation_error(NearestForecast(MODEL, known, k), MODEL, known) for k in (4, 30, 240)
    ]
    assert gaps[0].mean > gaps[1].mean > gaps[2].mean
    assert gaps[0].sigma > gaps[1].sigma
    assert gaps[2].mean == pytest.approx(0.0, abs=1e-4)
