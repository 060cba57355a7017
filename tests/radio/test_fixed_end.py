"""Links whose one end stays: the same numbers from fewer places, and bounds no point breaks."""

import numpy as np
import pytest
from support.radio import PAPER_CHANNEL

from stlc.radio.bounds import pair_bounds
from stlc.radio.fixed_end import prepare_from
from stlc.radio.gp import condition
from stlc.radio.pairs import predict_pairs, prepare
from stlc.radio.samples import make_samples
from stlc.radio.sub_bounds import Ask, sub_bounds
from stlc.radio.taylor import Boxes, prepare_ends

ANCHORS = np.array([[0.0, 0.0], [6.0, 1.0], [2.0, 5.0]])
RNG = np.random.default_rng(7)
PLACES = RNG.uniform(-1.0, 7.0, (12, 2))
LINKS = np.array([[*p, *a] for p in PLACES for a in ANCHORS])
MODEL = condition(PAPER_CHANNEL, make_samples(LINKS, RNG.normal(-35.0, 5.0, len(LINKS))))
HERE = Boxes(ANCHORS[1:2], np.zeros((1, 2)))
CELLS = Boxes(RNG.uniform(-1.0, 7.0, (9, 2)), RNG.uniform(0.1, 0.5, (9, 2)))


def test_places_take_the_part_of_links():
    field = prepare_from(MODEL, ANCHORS[1])
    assert field.one_way
    assert field.centres == len(PLACES) + len(ANCHORS)
    assert field.norm <= prepare(MODEL, 2).norm + 1e-9


@pytest.mark.parametrize("place", [ANCHORS[1], np.array([2.2, 2.9]), PLACES[0] + 0.3])
def test_expansions_from_a_place_are_those_of_the_whole_field(place):
    here, found = Boxes(place[None, :], np.zeros((1, 2))), []
    for field in (prepare(MODEL, 2), prepare_from(MODEL, place)):
        ends = prepare_ends(field, here, False), prepare_ends(field, CELLS, True)
        found.append(sub_bounds(field, *ends, Ask(True, 1.3, True, 0.5, (-np.inf, np.inf))))
    np.testing.assert_allclose(found[0][6], found[1][6], atol=1e-9)
    for low, high in ((0, 1), (2, 3), (4, 5)):  # of the same slopes, with a smaller remainder
        assert (found[1][low] >= found[0][low] - 1e-9).all()
        assert (found[1][high] <= found[0][high] + 1e-9).all()


def test_no_point_breaks_the_bounds_from_a_place():
    found = pair_bounds(MODEL, HERE, CELLS, z=1.3)
    for _ in range(40):
        points = CELLS.centre + RNG.uniform(-1.0, 1.0, CELLS.centre.shape) * CELLS.half
        mean, variance = predict_pairs(MODEL, HERE.centre, points, True)
        level = mean - 1.3 * np.sqrt(variance)
        assert (found.level[0] <= level).all()
        assert (level <= found.level[1]).all()
        assert (found.mean[0] <= mean).all()
        assert (mean <= found.mean[1]).all()


def test_links_with_places_of_their_own_are_taken_as_they_are():
    links = RNG.uniform(-1.0, 7.0, (20, 4))
    model = condition(PAPER_CHANNEL, make_samples(links, RNG.normal(-35.0, 5.0, 20)))
    assert not prepare_from(model, ANCHORS[1]).one_way
