from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from support.radio import conditioned

from stlc.radio.bounds import FINEST, pair_bounds
from stlc.radio.costs import CostName
from stlc.radio.errors import RadioError
from stlc.radio.gp import ChannelModel
from stlc.radio.kernel import KernelName
from stlc.radio.link_budget import LinkBudget, Modulation
from stlc.radio.link_ends import LinkEnds
from stlc.radio.pairs import predict_pairs
from stlc.radio.partition import grid
from stlc.radio.predicates import (
    LinkPredicate,
    Quantity,
    check_predicate,
    quantity_value,
    threshold_table,
)
from stlc.radio.table import cost_table
from stlc.radio.taylor import Boxes

MODEL, _ = conditioned(15)
CELLS = grid([-4.0, -3.0, -2.0, 0.0], [-1.0, 0.5, 1.2])
ENDS = LinkEnds(CELLS)
BUDGET = LinkBudget(-40.0, Modulation.OQPSK_802_15_4, packet=32, sensitivity=-38.0)
BOXES = ENDS.boxes()[0]
BOUNDS = {z: pair_bounds(MODEL, BOXES, z=z, budget=2e7) for z in (0.0, 1.645, -1.0)}
STATION = np.array([4.0, -4.5])


def points(draw_from, boxes):
    """One point in each box, often on a face or a corner."""
    unit = draw_from.uniform(-1.0, 1.0, boxes.centre.shape)
    snap = draw_from.uniform(size=unit.shape) < 0.4
    return boxes.centre + np.where(snap, np.sign(unit), unit) * boxes.half


@pytest.mark.parametrize("z", list(BOUNDS))
@given(seed=st.integers(0, 1_000_000))
def test_no_point_breaks_the_bounds(z, seed):
    rng = np.random.default_rng(seed)
    found = BOUNDS[z]
    mean, variance = predict_pairs(MODEL, points(rng, BOXES), points(rng, BOXES), True)
    sigma = np.sqrt(variance)
    for value, (low, high) in (
        (mean, found.mean),
        (sigma, found.sigma),
        (mean - z * sigma, found.level),
    ):
        assert (low <= value).all()
        assert (value <= high).all()


@given(seed=st.integers(0, 1_000_000), part=st.integers(1, 3))
def test_coarse_bounds_are_sound_for_any_channel(seed, part):
    rng = np.random.default_rng(seed)
    model, _ = conditioned(10, seed % 50)
    other = ChannelModel(
        model.l0,
        rng.uniform(-1, 4),
        0.0,
        rng.uniform(0.5, 40),
        rng.uniform(0.4, 6),
        d0=0.3,
        deviation=rng.choice([0.0, 5.0]),
    )
    posterior = model.posterior
    assert posterior is not None
    from stlc.radio.gp import condition_on, evidence_for
    from stlc.radio.samples import make_samples

    samples = make_samples(posterior.centres, rng.normal(-30, 6, 10))
    known = evidence_for(other, samples, samples.rssi, np.full(10, 0.5))
    changed = condition_on(other, known, 10)
    found = pair_bounds(changed, BOXES, budget=10.0 ** (4 + part), z=1.0)
    mean, variance = predict_pairs(changed, points(rng, BOXES), points(rng, BOXES), True)
    assert (found.mean[0] <= mean).all()
    assert (mean <= found.mean[1]).all()
    assert (found.sigma[0] <= np.sqrt(variance) + 1e-6).all()
    assert (np.sqrt(variance) <= found.sigma[1] + 1e-6).all()
    assert (found.level[0] <= mean - np.sqrt(variance) + 1e-6).all()


@pytest.mark.parametrize(("seed", "level"), [(0, -45.0), (1, -36.0), (2, -30.0), (3, -24.0)])
def test_a_focus_keeps_bounds_sound_and_decides_as_much(seed, level):
    rng = np.random.default_rng(seed)
    focused = pair_bounds(MODEL, BOXES, budget=2e6, z=1.645, focus=(level, level))
    plain = pair_bounds(MODEL, BOXES, budget=2e6, z=1.645)
    mean, variance = predict_pairs(MODEL, points(rng, BOXES), points(rng, BOXES), True)
    value = mean - 1.645 * np.sqrt(variance)
    assert (focused.level[0] <= value).all()
    assert (value <= focused.level[1]).all()
    decided = [(b.level[0] >= level).sum() + (b.level[1] < level).sum() for b in (focused, plain)]
    assert decided[0] >= decided[1]


def test_bounds_are_symmetric_tighten_and_say_how_tight():
    coarse = pair_bounds(MODEL, BOXES, budget=1e5)
    fine = BOUNDS[0.0]
    np.testing.assert_array_equal(fine.mean[0], fine.mean[0].T)
    assert fine.parts > coarse.parts
    assert fine.gap < coarse.gap
    assert (fine.mean[0] >= coarse.mean[0] - 1e-12).all()


def test_station_bounds_hold_and_are_tight():
    first, second = LinkEnds(CELLS, STATION).boxes()
    found = pair_bounds(MODEL, first, second, z=1.0, tolerance=0.3)
    assert found.gap <= 0.3
    rng = np.random.default_rng(5)
    for _ in range(50):
        mean, variance = predict_pairs(MODEL, points(rng, first), second.centre, True)
        level = mean - np.sqrt(variance)
        assert (found.level[0] <= level).all()
        assert (level <= found.level[1]).all()


def test_prior_bounds_are_exact_intervals_of_the_path_loss():
    prior = ChannelModel(-12.89, 3.0, 10.0, 10.0, 2.0)
    found = pair_bounds(prior, BOXES)
    same = np.diag(found.mean[1])
    np.testing.assert_allclose(same, -12.89)
    assert found.sigma[0].min() == found.sigma[1].max() == pytest.approx(np.sqrt(20.0))


def test_paper_min_has_no_rigorous_bounds_and_says_so():
    model = ChannelModel(-12.0, 3.0, 1.0, 1.0, 1.0, kernel=KernelName.PAPER_MIN)
    with pytest.raises(RadioError, match="bound = centre"):
        pair_bounds(model, BOXES)


PREDICATES = [
    LinkPredicate(Quantity.RSSI, -30.0, True),
    LinkPredicate(Quantity.SNR, 8.0, False),
    LinkPredicate(Quantity.BER, 1e-2, False),
    LinkPredicate(Quantity.BER_AT_MEAN, 1e-3, False),
    LinkPredicate(Quantity.PRR, 0.6, True),
    LinkPredicate(Quantity.CHANCE, -38.0, True, 0.9),
    LinkPredicate(Quantity.CHANCE, -25.0, False, 0.8),
]


@pytest.mark.parametrize("station", [True, False])
@pytest.mark.parametrize("predicate", PREDICATES, ids=lambda p: f"{p.quantity}-{p.at_least}")
def test_threshold_tables_are_right_at_every_point(predicate, station):
    ends = LinkEnds(CELLS, STATION if station else None)
    table = threshold_table(MODEL, ends, predicate, BUDGET)
    holds, fails = table.allowed(True), table.allowed(False)
    assert holds.any() or fails.any()
    rng = np.random.default_rng(9)
    first, second = ends.boxes()
    low, high = table.low.matrix(), table.high.matrix()
    for _ in range(60):
        mean, variance = predict_pairs(MODEL, points(rng, first), points(rng, second), True)
        value = quantity_value(predicate, mean, np.sqrt(variance), BUDGET)
        robustness = predicate.robustness(value)
        assert (robustness[holds] >= 0.0).all()
        assert (robustness[fails] <= 0.0).all()
        assert (low <= robustness + 1e-9).all()
        assert (robustness <= high + 1e-9).all()


def test_centre_lies_between_the_worst_cases():
    predicate = LinkPredicate(Quantity.CHANCE, -36.0, True, 0.95)
    worst = threshold_table(MODEL, ENDS, predicate, BUDGET)
    centre = threshold_table(MODEL, ENDS, predicate, BUDGET, "centre").low.matrix()
    assert (worst.low.matrix() <= centre).all()
    assert (centre <= worst.high.matrix()).all()


@pytest.mark.parametrize("cost", list(CostName))
def test_worst_cost_is_at_least_the_cost_anywhere(cost):
    budget = replace(BUDGET, bandwidth=2e6, rate=2.5e5, power=20.0)  # what energy needs, too
    worst = cost_table(MODEL, ENDS, cost, budget, "worst").matrix()
    mean = cost_table(MODEL, ENDS, cost, budget, "mean").matrix()
    centre = cost_table(MODEL, ENDS, cost, budget, "centre").matrix()
    assert (centre <= worst + 1e-9).all()
    assert (mean <= worst + 1e-9).all()
    assert np.isfinite(worst).all()


def test_mean_cost_is_the_average_over_the_cells():
    table = cost_table(MODEL, ENDS, CostName.INV_SNR, BUDGET, "mean").matrix()
    rng = np.random.default_rng(0)
    for i, j in ((0, 0), (3, 4), (0, 5)):
        a = BOXES.centre[i] + rng.uniform(-1, 1, (400, 2)) * BOXES.half[i]
        b = BOXES.centre[j] + rng.uniform(-1, 1, (400, 2)) * BOXES.half[j]
        mean, variance = predict_pairs(MODEL, a, b, True)
        cost = 10 ** (-(mean + 40.0) / 10) * np.exp((np.log(10) / 10) ** 2 * variance / 2)
        assert table[i, j] == pytest.approx(cost.mean(), rel=0.06)


def test_predicates_check_their_needs():
    with pytest.raises(RadioError, match="chance form"):
        LinkPredicate(Quantity.RSSI, -30.0, True, 0.9)
    prr = LinkPredicate(Quantity.PRR, 0.9, True)
    with pytest.raises(RadioError, match="packet"):
        check_predicate(MODEL, prr, LinkBudget(-40.0, Modulation.BPSK))
    with pytest.raises(RadioError, match="already averages"):
        check_predicate(MODEL, prr, LinkBudget(-40.0, Modulation.RAYLEIGH_BPSK, packet=32))


def test_tall_cells_are_cut_into_no_more_parts_than_flat_ones():
    """A cell of one layer is 1 m wide and 100 m high: cut as finely as in the plane, its parts
    would take 6 MB a cell."""
    model = replace(MODEL, posterior=None)
    cell = Boxes(np.array([[3.0, 4.0, 50.0]]), np.array([[0.5, 0.5, 50.0]]))
    post = Boxes(np.zeros((1, 3)), np.zeros((1, 3)))
    found = pair_bounds(model, cell, post, fading=False)
    assert found.parts**3 <= FINEST**4
    rng = np.random.default_rng(0)
    at = cell.centre + rng.uniform(-1, 1, (500, 3)) * cell.half
    mean, _ = predict_pairs(model, at, np.zeros((500, 3)), False)
    assert (found.mean[0] <= mean.min()).all()
    assert (mean.max() <= found.mean[1]).all()
