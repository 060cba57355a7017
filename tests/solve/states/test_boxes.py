"""The cheapest step between two boxes, against steps drawn at random within them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pytest

from stlc.arrays import Bools, Floats
from stlc.solve.states.boxes import Edges, axis_grid, corners, edge_min, point_grid

BLEND, JUMP = 0.5, 1.0


@dataclass
class Steps:
    """Steps from (p, v) to rate w, each (n,)."""

    p: Floats
    v: Floats
    w: Floats

    @property
    def end(self) -> Floats:
        """Positions afterwards."""
        return self.p + (1 - BLEND) * self.v + BLEND * self.w

    def admissible(self, src: Floats, dst: Floats, room: float) -> Bools:
        """Between the boxes, with a change of the rate within JUMP."""
        fine = np.abs(self.w - self.v) <= JUMP + room
        for x, (low, high) in (
            (self.p, src[:2]), (self.v, src[2:]), (self.end, dst[:2]), (self.w, dst[2:]),
        ):  # fmt: skip
            fine &= (x >= low - room) & (x <= high + room)
        return fine

    def cost(self, edges: Edges, a0: Floats, a1: Floats) -> Floats:
        """Word for word as `Corners.least` has it."""
        own = edges.rate_cost * np.abs(self.w) + edges.change_cost * np.abs(self.w - self.v)
        ahead, behind = a1[0] * self.end + a1[1] * self.w, a0[0] * self.p + a0[1] * self.v
        return np.asarray(own + ahead - behind)


def one(src: Floats, dst: Floats, rate_cost: float, change_cost: float) -> Edges:
    cost = np.array([rate_cost]), np.array([change_cost])
    return Edges(src[None], dst[None], np.array([BLEND]), np.array([JUMP]), *cost)


@pytest.mark.parametrize("seed", range(20))
def test_no_step_is_cheaper_and_the_least_is_one(seed: int) -> None:
    rng = np.random.default_rng(seed)
    src, dst = (
        np.concatenate([np.sort(rng.uniform(0, 3, 2)), np.sort(rng.uniform(-1, 1, 2))])
        for _ in range(2)
    )
    edges = one(src, dst, rng.uniform(0, 2), rng.uniform(0, 2))
    a0, a1 = rng.uniform(-1, 1, (2, 1, 2))
    least, where = corners(edges).cheapest(a0, a1)
    assert edge_min(edges, a0, a1)[0] == least[0]
    drawn = Steps(*(rng.uniform(*ends, 20_000) for ends in (src[:2], src[2:], dst[2:])))
    fine = drawn.admissible(src, dst, 0.0)
    assert (drawn.cost(edges, a0[0], a1[0])[fine] >= least[0] - 1e-9).all()
    if np.isfinite(least[0]):
        best = Steps(*where.T)
        assert best.admissible(src, dst, 1e-5).all()
        assert best.cost(edges, a0[0], a1[0])[0] == pytest.approx(least[0])
    else:
        assert not fine.any()


def test_boxes_too_far_apart_have_no_step() -> None:
    edges = one(np.array([0.0, 1.0, 0.0, 0.5]), np.array([5.0, 6.0, 0.0, 0.5]), 1.0, 1.0)
    flat = np.zeros((1, 2))
    assert np.isinf(edge_min(edges, flat, flat)).all()
    assert np.isinf(corners(edges).cheapest(flat, flat)[0]).all()


def test_a_face_on_a_border_belongs_to_both_cells() -> None:
    grid = axis_grid(np.array([0.0, 1.0, 2.0]), [1.0, 1.5], np.array([-1.0, 1.0]))
    thin = grid.box[grid.thin]
    assert (thin[:, :2] == 1.0).all()
    assert sorted(grid.cell[grid.thin]) == [0, 1]
    assert sorted(map(tuple, grid.box[~grid.thin][:, :2])) == [(0, 1), (1, 1.5), (1.5, 2)]


def test_a_point_is_a_box_of_no_width() -> None:
    assert point_grid(2.0, -1.0).box.tolist() == [[2.0, 2.0, -1.0, -1.0]]
