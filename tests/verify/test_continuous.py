"""Exact extrema of the motion between samples, against dense sampling."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from support.missions import agent, roll

from stlc.dynamics import Dynamics
from stlc.places import Polytope
from stlc.plan import Run
from stlc.verify.continuous import distance, inside, separation
from stlc.verify.paths import Path, path_of

coarse = st.integers(-12, 12).map(lambda k: k / 4)
tables = arrays(float, (3, 2), elements=coarse)
motions = st.builds(Path, tables, tables, tables)
FINE = np.linspace(0.0, 1.0, 2001)


def triangle() -> Polytope:
    corners = np.array([[0.0, 0.0], [2.0, 0.0], [1.0, 2.0]])
    edge = np.roll(corners, -1, axis=0) - corners
    normals = np.column_stack([edge[:, 1], -edge[:, 0]])
    normals /= np.linalg.norm(normals, axis=1)[:, None]
    return Polytope(normals, (normals * corners).sum(axis=1), corners)


def samples(path: Path, row: int) -> np.ndarray:
    return path.c0[row] + FINE[:, None] * (path.c1[row] + FINE[:, None] * path.c2[row])


def face_slacks(path: Path, row: int, piece: Polytope) -> np.ndarray:
    return samples(path, row) @ piece.normals.T - piece.offsets


def agrees(found, row, sampled):
    """Exact, so never above the samples, and near the least of them."""
    assert found.value[row] <= sampled.min() + 1e-9
    assert found.value[row] >= sampled.min() - 0.01


@given(motions)
def test_inside_is_the_least_distance_to_a_face(path):
    found = inside(path, triangle())
    for row in range(3):
        agrees(found, row, -face_slacks(path, row, triangle()).max(axis=1))
        at = path.at(np.array([row + min(found.where[row], 1 - 1e-12)]))[0]
        there = -(triangle().normals @ at - triangle().offsets).max()
        assert there == pytest.approx(found.value[row], abs=1e-6)


@given(motions, st.tuples(st.sampled_from([0.0, 0.5]), st.sampled_from([0.0, 1.0])))
def test_separation_needs_one_axis(path, distances):
    found = separation(path, distances)
    for row in range(3):
        agrees(found, row, (np.abs(samples(path, row)) - distances).max(axis=1))


@given(motions)
def test_distance(path):
    found = distance(path)
    for row in range(3):
        sampled = np.linalg.norm(samples(path, row), axis=1)
        assert sampled.min() - 0.01 <= found.value[row] <= sampled.min() + 1e-6


def test_double_integrator_moves_on_parabolas():
    """The chord would cut the corner that the true arc leaves alone."""
    one = agent("r1", (0, 0, 1, 0))
    x, u = roll(one, [[0.0, 1.0]])
    run = Run(x, u, ("",) * 4, ("",) * 2, ("",) * 4, ("",) * 2)
    path = path_of(one, run, 1.0)
    assert path.at(np.array([0.5]))[0].tolist() == [0.5, 0.125]
    assert path.at(np.array([1.0]))[0].tolist() == [1.0, 0.5]


def test_what_is_not_known_moves_on_chords():
    eye = np.eye(2)
    hover = Dynamics("hover", eye, eye, np.zeros(2), ("x", "y"), ("u", "v"), ("m", "m"),
                     ("m", "m"), eye)  # fmt: skip
    one = agent("r1", (0, 0), dynamics=hover)
    run = Run(np.array([[0.0, 0.0], [2.0, 4.0]]), np.zeros((1, 2)), (), (), (), ())
    assert path_of(one, run, 1.0).at(np.array([0.25, 1.0])).tolist() == [[0.5, 1.0], [2.0, 4.0]]
