import numpy as np
import pytest
from sklearn.gaussian_process import GaussianProcessRegressor
from sklearn.gaussian_process.kernels import RBF, ConstantKernel
from support.radio import conditioned, uniform_links

from stlc.radio.errors import RadioError
from stlc.radio.gp import ChannelModel, condition, condition_on, evidence_for
from stlc.radio.pairs import predict_pairs
from stlc.radio.pathloss import swap_ends
from stlc.radio.posterior import choose_centres
from stlc.radio.samples import make_samples, merge


def test_agrees_with_scikit_learn_on_links_far_from_their_mirror():
    # senders near the origin, receivers 500 m away: the crossed term vanishes
    rng = np.random.default_rng(2)
    y = np.hstack([rng.uniform(-5, 5, (60, 2)), rng.uniform(-5, 5, (60, 2)) + 500.0])
    model = ChannelModel(-12.89, 3.0, 4.0, 9.0, 2.5)
    z = model.sample_prior(y, rng)
    oracle = GaussianProcessRegressor(
        ConstantKernel(9.0, "fixed") * RBF(2.5, "fixed"), alpha=4.0, optimizer=None
    )
    oracle.fit(y, z - model.mean(y))
    asked = np.hstack([rng.uniform(-6, 6, (30, 2)), rng.uniform(-6, 6, (30, 2)) + 500.0])
    mean, spread = oracle.predict(asked, return_std=True)
    got, variance = condition(model, make_samples(y, z)).predict(asked, fading=False)
    np.testing.assert_allclose(got - model.mean(asked), mean, atol=1e-5)
    np.testing.assert_allclose(np.sqrt(variance), spread, atol=1e-5)


def test_fading_adds_its_variance_and_swapping_changes_nothing():
    model, _ = conditioned()
    asked = uniform_links(20, 8)
    mean, variance = model.predict(asked, fading=False)
    packet_mean, packet = model.predict(swap_ends(asked), fading=True)
    np.testing.assert_allclose(packet_mean, mean, atol=1e-9)
    np.testing.assert_allclose(packet, variance + model.fading, atol=1e-9)
    assert (variance <= model.shadowing + 1e-9).all()


def test_repeated_and_mirrored_links_are_merged_exactly():
    model, samples = conditioned(12)
    again = np.vstack([samples.links, swap_ends(samples.links[:5]), samples.links[:2]])
    level = np.append(samples.rssi, samples.rssi[:7] + np.arange(7.0))
    merged = merge(make_samples(again, level))
    assert len(merged.samples) == 12
    assert merged.count.sum() == 19
    prior = ChannelModel(model.l0, model.exponent, model.fading, model.shadowing, model.length)
    raw = make_samples(again, level)
    unmerged = condition_on(prior, evidence_for(prior, raw, level, np.full(19, model.fading)), 100)
    asked = uniform_links(15, 4)
    for got, expected in zip(
        condition(prior, raw).predict(asked, True), unmerged.predict(asked, True), strict=True
    ):
        np.testing.assert_allclose(got, expected, atol=1e-5)


def test_pair_prediction_equals_link_prediction():
    model, _ = conditioned()
    rng = np.random.default_rng(0)
    a, b = rng.uniform(-5, 5, (7, 2)), rng.uniform(-5, 5, (9, 2))
    b[0] = a[0]
    mean, variance = predict_pairs(model, a, b, True)
    links = np.hstack([np.repeat(a, 9, axis=0), np.tile(b, (7, 1))])
    expected = model.predict(links, True)
    np.testing.assert_allclose(mean.ravel(), expected[0], atol=1e-9)
    np.testing.assert_allclose(variance.ravel(), expected[1], atol=1e-9)


def test_inducing_links_approach_exact_conditioning(monkeypatch):
    model, samples = conditioned(300, seed=1)
    asked = uniform_links(50, 2)
    prior = ChannelModel(model.l0, model.exponent, model.fading, model.shadowing, model.length)
    monkeypatch.setattr("stlc.radio.gp.EXACT_LIMIT", 100)
    close = condition(prior, samples, most_centres=300)
    coarse = condition(prior, samples, most_centres=40)
    assert close.posterior is not None
    assert not close.posterior.exact
    exact = model.predict(asked, False)
    errors = [np.abs(m.predict(asked, False)[0] - exact[0]).max() for m in (close, coarse)]
    assert errors[0] < 0.2 < errors[1]
    # a coarse approximation is less sure, not falsely sure
    assert coarse.predict(asked, False)[1].mean() > exact[1].mean()


def test_chosen_centres_are_distinct_and_stop_when_nothing_is_left():
    model, samples = conditioned(50)
    twice = np.vstack([samples.links, samples.links])
    rows = choose_centres(twice, model.length, model.kernel, 100, tolerance=1e-6)
    assert len(np.unique(rows)) == len(rows) <= 50


def test_prior_draws_are_reproducible_and_have_the_stated_spread():
    y = uniform_links(5, 1)
    model = ChannelModel(-12.89, 3.0, 4.0, 9.0, 2.0)
    draws = [model.sample_prior(y, np.random.default_rng(s)) for s in range(3000)]
    np.testing.assert_array_equal(draws[7], model.sample_prior(y, np.random.default_rng(7)))
    np.testing.assert_allclose(np.var(draws, axis=0), 13.0, rtol=0.12)
    np.testing.assert_allclose(np.mean(draws, axis=0), model.mean(y), atol=0.3)


def test_three_dimensional_links_and_receiver_offsets():
    model = ChannelModel(-40.0, 2.0, 4.0, 9.0, 1.0, offsets=(("a", 3.0), ("b", -3.0)))
    y = np.array([[0.0, 0.0, 0.0, 3.0, 0.0, 4.0]])
    assert model.mean(y, "a")[0] == pytest.approx(-40.0 - 20.0 * np.log10(5.0) + 3.0)
    with pytest.raises(RadioError, match="no receiver 'c'; known: a, b"):
        model.mean(y, "c")


@pytest.mark.parametrize(
    ("field", "value"), [("fading", -1.0), ("length", 0.0), ("d0", 0.0), ("l0", np.nan)]
)
def test_impossible_parameters_are_refused(field, value):
    good = dict(l0=-12.0, exponent=3.0, fading=1.0, shadowing=1.0, length=1.0)
    with pytest.raises(RadioError, match=field):
        ChannelModel(**{**good, field: value})


def test_samples_at_one_place_and_contradicting_ones():
    """At no distance the strength is that at d0; equal links without fading give their mean."""
    place = np.array([[1.0, 2.0, 1.0, 2.0]])
    model = ChannelModel(-40.0, 2.0, 4.0, 9.0, 2.0)
    known = condition(model, make_samples(np.repeat(place, 3, axis=0), np.array([-45.0, -41, -43])))
    mean, variance = known.predict(place, False)
    weight = 9.0 / (9.0 + 4.0 / 3.0)
    assert mean[0] == pytest.approx(-40.0 + weight * -3.0, abs=1e-6)
    assert variance[0] == pytest.approx(9.0 * (1.0 - weight), abs=1e-6)
    still = condition(
        ChannelModel(-40.0, 2.0, 0.0, 9.0, 2.0),
        make_samples(np.repeat(place, 2, axis=0), np.array([-48.0, -44.0])),
    )
    mean, variance = still.predict(place, True)
    assert mean[0] == pytest.approx(-46.0, abs=1e-4)
    assert 0.0 <= variance[0] < 1e-4
