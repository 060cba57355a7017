"""Repeats and both directions of one link: fading within links, a deviation of each link."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.linalg import null_space
from scipy.stats import multivariate_normal

from stlc.radio.evaluate import hold_out, split_samples
from stlc.radio.fit import FitOptions, fit_channel, mean_features
from stlc.radio.gp import ChannelModel, condition
from stlc.radio.likelihood import evaluate
from stlc.radio.link_budget import z_quantile
from stlc.radio.pairs import predict_pairs
from stlc.radio.pathloss import swap_ends
from stlc.radio.problem import make_problem
from stlc.radio.report import FitSummary, format_summary
from stlc.radio.samples import Samples, link_numbers, make_samples, merge
from stlc.radio.sites import initial_sites

TRUTH = ChannelModel(-40.0, 2.5, fading=2.0, shadowing=20.0, length=3.0, deviation=6.0)
THETA = np.log([3.0, 15.0, 2.0, 5.0])
OFFSET = 7.0


def anchored(count, seed):
    """Links from places in a square to one of five fixed ends."""
    rng = np.random.default_rng(seed)
    ends = np.array([[0.0, 0.0], [20.0, 0.0], [10.0, 10.0], [0.0, 20.0], [20.0, 20.0]])
    return np.hstack([rng.uniform(0, 20, (count, 2)), ends[rng.integers(5, size=count)]])


def unequal(count, seed):
    """Links, all in both directions, some of them one to three times more."""
    links = anchored(count, seed)
    third = count // 3
    return np.vstack([links, swap_ends(links), links[:third], links[: third // 2], links[:2]])


def drawn(links, seed, model=TRUTH):
    return make_samples(links, model.sample_prior(links, np.random.default_rng(seed)))


def problem(samples, options, size=1000):
    merged = merge(samples)
    features = mean_features(merged.samples, options)
    return make_problem(merged, features, size, TRUTH.kernel)


def dense_covariance(links, theta):
    """Sample by sample, without merging anything."""
    fading, shadowing, length, deviation = np.exp(theta)
    model = ChannelModel(-40.0, 2.0, 1.0, shadowing, length)
    number = link_numbers(links)
    same = number[:, None] == number[None, :]
    return model.covariance(links) + deviation * same + fading * np.eye(len(links))


@pytest.mark.parametrize("offsets", [False, True])
def test_likelihood_is_that_of_all_samples_one_by_one(offsets):
    """Restricted: that of contrasts K z, K the null space of the fixed effects' columns; offsets
    are part of the covariance."""
    samples, options, theta = (
        named(24, 1) if offsets else (drawn(unequal(24, 1), 2), FitOptions(), THETA)
    )
    task = problem(samples, options)
    got = evaluate(task, theta, initial_sites(task, 3.0, 20.0))
    features = mean_features(samples, options)
    fixed, random = features[:, :2], features[:, 2:]
    covariance = dense_covariance(samples.links, THETA) + OFFSET * random @ random.T
    mean = fixed @ got.coefficients[:2]
    expected = multivariate_normal(mean, covariance).logpdf(samples.rssi)
    assert got.likelihood == pytest.approx(expected, abs=1e-3)
    contrasts = null_space(fixed.T).T
    spread = contrasts @ covariance @ contrasts.T
    density = multivariate_normal(np.zeros(len(spread)), spread).logpdf(contrasts @ samples.rssi)
    volume = 0.5 * np.linalg.slogdet(fixed.T @ fixed)[1]
    assert got.value == pytest.approx(density - volume, abs=1e-3)


def named(count, seed):
    """Samples of three receivers and one that hears nothing; theta with the offsets' variance."""
    links = unequal(count, seed)
    plain = drawn(links, seed + 1)
    receiver = np.arange(len(links), dtype=np.intp) % 3
    samples = Samples(links, plain.rssi, plain.floor, receiver, tuple("abcd"))
    return samples, FitOptions(receiver_offsets=True), np.append(THETA, np.log(OFFSET))


@pytest.mark.parametrize("offsets", [False, True])
@pytest.mark.parametrize("floor", [None, -75.0])
@pytest.mark.parametrize("size", [1000, 12])
def test_gradient_matches_finite_differences(offsets, floor, size):
    samples, options, theta = (
        named(30, 3) if offsets else (drawn(unequal(30, 3), 4), FitOptions(), THETA)
    )
    task = problem(samples if floor is None else samples.with_floor(floor), options, size)
    sites = initial_sites(task, 3.0, 20.0)
    got = evaluate(task, theta, sites)
    for k, step in enumerate(np.eye(len(theta)) * 1e-4):
        up, down = (evaluate(task, theta + s, sites).value for s in (step, -step))
        assert got.gradient[k] == pytest.approx((up - down) / 2e-4, rel=2e-3, abs=5e-3)


def test_offsets_are_shrunk_and_that_of_an_unheard_receiver_is_none():
    """Offsets of twelve receivers, one heard by two samples, the last by none."""
    rng = np.random.default_rng(27)
    links = anchored(200, 28)
    receiver = rng.integers(10, size=200).astype(np.intp)
    receiver[:2] = 10
    shift = np.append(rng.normal(0.0, 6.0, 11), 0.0)
    strength = drawn(links, 29).rssi + shift[receiver]
    names = tuple(f"r{k}" for k in range(12))
    plain = make_samples(links, strength)
    samples = Samples(links, strength, plain.floor, receiver, names)
    model = fit_channel(samples, FitOptions(receiver_offsets=True)).model
    found = np.array([v for _, v in model.offsets])
    spread = np.array([v for _, v in model.offset_variances])
    error = (found - shift)[:11] - (found - shift)[:11].mean()
    assert (np.abs(error) < 3.5 * np.sqrt(spread[:11])).all()
    assert found[11] == pytest.approx(0.0, abs=1e-9)
    assert sum(found) == pytest.approx(0.0, abs=1e-4)
    assert spread[:10].max() < spread[10] < spread[11]
    assert spread[11] == pytest.approx(shift[:11].var(), rel=0.7)
    known, unheard = (model.predict(links[:1], True, n)[1] for n in ("r3", "r11"))
    assert (unheard - known)[0] == pytest.approx(spread[11] - spread[3])


def test_known_parameters_are_recovered_within_their_errors():
    fit = fit_channel(drawn(unequal(200, 5), 6))
    error = dict(fit.standard_errors)
    assert abs(fit.model.exponent - TRUTH.exponent) < 3.5 * error["exponent"]
    for name in ("fading", "deviation", "shadowing", "length"):
        distance = abs(np.log(getattr(fit.model, name) / getattr(TRUTH, name)))
        assert distance < 3.5 * error[f"log_{name}"] < 2.0
    assert (fit.samples, fit.links) == (501, 200)


def test_blocks_recover_the_parameters_too(monkeypatch):
    monkeypatch.setattr("stlc.radio.fit.EXACT_ROWS", 200)
    monkeypatch.setattr("stlc.radio.fit.BLOCK_ROWS", 150)
    fit = fit_channel(drawn(unequal(500, 7), 8))
    for name in ("fading", "deviation", "shadowing", "length"):
        assert getattr(fit.model, name) == pytest.approx(getattr(TRUTH, name), rel=0.5)


def test_conditioning_is_that_on_all_samples_one_by_one():
    links = unequal(30, 9)
    samples = drawn(links, 10)
    asked = np.random.default_rng(11).uniform(0, 20, (15, 4))
    theta = np.log([TRUTH.fading, TRUTH.shadowing, TRUTH.length, TRUTH.deviation])
    everything = np.vstack([asked, links])
    joint = dense_covariance(everything, theta)
    gain = np.linalg.solve(joint[15:, 15:], joint[15:, :15]).T
    mean = TRUTH.mean(asked) + gain @ (samples.rssi - TRUTH.mean(links))
    variance = np.diag(joint[:15, :15] - gain @ joint[15:, :15])
    known = condition(TRUTH, samples)
    got = known.predict(asked, True)
    np.testing.assert_allclose(got[0], mean, atol=1e-5)
    np.testing.assert_allclose(got[1], variance, atol=1e-5)
    np.testing.assert_allclose(known.predict(asked, False)[1], variance - TRUTH.fading, atol=1e-5)


def test_one_packets_chance_counts_deviation_and_fading():
    """Shares of packets on many new links, each heard once, beyond the level of P >= 0.9."""
    known = condition(TRUTH, drawn(unequal(25, 12), 13))
    a, b = np.array([[3.0, 4.0]]), np.array([[9.0, 8.0]])
    mean, variance = predict_pairs(known, a, b, True)
    shadow = replace(known, deviation=0.0).predict(np.hstack([a, b]), False)[1]
    rng = np.random.default_rng(14)
    spread = np.sqrt([shadow[0], TRUTH.deviation, TRUTH.fading])
    packets = mean[0, 0] + (rng.standard_normal((200_000, 3)) * spread).sum(1)
    level = mean[0, 0] - z_quantile(0.9) * np.sqrt(variance[0, 0])
    assert (packets >= level).mean() == pytest.approx(0.9, abs=0.004)


def test_receivers_without_offsets_do_not_part_the_directions_of_a_link():
    links = anchored(60, 15)
    both = np.vstack([links, swap_ends(links)])
    plain = drawn(both, 16)
    receiver = np.repeat(np.arange(2, dtype=np.intp), 60)
    named = Samples(both, plain.rssi, plain.floor, receiver, ("a", "b"))
    one, other = fit_channel(plain).model, fit_channel(named).model
    assert other.fading == pytest.approx(one.fading, rel=1e-6)
    with_offsets = fit_channel(named, FitOptions(receiver_offsets=True))
    assert with_offsets.model.deviation == pytest.approx(one.deviation, rel=0.2)
    assert with_offsets.links == 60


def test_both_directions_do_not_worsen_the_forecast():
    links = anchored(300, 17)
    both = drawn(np.vstack([links, swap_ends(links)]), 18)
    training, held = split_samples(both, 1 / 3, 0)
    half = training.take(np.unique(link_numbers(training.links), return_index=True)[1])
    fit, fit_half = fit_channel(training), fit_channel(half)
    scores = hold_out(fit.model, held), hold_out(fit_half.model, held)
    assert scores[0].rmse < 1.01 * scores[1].rmse
    assert scores[0].log_score > scores[1].log_score - 0.01
    assert fit.model.fading == pytest.approx(TRUTH.fading, rel=0.3)
    assert dict(scores[0].coverage)[0.9] == pytest.approx(0.9, abs=0.06)


def test_copies_change_nothing():
    samples = drawn(anchored(150, 19), 20)
    doubled = make_samples(
        np.vstack([samples.links, swap_ends(samples.links)]), np.tile(samples.rssi, 2)
    )
    for floor in (-np.inf, -80.0):
        once = fit_channel(samples.with_floor(floor))
        twice = fit_channel(doubled.with_floor(floor))
        assert twice.model.fading == pytest.approx(once.model.fading, rel=1e-3)
        assert twice.model.deviation == 0.0
        assert any("copies" in note for note in twice.notes)
        assert not any("copies" in note for note in once.notes)


def test_nearly_equal_repeats_leave_the_spread_of_one_packet():
    """Repeats that hardly differ: fading goes to its limit, the sum stays right."""
    samples = drawn(anchored(150, 21), 22)
    close = samples.rssi + np.where(np.arange(150) % 2, 0.002, -0.002)
    links = np.vstack([samples.links, samples.links])
    twice = fit_channel(make_samples(links, np.append(samples.rssi, close)))
    once = fit_channel(samples).model
    assert twice.model.own_variance(True) == pytest.approx(once.own_variance(True), rel=0.02)
    error = dict(twice.standard_errors)
    assert np.isinf(error["log_fading"])
    assert error["log_deviation"] < 1.0


def test_report_names_the_deviation_only_where_it_is_known():
    assert "measured twice" not in report(drawn(unequal(40, 23), 24))
    once = report(drawn(anchored(40, 25), 26))
    assert "no link was measured twice" in once


def report(samples):
    fit = fit_channel(samples)
    channel, alone = hold_out(fit.model, samples), hold_out(fit.path_loss, samples)
    return format_summary(FitSummary(fit, samples, samples, channel, alone, ()))
