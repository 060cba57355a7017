"""Senders and receivers of two kinds: kernels that tell the ends of a link apart."""

from dataclasses import replace

import numpy as np
import pytest

from stlc.radio.bounds import pair_bounds
from stlc.radio.errors import RadioError
from stlc.radio.evaluate import hold_out, split_samples
from stlc.radio.fit import FitOptions, fit_channel, fit_directed
from stlc.radio.gp import ChannelModel
from stlc.radio.kernel import DIRECTED, KernelName
from stlc.radio.nearest import NearestForecast
from stlc.radio.pairs import predict_pairs
from stlc.radio.pathloss import swap_ends
from stlc.radio.samples import make_samples
from stlc.radio.taylor import Boxes

ROOFS = np.random.default_rng(0).uniform(0, 20, (12, 2))


def ground_to_roofs(count, seed, kernel=KernelName.EXPONENTIAL):
    """Links from the ground to roofs above it: what shadows the one end doesn't the other."""
    rng = np.random.default_rng(seed)
    truth = ChannelModel(-40.0, 2.5, 2.0, 30.0, 6.0, kernel=kernel)
    links = np.hstack([rng.uniform(0, 20, (count, 2)), ROOFS[rng.integers(12, size=count)]])
    return make_samples(links, truth.sample_prior(links, rng))


@pytest.mark.parametrize("kernel", DIRECTED)
def test_the_kernel_of_directed_links_is_found_and_forecasts_better(kernel):
    training, held = split_samples(ground_to_roofs(600, 1, kernel), 1 / 3, 0)
    symmetric = fit_channel(training)
    directed = fit_directed(training, symmetric, FitOptions())
    assert directed is not None
    assert directed.model.kernel is kernel
    assert directed.restricted > symmetric.restricted + 2.0
    one, other = (hold_out(fit.forecast, held) for fit in (directed, symmetric))
    assert one.rmse < other.rmse
    assert one.log_score > other.log_score


def test_symmetric_links_stay_symmetric():
    one_way = ground_to_roofs(300, 3, KernelName.SYMMETRISED)
    assert fit_directed(one_way, fit_channel(one_way), FitOptions()) is None
    links = np.vstack([one_way.links[:40], swap_ends(one_way.links[:40])])
    both = make_samples(links, np.tile(one_way.rssi[:40], 2))
    assert one_way.directed
    assert not both.directed
    assert fit_directed(both, fit_channel(both), FitOptions()) is None


@pytest.mark.parametrize("kernel", DIRECTED)
def test_nearest_links_and_pairs_forecast_as_all_links_do(kernel):
    samples = ground_to_roofs(80, 4)
    fit = fit_channel(samples, FitOptions(kernel=kernel))
    nearest = NearestForecast(replace(fit.model, posterior=None), fit.evidence, 80)
    asked = ground_to_roofs(20, 5).links
    exact = fit.model.predict(asked, True)
    for got, wanted in zip(nearest.predict(asked, True), exact, strict=True):
        np.testing.assert_allclose(got, wanted, atol=1e-4)
    mean, variance = predict_pairs(fit.model, asked[:, :2], asked[:, 2:], True)
    np.testing.assert_allclose(np.diag(mean), exact[0], atol=1e-9)
    np.testing.assert_allclose(np.diag(variance), exact[1], atol=1e-9)


def test_directed_channels_have_no_bounds_over_cells():
    model = ChannelModel(-40.0, 2.5, 2.0, 30.0, 6.0, kernel=KernelName.DIRECTED)
    cells = Boxes(np.zeros((1, 2)), np.ones((1, 2)))
    with pytest.raises(RadioError, match="directed has no rigorous bounds"):
        pair_bounds(model, cells)
