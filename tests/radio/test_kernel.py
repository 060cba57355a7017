import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from stlc.radio.errors import KernelError
from stlc.radio.gp import ChannelModel, condition
from stlc.radio.kernel import (
    DIRECTED,
    KernelName,
    check_covariance,
    correlation,
    correlation_gradient,
)
from stlc.radio.pathloss import path_loss_mean, swap_ends
from stlc.radio.samples import make_samples


def links(count, seed, size=3.0):
    return np.random.default_rng(seed).uniform(-size, size, (count, 4))


def test_path_loss_is_clamped_at_the_reference_distance():
    got = path_loss_mean(np.array([0.0, 0.5, 1.0, 10.0]), -12.89, 3.0, 1.0)
    np.testing.assert_allclose(got, [-12.89, -12.89, -12.89, -42.89])


@given(seed=st.integers(0, 10_000), length=st.floats(0.1, 20.0), count=st.integers(2, 40))
def test_symmetrised_kernel_is_a_unit_variance_covariance(seed, length, count):
    y = links(count, seed)
    y[0, 2:] = y[0, :2]
    matrix = correlation(y, y, length, KernelName.SYMMETRISED)
    np.testing.assert_allclose(np.diag(matrix), 1.0, atol=1e-12)
    assert np.linalg.eigvalsh(matrix)[0] > -1e-10


@pytest.mark.parametrize("kernel", [KernelName.SYMMETRISED, KernelName.PAPER_MIN])
def test_kernels_do_not_care_which_end_sends(kernel):
    a, b = links(15, 1), links(12, 2)
    same = correlation(a, b, 1.7, kernel)
    np.testing.assert_allclose(same, correlation(swap_ends(a), b, 1.7, kernel), atol=1e-12)
    np.testing.assert_allclose(same, correlation(b, a, 1.7, kernel).T, atol=1e-12)


@pytest.mark.parametrize("kernel", list(KernelName))
def test_gradient_by_log_length_matches_finite_differences(kernel):
    a, b, step = links(9, 3), links(7, 4), 1e-5
    _, slope = correlation_gradient(a, b, 1.3, kernel)
    up = correlation(a, b, 1.3 * np.exp(step), kernel)
    down = correlation(a, b, 1.3 * np.exp(-step), kernel)
    np.testing.assert_allclose(slope, (up - down) / (2 * step), atol=1e-8)


def test_paper_min_is_not_positive_semi_definite_and_says_so():
    y = links(120, 0, size=1.5)
    with pytest.raises(KernelError, match=r"smallest eigenvalue is -.*symmetrised"):
        check_covariance(y, 2.0, KernelName.PAPER_MIN)
    assert check_covariance(y, 2.0, KernelName.SYMMETRISED) > -1e-9
    model = ChannelModel(-12.0, 3.0, 10.0, 10.0, 2.0, kernel=KernelName.PAPER_MIN)
    with pytest.raises(KernelError):
        condition(model, make_samples(y, np.zeros(len(y))))


def test_paper_min_works_where_it_is_a_covariance():
    y = links(6, 5, size=20.0)
    model = ChannelModel(-12.0, 3.0, 1.0, 10.0, 2.0, kernel=KernelName.PAPER_MIN)
    got, _ = condition(model, make_samples(y, model.mean(y) + 5.0)).predict(y, fading=False)
    np.testing.assert_allclose(got, model.mean(y) + 5.0 * 10.0 / 11.0, atol=1e-3)


@pytest.mark.parametrize("kernel", DIRECTED)
def test_directed_kernels_part_the_directions_and_are_covariances(kernel):
    links = np.random.default_rng(5).uniform(0, 4, (60, 4))
    value, slope = correlation_gradient(links, links, 1.5, kernel)
    np.testing.assert_allclose(value, correlation(links, links, 1.5, kernel), atol=1e-12)
    np.testing.assert_allclose(np.diag(value), 1.0, atol=1e-6)
    assert np.linalg.eigvalsh(value)[0] > -1e-9
    up, down = (correlation(links, links, 1.5 * np.exp(e), kernel) for e in (1e-5, -1e-5))
    np.testing.assert_allclose(slope, (up - down) / 2e-5, atol=1e-6)
    assert correlation(links[:1], swap_ends(links[:1]), 1.5, kernel)[0, 0] < 0.9


def test_exponential_is_that_of_the_distance():
    a, b = np.array([[0.0, 0.0, 5.0, 0.0]]), np.array([[3.0, 0.0, 5.0, 4.0]])
    assert correlation(a, b, 2.0, KernelName.EXPONENTIAL)[0, 0] == pytest.approx(np.exp(-2.5))
