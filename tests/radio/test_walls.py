"""Walls against geometry done otherwise, their bounds over cells, fitted losses."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import shapely

from stlc.places import Outline, Wall
from stlc.radio.bounds import pair_bounds
from stlc.radio.fit import FitOptions, fit_channel
from stlc.radio.gp import ChannelModel, condition
from stlc.radio.pairs import predict_pairs
from stlc.radio.samples import make_samples
from stlc.radio.taylor import Boxes
from stlc.radio.walls import Body, Walls
from stlc.verify.walls import losses

RING = np.array([[1.0, 1.0], [4.0, 1.5], [3.5, 4.0], [1.5, 3.0]])
LINES = np.array([[5.0, 0.0, 5.0, 4.0], [5.0, 4.0, 8.0, 6.0], [0.0, 7.0, 9.0, 8.0]])
WALLS = Walls(
    ("brick", "glass", "core"), np.array([6.0, 2.5, 9.0]), LINES, np.array([0, 0, 1]),
    (Body(2, (RING,)),),
)  # fmt: skip
AS_FILE = {
    "brick": Wall("brick", 6.0, ((5.0, 0.0), (5.0, 4.0), (8.0, 6.0))),
    "glass": Wall("glass", 2.5, ((0.0, 7.0), (9.0, 8.0))),
    "core": Wall("core", 9.0, (), (Outline(tuple(map(tuple, RING))),)),
}


def _counted(links: np.ndarray) -> np.ndarray:
    """Losses by shapely alone."""
    sight = shapely.linestrings(links.reshape(-1, 2, 2))
    total = np.zeros(len(links))
    for line, owner in zip(LINES, WALLS.owner, strict=True):
        total += WALLS.loss[owner] * shapely.crosses(sight, shapely.LineString(line.reshape(2, 2)))
    return total + 9.0 * (shapely.length(shapely.intersection(sight, shapely.Polygon(RING))) > 1e-6)


def test_losses_are_those_of_geometry_done_otherwise() -> None:
    links = np.random.default_rng(1).uniform(0, 10, (3000, 4))
    found = WALLS.attenuation(links)
    np.testing.assert_allclose(found, _counted(links))
    loss = dict(zip(WALLS.names, WALLS.loss, strict=True))
    np.testing.assert_allclose(losses(AS_FILE, loss, links[:, :2], links[:, 2:]), found)
    np.testing.assert_allclose(WALLS.attenuation(links[:, [2, 3, 0, 1]]), found)
    tall = np.insert(np.insert(links, 2, 3.0, axis=1), 5, 0.5, axis=1)
    np.testing.assert_allclose(WALLS.attenuation(tall), found)


def test_a_radio_on_a_wall_is_not_beyond_it() -> None:
    links = np.array([[5.0, 2.0, 3.0, 0.5], [5.0, 2.0, 9.0, 2.0], [5.0 + 1e-5, 2.0, 3.0, 0.5]])
    np.testing.assert_allclose(WALLS.attenuation(links), [0.0, 0.0, 6.0])
    loss = dict(zip(WALLS.names, WALLS.loss, strict=True))
    np.testing.assert_allclose(
        losses(AS_FILE, loss, links[:, :2], links[:, 2:]), WALLS.attenuation(links)
    )
    # in a corner of a line both stretches count; inside a body it counts once
    through = np.array([[4.0, 5.0, 6.0, 3.0], [2.0, 2.0, 2.5, 2.5]])
    np.testing.assert_allclose(WALLS.attenuation(through), [12.0, 9.0])


def _boxes(rng: np.random.Generator, count: int, widest: float) -> Boxes:
    half = rng.uniform(0, widest, (count, 2)) * (rng.random((count, 1)) > 0.2)
    return Boxes(rng.uniform(0, 10, (count, 2)), half)


@pytest.mark.parametrize("seed", range(4))
def test_no_point_of_cells_breaks_the_bounds_and_most_are_tight(seed: int) -> None:
    rng = np.random.default_rng(seed)
    a, b = _boxes(rng, 12, 0.9), _boxes(rng, 12, 0.9)
    ends = [(box.centre - box.half, box.centre + box.half) for box in (a, b)]
    least, most = WALLS.bounds(*ends)
    low, high = np.full_like(least, np.inf), np.full_like(least, -np.inf)
    for _ in range(400):
        pick = [x.centre + x.half * rng.choice([-1, 1, 0.97, rng.uniform(-1, 1)], x.half.shape)
                for x in (a, b)]  # fmt: skip
        value = WALLS.between(*pick)
        low, high = np.minimum(low, value), np.maximum(high, value)
    assert (low >= least - 1e-9).all()
    assert (high <= most + 1e-9).all()
    assert (np.abs(low - least) < 1e-9).mean() > 0.8
    assert (np.abs(high - most) < 1e-9).mean() > 0.8


MODEL = ChannelModel(-20.0, 2.0, 3.0, 6.0, 2.0, walls=WALLS)


@pytest.mark.parametrize("z", [0.0, 1.3])
def test_posteriors_over_cells_heed_walls(z: float) -> None:
    rng = np.random.default_rng(3)
    links = rng.uniform(0, 10, (25, 4))
    model = condition(MODEL, make_samples(links, MODEL.mean(links) + rng.normal(0, 3, 25)))
    bare = replace(model, walls=None)
    np.testing.assert_allclose(
        model.predict(links, True)[0], bare.predict(links, True)[0] - WALLS.attenuation(links)
    )
    a, b = _boxes(rng, 6, 0.6), _boxes(rng, 5, 0.6)
    found = pair_bounds(model, a, b, z=z)
    for _ in range(300):
        pick = [x.centre + x.half * rng.uniform(-1, 1, x.half.shape) for x in (a, b)]
        mean, variance = predict_pairs(model, *pick, True)
        level = mean - z * np.sqrt(variance)
        assert (mean >= found.mean[0] - 1e-6).all()
        assert (mean <= found.mean[1] + 1e-6).all()
        assert (level >= found.level[0] - 1e-6).all()
        assert (level <= found.level[1] + 1e-6).all()
    for one, other in zip(predict_pairs(model, a.centre, b.centre, True),
                          model.predict(_all(a.centre, b.centre), True), strict=True):  # fmt: skip
        np.testing.assert_allclose(one.ravel(), other)


def _all(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    return np.hstack([np.repeat(a, len(b), axis=0), np.tile(b, (len(a), 1))])


def _measured(loss: np.ndarray, seed: int, count: int = 250):
    rng = np.random.default_rng(seed)
    links = rng.uniform(0, 10, (count, 4))
    truth = replace(MODEL, walls=WALLS.with_loss(loss))
    return make_samples(links, truth.sample_prior(links, rng))


def test_losses_are_fitted_with_the_channel() -> None:
    fit = fit_channel(_measured(WALLS.loss, 5), FitOptions(walls=WALLS.with_loss(np.zeros(3))))
    assert fit.model.walls is not None
    errors = dict(fit.standard_errors)
    for name, loss, truth in zip(WALLS.names, fit.model.walls.loss, WALLS.loss, strict=True):
        assert abs(loss - truth) < 4 * errors[f"wall {name}"]
        assert errors[f"wall {name}"] < 1.5
    plain = fit_channel(_measured(WALLS.loss, 5))
    assert fit.log_likelihood > plain.log_likelihood + 10
    assert plain.model.walls is None


def test_walls_that_the_samples_give_no_loss() -> None:
    far = np.array([[20.0, 20.0, 21.0, 20.0]])
    walls = replace(
        WALLS, names=(*WALLS.names, "far"), loss=np.zeros(4), lines=np.vstack([LINES, far]),
        owner=np.array([0, 0, 1, 3]),
    )  # fmt: skip
    fit = fit_channel(_measured(np.array([6.0, -4.0, 9.0]), 6), FitOptions(walls=walls))
    assert fit.model.walls is not None
    assert fit.model.walls.loss[1] == 0.0
    assert fit.model.walls.loss[3] == 0.0
    assert any("glass" in note and "no loss" in note for note in fit.notes)
    assert any("far" in note and "no sample crosses" in note for note in fit.notes)
