"""Forecasts of held-back links beside scikit-learn's Gaussian process with white noise."""

import numpy as np
import pytest
from sklearn.gaussian_process import GaussianProcessRegressor
from sklearn.gaussian_process.kernels import RBF, WhiteKernel

from stlc.radio.evaluate import hold_out, split_samples
from stlc.radio.fit import FitOptions, fit_channel, mean_features
from stlc.radio.gp import ChannelModel
from stlc.radio.pathloss import swap_ends
from stlc.radio.samples import make_samples

TRUTH = ChannelModel(-40.0, 2.5, fading=2.0, shadowing=20.0, length=3.0, deviation=4.0)


def anchored(count, seed):
    rng = np.random.default_rng(seed)
    ends = np.array([[0.0, 0.0], [20.0, 0.0], [10.0, 10.0], [0.0, 20.0], [20.0, 20.0]])
    return np.hstack([rng.uniform(0, 20, (count, 2)), ends[rng.integers(5, size=count)]])


def theirs(training, held):
    features = mean_features(training, FitOptions())
    loss, *_ = np.linalg.lstsq(features, training.rssi, rcond=None)
    kernel = 15.0 * RBF(4.0, (0.1, 100.0)) + WhiteKernel(5.0, (1e-3, 1e3))
    found = GaussianProcessRegressor(kernel).fit(training.links, training.rssi - features @ loss)
    mean, sigma = found.predict(held.links, return_std=True)
    error = held.rssi - mean - mean_features(held, FitOptions()) @ loss
    density = -0.5 * (error / sigma) ** 2 - np.log(sigma) - 0.5 * np.log(2.0 * np.pi)
    return np.sqrt((error**2).mean()), density.mean()


@pytest.mark.filterwarnings("ignore::sklearn.exceptions.ConvergenceWarning")
@pytest.mark.parametrize("kind", ["once", "twice", "both directions"])
def test_no_worse_than_scikit_learn_over_some_draws(kind):
    ours, oracle = [], []
    for seed in range(4):
        links = anchored(240, seed)
        if kind == "both directions":
            links = np.vstack([links, swap_ends(links)])
        samples = make_samples(links, TRUTH.sample_prior(links, np.random.default_rng(seed)))
        if kind == "twice":
            samples = make_samples(np.vstack([links, links]), np.tile(samples.rssi, 2))
        training, held = split_samples(samples, 1 / 3, seed)
        score = hold_out(fit_channel(training).forecast, held)
        ours.append((score.rmse, score.log_score))
        oracle.append(theirs(training, held))
    rmse, density = np.median(ours, axis=0)
    assert rmse < 1.01 * np.median(oracle, axis=0)[0]
    assert density > np.median(oracle, axis=0)[1] - 0.01
