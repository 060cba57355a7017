from dataclasses import replace

import numpy as np
import pytest

from stlc.radio.averages import average, average_bounds
from stlc.radio.costs import CLAMP, CostName, cost_interval, link_cost, normalised
from stlc.radio.errors import RadioError
from stlc.radio.link_budget import (
    LinkBudget,
    Modulation,
    bit_error_rate,
    check_fading,
    noise_floor_dbm,
    required_ebn0_db,
    z_quantile,
)

TABLE = [
    ("bpsk", 6.79, 9.59),
    ("qpsk", 6.79, 9.59),
    ("dbpsk", 7.93, 10.34),
    ("coherent_fsk", 9.80, 12.60),
    ("noncoherent_fsk", 10.94, 13.35),
    ("oqpsk_802_15_4", -0.92, 1.09),
    ("rayleigh_bpsk", 23.97, 43.98),
    ("rayleigh_dbpsk", 26.98, 46.99),
    ("rayleigh_noncoherent_fsk", 29.99, 50.00),
]
BUDGET = LinkBudget(-100.0, Modulation.OQPSK_802_15_4, packet=32, sensitivity=-95.0)


@pytest.mark.parametrize(("name", "at_3", "at_5"), TABLE)
def test_needed_ebn0_matches_the_textbook_table(name, at_3, at_5):
    modulation = Modulation(name)
    assert required_ebn0_db(modulation, 1e-3) == pytest.approx(at_3, abs=0.006)
    assert required_ebn0_db(modulation, 1e-5) == pytest.approx(at_5, abs=0.006)


def test_the_table_above_names_every_modulation():
    assert {row[0] for row in TABLE} == {m.value for m in Modulation}


@pytest.mark.parametrize("modulation", list(Modulation))
def test_bit_error_rates_fall_from_a_half_or_less(modulation):
    gamma = np.concatenate([[0.0], np.logspace(-4, 3, 400)])
    rate = bit_error_rate(modulation, gamma)
    assert rate[0] == pytest.approx(0.5, abs=1e-9)
    assert (np.diff(rate) <= 1e-15).all()
    assert (rate >= 0.0).all()


def test_budget_thresholds_are_where_the_quantity_crosses():
    budget = LinkBudget(-100.0, Modulation.DBPSK, bandwidth=2e6, rate=2.5e5, packet=20)
    assert budget.processing_gain_db == pytest.approx(9.0309, abs=1e-4)
    for ber in (1e-2, 1e-4):
        level = budget.rssi_for_ber(ber)
        assert budget.ber(np.array([level]))[0] == pytest.approx(ber, rel=1e-6)
    level = budget.rssi_for_prr(0.9)
    assert budget.prr(np.array([level]))[0] == pytest.approx(0.9, rel=1e-6)


def test_noise_floor_and_quantiles():
    assert noise_floor_dbm(2e6, 10.0) == pytest.approx(-100.99, abs=0.01)
    assert z_quantile(0.95) == pytest.approx(1.6449, abs=1e-4)
    with pytest.raises(RadioError, match="strictly between 0 and 1"):
        z_quantile(1.0)


def test_average_over_the_posterior_matches_sampling():
    rng = np.random.default_rng(0)
    draws = BUDGET.ber(-99.0 + 3.0 * rng.standard_normal(400_000)).mean()
    got = average(BUDGET.ber, np.array([-99.0]), np.array([3.0]))
    assert got[0] == pytest.approx(draws, rel=0.02)


def test_average_bounds_hold_inside_the_intervals():
    mean, sigma = (np.array([-101.0]), np.array([-97.0])), (np.array([2.0]), np.array([4.0]))
    low, high = average_bounds(BUDGET.ber, mean, sigma, decreasing=True)
    m, s = np.meshgrid(np.linspace(-101, -97, 21), np.linspace(2, 4, 21))
    inside = average(BUDGET.ber, m, s)
    assert low[0] <= inside.min()
    assert inside.max() <= high[0]


def test_rayleigh_and_a_fading_variance_exclude_each_other():
    check_fading(Modulation.RAYLEIGH_BPSK, 0.0)
    check_fading(Modulation.BPSK, 10.0)
    with pytest.raises(RadioError, match="already averages over fading"):
        check_fading(Modulation.RAYLEIGH_BPSK, 10.0)


def test_expected_inverse_snr_is_the_log_normal_mean():
    rng = np.random.default_rng(1)
    snr = 20.0 + 3.0 * rng.standard_normal(400_000)
    got = link_cost(CostName.INV_SNR, np.array([-80.0]), np.array([3.0]), BUDGET).values[0]
    assert got == pytest.approx((10 ** (-snr / 10)).mean(), rel=0.01)


@pytest.mark.parametrize("cost", [c for c in CostName if c is not CostName.PAPER_INV_RSSI])
def test_costs_fall_with_strength_and_worst_covers_the_interval(cost):
    budget = replace(BUDGET, bandwidth=2e6, rate=2.5e5, power=20.0)  # what energy needs, too
    mean = np.linspace(-110.0, -70.0, 81)
    value = link_cost(cost, mean, np.full_like(mean, 4.0), budget).values
    assert (np.diff(value) <= 1e-9 * np.abs(value[1:]) + 1e-12).all()
    box = (np.array([-100.0]), np.array([-96.0])), (np.array([2.0]), np.array([5.0]))
    worst = cost_interval(cost, *box, budget).values[0]
    m, s = np.meshgrid(np.linspace(-100, -96, 17), np.linspace(2, 5, 17))
    assert link_cost(cost, m, s, budget).values.max() <= worst + 1e-9


def test_infinite_costs_are_clamped_and_reported():
    got = link_cost(CostName.ETX, np.array([-300.0, -60.0]), np.array([1.0, 1.0]), BUDGET)
    assert got.clamped == 1
    assert got.values[0] == CLAMP
    assert got.values[1] == pytest.approx(1.0)
    assert "clamped" in got.notes[0]


def test_paper_cost_warns_and_survives_zero_dbm():
    got = link_cost(CostName.PAPER_INV_RSSI, np.array([0.0, -50.0]), np.zeros(2), BUDGET)
    assert got.values[1] == pytest.approx(-0.02)
    assert any("changes sign" in note for note in got.notes)


def test_missing_parts_of_the_budget_are_named():
    bare = LinkBudget(-100.0)
    x, s = np.array([-90.0]), np.array([1.0])
    with pytest.raises(RadioError, match="modulation"):
        link_cost(CostName.ETX, x, s, LinkBudget(-100.0, packet=32))
    with pytest.raises(RadioError, match="packet"):
        link_cost(CostName.ETX, x, s, LinkBudget(-100.0, Modulation.BPSK))
    with pytest.raises(RadioError, match="sensitivity"):
        link_cost(CostName.OUTAGE, x, s, bare)
    with pytest.raises(RadioError, match="both bandwidth and bit rate"):
        LinkBudget(-100.0, bandwidth=1e6)


def test_normalised_divides_by_the_static_range():
    values, scale = normalised(np.array([2.0, 6.0]))
    assert scale == 4.0
    np.testing.assert_allclose(values, [0.5, 1.5])
    assert normalised(np.array([3.0, 3.0]))[1] == 1.0
