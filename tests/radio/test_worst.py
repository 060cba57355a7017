"""No point of a cell pair breaks a `worst` table, whatever the predicate and its polarity."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from stlc.radio.gp import ChannelModel
from stlc.radio.link_budget import LinkBudget, Modulation
from stlc.radio.link_ends import LinkEnds
from stlc.radio.partition import grid
from stlc.radio.posterior import exact_posterior
from stlc.radio.predicates import LinkPredicate, Quantity, quantity_value, threshold_table

POINTS = 400


def channel(rng: np.random.Generator, measured: bool) -> ChannelModel:
    """A random channel, given a dozen random measurements or none."""
    model = ChannelModel(
        l0=-40.0,
        exponent=rng.uniform(1.5, 4.0),
        fading=rng.choice([0.5, 10.0, 40.0]),
        shadowing=rng.choice([0.0, 1.0, 24.0]),
        length=rng.choice([0.3, 2.0, 20.0]),
    )
    if not measured or model.shadowing == 0.0:
        return model
    links, residual = rng.uniform(0.0, 10.0, (12, 4)), 8.0 * rng.standard_normal(12)
    noise, kernel = np.full(12, model.fading), (model.shadowing, model.length, model.kernel)
    return replace(model, posterior=exact_posterior(links, residual, noise, *kernel))


def threshold(rng: np.random.Generator, quantity: Quantity) -> float:
    """One that links of these channels pass now and then."""
    if quantity in (Quantity.BER, Quantity.BER_AT_MEAN):
        return float(10.0 ** rng.uniform(-6.0, -0.5))
    if quantity is Quantity.PRR:
        return float(rng.uniform(0.01, 0.99))
    return float(rng.uniform(-80.0, -40.0) + (70.0 if quantity is Quantity.SNR else 0.0))


@pytest.mark.parametrize("quantity", Quantity)
@settings(deadline=None, max_examples=15)
@given(
    seed=st.integers(0, 2**32 - 1),
    measured=st.booleans(),
    station=st.booleans(),
    at_least=st.booleans(),
)
def test_no_point_of_a_cell_pair_breaks_the_worst_bound(
    quantity, seed, measured, station, at_least
):
    rng = np.random.default_rng(seed)
    model = channel(rng, measured)
    budget = LinkBudget(-70.0, Modulation.OQPSK_802_15_4, packet=32)
    cells = grid([0.0, *sorted(rng.uniform(0.5, 9.5, 2)), 10.0], [0.0, 5.0, 10.0])
    base = rng.uniform(0.0, 10.0, 2) if station else None
    chance = 0.9 if quantity is Quantity.CHANCE else None
    predicate = LinkPredicate(quantity, threshold(rng, quantity), at_least, chance)
    table = threshold_table(model, LinkEnds(cells, base), predicate, budget)

    # Corners and borders too: a fraction outside 0..1 is drawn in.
    pick, at = rng.integers(0, len(cells), (2, POINTS)), rng.uniform(-0.3, 1.3, (2, POINTS, 2))
    first, second = cells.low[pick] + np.clip(at, 0.0, 1.0) * (cells.high - cells.low)[pick]
    columns = pick[1]
    if base is not None:
        second, columns = np.broadcast_to(base, (POINTS, 2)), np.zeros(POINTS, int)
    mean, variance = model.predict(np.hstack([first, second]), True)
    value = predicate.robustness(quantity_value(predicate, mean, np.sqrt(variance), budget))
    assert (table.low.matrix()[pick[0], columns] <= value).all()  # where it is needed
    assert (table.high.matrix()[pick[0], columns] >= value).all()  # where its negation is
