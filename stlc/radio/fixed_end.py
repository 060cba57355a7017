"""A posterior seen from one place: links whose one end stays where it is.

With an end at a, w_j(a, b) = E_cs(a) E_cr(b) + E_cr(a) E_cs(b) is linear in the E_p(b) of the
places p at which any centre has an end: w = W E_P(b). Robots measured from a few anchors have far
fewer places than links, so that

    S(a, b) = (W' weight)' E_P(b),   root w = (root W) E_P(b),   |root W x| = |R x|, Q R = root W

are the same numbers at a fraction of the work. S is a function of b alone in the space of one
Gaussian kernel, whose features have |psi''|^2 <= 3 / l^4.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from stlc.radio.gp import ChannelModel
from stlc.radio.kernel import squared_distance
from stlc.radio.pairs import PairField, prepare, rounded_norm, swap_halves, weighted

Array = NDArray[np.float64]

WORTH = 0.7
"""Places as a share of the centres from which on it no longer pays: a product with the factor is
then half as long, and the decomposition takes as long as that of a table of 500 parts of cells."""


def prepare_from(model: ChannelModel, point: Array) -> PairField:
    """The field of a channel for links between `point` (D,) [m] as first end and any other.

    That of `prepare` where the centres have hardly fewer places than there are centres.
    """
    links = weighted(model, len(point))
    places, at = np.unique(np.vstack([links.sender, links.receiver]), axis=0, return_inverse=True)
    if len(places) > WORTH * links.centres:
        return prepare(model, len(point))
    factors = swap_halves(links.factors(point[None, :]))[0]  # an end's place goes with the other
    weight = np.zeros(len(places))
    np.add.at(weight, at.ravel(), factors * np.tile(links.mean_weight, 2))
    root = np.asarray(np.linalg.qr(_gathered(links.root, factors, at.ravel(), len(places)), "r"))
    near = np.exp(-squared_distance(places, places) / (2.0 * model.length**2))
    here = np.tile(point, (len(places), 1))
    return PairField(model, here, places, weight, rounded_norm(near, weight), root, one_way=True)


def _gathered(root: Array, factors: Array, at: NDArray[np.intp], places: int) -> Array:
    """root W (r, places): the columns of a centre added to those of both its ends' places."""
    out = np.zeros((len(root), places))
    both = np.hstack([root, root]) * factors
    order = np.argsort(at, kind="stable")
    starts = np.searchsorted(at[order], np.arange(places))
    np.add.reduceat(both[:, order], starts, axis=1, out=out)
    return out
