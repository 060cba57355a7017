import numpy as np
import pytest
from scipy.stats import norm

from stlc.radio.errors import FitError
from stlc.radio.evaluate import hold_out, split_samples
from stlc.radio.fit import FitOptions, fit_channel, mean_features
from stlc.radio.gp import ChannelModel
from stlc.radio.likelihood import evaluate
from stlc.radio.pathloss import swap_ends
from stlc.radio.problem import Problem, make_blocks
from stlc.radio.samples import Samples, make_samples, merge
from stlc.radio.sites import initial_sites
from stlc.radio.tobit import mills

TRUTH = ChannelModel(-12.89, 3.0, 4.0, 20.0, 2.0)


def anchored(count, seed, anchors=5):
    """Links from places in a square to a few fixed receivers, with their strengths."""
    rng = np.random.default_rng(seed)
    places = rng.uniform(-5, 5, (anchors, 2))
    which = rng.integers(anchors, size=count)
    links = np.hstack([rng.uniform(-5, 5, (count, 2)), places[which]])
    return make_samples(links, TRUTH.sample_prior(links, rng)), which


def problem(samples, size=1000):
    merged = merge(samples)
    features = mean_features(merged.samples, FitOptions())
    blocks = make_blocks(merged.samples.links, size)
    return Problem(merged, features, blocks, TRUTH.kernel, ("fading", "shadowing", "length"))


@pytest.mark.parametrize("floor", [None, -30.0])
@pytest.mark.parametrize("size", [1000, 25])
def test_gradient_matches_finite_differences(floor, size):
    samples, _ = anchored(70, 1)
    doubled = make_samples(
        np.vstack([samples.links, swap_ends(samples.links[:20])]),
        np.append(samples.rssi, samples.rssi[:20] + 1.0),
    )
    task = problem(doubled if floor is None else doubled.with_floor(floor), size)
    theta = np.log([3.0, 15.0, 1.5])
    sites = initial_sites(task, 3.0, 20.0)
    got = evaluate(task, theta, sites)
    for k, step in enumerate(np.eye(3) * 1e-4):
        up, down = (evaluate(task, theta + s, sites).value for s in (step, -step))
        assert got.gradient[k] == pytest.approx((up - down) / 2e-4, rel=2e-3, abs=5e-3)


def test_merged_likelihood_is_the_likelihood_of_all_samples():
    samples, _ = anchored(30, 2)
    links = np.vstack([samples.links, samples.links[:10]])
    level = np.append(samples.rssi, samples.rssi[:10] + 2.0)
    theta = np.log([4.0, 20.0, 2.0])
    task = problem(make_samples(links, level))
    got = evaluate(task, theta, initial_sites(task, 4.0, 20.0))
    covariance = TRUTH.covariance(links) + 4.0 * np.eye(40)
    features = mean_features(make_samples(links, level), FitOptions())
    residual = level - features @ got.coefficients
    sign, log_det = np.linalg.slogdet(2.0 * np.pi * covariance)
    expected = -0.5 * residual @ np.linalg.solve(covariance, residual) - 0.5 * log_det
    assert sign > 0
    assert got.likelihood == pytest.approx(expected, abs=1e-3)


def test_known_parameters_are_recovered_within_their_errors():
    samples, _ = anchored(300, 5)
    fit = fit_channel(samples)
    error = dict(fit.standard_errors)
    assert abs(fit.model.exponent - 3.0) < 4.0 * error["exponent"]
    for name, truth in (("fading", 4.0), ("shadowing", 20.0), ("length", 2.0)):
        distance = abs(np.log(getattr(fit.model, name) / truth))
        assert distance < 4.0 * error[f"log_{name}"] < 2.0
    assert fit.log_likelihood > fit.log_likelihood_path_loss + 50.0


def test_standard_errors_are_the_spread_of_refitted_draws():
    """Parametric bootstrap: draws of one channel on the same links, each fitted."""
    base, _ = anchored(120, 9)
    rng = np.random.default_rng(10)
    draws = [make_samples(base.links, TRUTH.sample_prior(base.links, rng)) for _ in range(24)]
    fits = [fit_channel(draw, FitOptions(restarts=1)) for draw in draws]
    names = ("l0", "exponent", "log_fading", "log_shadowing", "log_length")
    found = np.array([[*_parameters(fit.model)] for fit in fits])
    claimed = np.array([[dict(fit.standard_errors)[n] for n in names] for fit in fits])
    ratio = np.median(claimed, axis=0) / found.std(axis=0, ddof=1)
    assert ((ratio > 0.6) & (ratio < 1.6)).all(), ratio


def _parameters(model):
    logs = np.log([model.fading, model.shadowing, model.length])
    return model.l0, model.exponent, *logs


def test_forecast_beats_path_loss_and_is_calibrated():
    samples, _ = anchored(400, 6)
    training, held = split_samples(samples, 0.3, 0)
    fit = fit_channel(training)
    channel, alone = hold_out(fit.model, held), hold_out(fit.path_loss, held)
    assert channel.rmse < 0.85 * alone.rmse
    assert channel.log_score > alone.log_score
    assert dict(channel.coverage)[0.9] == pytest.approx(0.9, abs=0.09)


def test_censoring_is_corrected_where_dropping_or_clamping_is_biased():
    samples, _ = anchored(250, 7)
    full = fit_channel(samples).model
    floor = float(np.median(samples.rssi))
    hidden = samples.with_floor(floor)
    clamped = make_samples(samples.links, np.maximum(samples.rssi, floor))
    censored, wrong = fit_channel(hidden).model, fit_channel(clamped).model
    lost = np.flatnonzero(samples.rssi < floor)
    asked = samples.links[lost]
    truth = full.predict(asked, False)[0]
    errors = [
        np.sqrt(((m.predict(asked, False)[0] - truth) ** 2).mean()) for m in (censored, wrong)
    ]
    assert errors[0] < 0.7 * errors[1]
    assert abs(censored.exponent - full.exponent) < abs(wrong.exponent - full.exponent)


def test_receiver_offsets_are_found_up_to_their_mean_and_a_little_shrinkage():
    samples, which = anchored(250, 8)
    shift = np.array([6.0, -6.0, 3.0, -3.0, 0.0])
    named = Samples(
        samples.links, samples.rssi + shift[which], samples.floor, which, tuple("abcde")
    )
    plain, fit = fit_channel(samples), fit_channel(named, FitOptions(receiver_offsets=True))
    assert sum(v for _, v in fit.model.offsets) == pytest.approx(0.0, abs=1e-5)
    base = fit_channel(
        Samples(samples.links, samples.rssi, samples.floor, which, tuple("abcde")),
        FitOptions(receiver_offsets=True),
    )
    found = np.array([v for _, v in fit.model.offsets])
    without = np.array([v for _, v in base.model.offsets])
    np.testing.assert_allclose(found - without, shift, atol=1.0)
    assert fit.model.fading == pytest.approx(plain.model.fading, rel=0.5)


def test_blocks_cover_every_row_once():
    blocks = make_blocks(np.random.default_rng(0).normal(size=(1000, 4)), 90)
    assert max(map(len, blocks)) <= 90
    np.testing.assert_array_equal(np.sort(np.concatenate(blocks)), np.arange(1000))


def test_samples_that_fix_no_channel_are_refused():
    links = np.random.default_rng(0).uniform(size=(20, 4))
    with pytest.raises(FitError, match="at least 8"):
        fit_channel(make_samples(links[:5], np.zeros(5)))
    with pytest.raises(FitError, match="noise floor"):
        fit_channel(make_samples(links, np.zeros(20)).with_floor(1.0))
    links[:, 2:] = links[:, :2] + [1.0, 0.0]
    with pytest.raises(FitError, match="same length"):
        fit_channel(make_samples(links, np.arange(20.0)))


def test_mills_ratio_far_below_is_minus_t():
    t = np.array([-1e9, -1.0001e4, -9.999e3, -3.0, 5.0])
    log_cdf, ratio = mills(t)
    np.testing.assert_allclose(ratio[:3], -t[:3], rtol=2e-8)
    np.testing.assert_allclose(ratio[3:], np.exp(norm.logpdf(t[3:]) - norm.logcdf(t[3:])))
    assert np.isfinite(log_cdf).all()
