"""Exponential and logarithm against SciPy's, nilpotent matrices by their finite series."""

from __future__ import annotations

import subprocess
import sys

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.linalg import expm

from stlc.matrices import exponential, logarithm

CHAIN = np.array([[0.0, 1, 0.5], [0, 0, 2], [0, 0, 0]])


@given(st.integers(1, 4), st.integers(0, 10_000))
def test_any_matrix(size: int, seed: int) -> None:
    matrix = np.random.default_rng(seed).normal(size=(size, size))
    assert np.allclose(exponential(matrix), expm(matrix), rtol=1e-12)
    back = logarithm(exponential(0.3 * matrix))
    assert back is not None
    assert np.allclose(back, 0.3 * matrix, atol=1e-9)


def test_a_chain_of_integrators() -> None:
    assert np.allclose(exponential(CHAIN), expm(CHAIN), rtol=1e-15)
    back = logarithm(exponential(CHAIN))
    assert back is not None
    assert np.allclose(back, CHAIN, atol=1e-15)


def test_a_reflection_has_no_real_logarithm() -> None:
    assert logarithm(np.diag([-1.0, 2.0])) is None


def test_integrators_load_no_scipy() -> None:
    code = (
        "import sys, numpy as np; from stlc.matrices import exponential, logarithm;"
        "logarithm(exponential(np.array([[0.0, 1.0], [0.0, 0.0]]))); print('scipy' in sys.modules)"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "False"


@pytest.mark.parametrize("entry", [800.0, 1e300])
def test_overflow_is_not_hidden(entry: float) -> None:
    with np.errstate(all="ignore"):
        assert not np.isfinite(exponential(np.array([[entry]]))).all()
