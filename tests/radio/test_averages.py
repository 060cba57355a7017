"""Averages over the posterior against scipy's adaptive quadrature, and their bounds."""

from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import quad

from stlc.radio.averages import average, average_bounds
from stlc.radio.link_budget import LinkBudget, Modulation

SIGMAS = np.array([0.01, 0.06, 0.07, 0.3, 1.0, 3.0, 8.0])


def exact(curve, mean, sigma):
    """The average by adaptive quadrature, piece by piece so that none is missed."""

    def weighted(level):
        density = np.exp(-(((level - mean) / sigma) ** 2) / 2) / (sigma * np.sqrt(2 * np.pi))
        return float(curve(np.array([level]))[0]) * density

    ends = np.linspace(mean - 9 * sigma, mean + 9 * sigma, 19)
    return sum(quad(weighted, a, b, epsabs=1e-11, limit=200)[0] for a, b in pairwise(ends))


@pytest.mark.parametrize("modulation", Modulation)
@pytest.mark.parametrize("packet", [None, 1, 127])
def test_averages_match_adaptive_quadrature(modulation, packet):
    budget = LinkBudget(-90.0, modulation, packet=packet)
    curve = budget.ber if packet is None else budget.prr
    cliff = -85.0 if packet is None else budget.rssi_for_prr(0.5)
    means = cliff + SIGMAS * np.linspace(-1.5, 1.5, len(SIGMAS))
    wanted = [exact(curve, m, s) for m, s in zip(means, SIGMAS, strict=True)]
    np.testing.assert_allclose(average(curve, means, SIGMAS), wanted, rtol=0, atol=1e-7)


def test_many_pairs_of_one_sigma_come_to_the_same_as_one_by_one():
    curve = LinkBudget(-90.0, Modulation.OQPSK_802_15_4, packet=127).prr
    means = np.linspace(-110.0, -70.0, 5000)
    many = average(curve, means, np.full_like(means, 2.5))
    some = average(curve, means[::500], np.full(10, 2.5))
    np.testing.assert_allclose(many[::500], some, rtol=0, atol=1e-7)


def test_many_pairs_of_one_mean_and_sigma():
    curve = LinkBudget(-90.0, Modulation.OQPSK_802_15_4, packet=127).prr
    many = average(curve, np.full(100, -88.0), np.full(100, 2.5))
    one = average(curve, np.array([-88.0]), np.array([2.5]))
    np.testing.assert_allclose(many, one[0], rtol=0, atol=1e-12)


@settings(deadline=None)
@given(
    modulation=st.sampled_from(list(Modulation)),
    packet=st.sampled_from([None, 8, 127]),
    mean=st.tuples(st.floats(-110, -60), st.floats(0, 6)),
    sigma=st.tuples(st.floats(0, 6), st.floats(0, 4)),
    where=st.tuples(st.floats(0, 1), st.floats(0, 1)),
)
def test_bounds_hold_anywhere_in_the_intervals(modulation, packet, mean, sigma, where):
    budget = LinkBudget(-90.0, modulation, packet=packet)
    curve = budget.ber if packet is None else budget.prr
    means, sigmas = ((np.array([x]), np.array([x + w])) for x, w in (mean, sigma))
    low, high = average_bounds(curve, means, sigmas, decreasing=packet is None)
    point = mean[0] + where[0] * mean[1], sigma[0] + where[1] * sigma[1]
    value = average(curve, np.array([point[0]]), np.array([point[1]]))
    assert low <= value <= high
