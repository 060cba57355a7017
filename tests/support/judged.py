"""Two agents of four steps, and what the verifier says of them."""

import numpy as np

from stlc.ir.requirement import Requirement
from stlc.mission import Channel
from stlc.plan import make_plan
from stlc.radio.gp import ChannelModel
from stlc.radio.link_budget import LinkBudget, Modulation
from stlc.radio.partition import uniform_grid
from stlc.verify import verify
from support.missions import agent, mission, roll

T = 4
STILL = np.zeros((T, 2))
GRID = uniform_grid((0, 10), (0, 10), 10, 10)
PRIOR = ChannelModel(-12.89, 3.0, 10.0, 10.0, 2.0)
BUDGET = LinkBudget(-60.0, Modulation.OQPSK_802_15_4, packet=32)


def radio(**extra):
    """A channel on cells of one metre."""
    return Channel("radio", GRID, PRIOR, BUDGET, **extra)


def judged(formula, *, a=(2.5, 2.5), b=(6.5, 2.5), inputs=STILL, solve=None, margin=0.0, **extra):
    """The report on `formula` over a's run under `inputs` (T, 2), b at rest."""
    one, two = agent("a", a), agent("b", b)
    runs = {"a": roll(one, inputs), "b": roll(two, STILL)}
    needs = [] if formula is None else [Requirement("talk", formula, margin)]
    there = mission([one, two], needs, horizon=T, **extra)
    plan = make_plan(
        there, {k: v[0] for k, v in runs.items()}, {k: v[1] for k, v in runs.items()}, solve
    )
    return verify(there, plan)
