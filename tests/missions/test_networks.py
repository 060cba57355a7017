"""Small missions with networks: the best plan against all runs, judged by the verifier."""

from __future__ import annotations

from itertools import product

import numpy as np
import pytest

from stlc import api
from stlc.channels import ChannelTables
from stlc.errors import InfeasibleError
from stlc.milp.compile import Compiled, compile_mission
from stlc.mission import Mission
from stlc.plan import make_plan
from stlc.solve.alone.loosened import loosened
from stlc.solve.alone.project import project
from stlc.solve.outcome import SolveSettings
from stlc.solve.teams.held import against
from stlc.verify import verify

MISSION = """
step 1 s
horizon 1
workspace box [0, 12] x [0, 4]
agent scout : single_integrator {{ start (9, 1); integer; control |u| <= 1 }}
agent two : single_integrator {{ start (7, 3); integer; control |u| <= 1 }}
station base at (1, 2)
station one at (3, 1)
channel radio {{
  path_loss L0 = -40 dBm, n = 3
  fading 2 dB^2
  noise_floor -66 dBm, modulation oqpsk_802_15_4, packet 32 bytes
  cost etx
  partition 12 x 4
}}
require net: eventually[1] {formula}
minimize effort
"""

FORMULAS = [
    "connected([agents, one, base], rssi >= -58 dBm)",
    "connected([agents, one, base], rssi >= -57 dBm)",
    "not connected([agents, one, base], rssi >= -62 dBm)",
    "route(scout, base, [two, one], hops <= 2, rssi >= -62 dBm)",
    "route(scout, base, [two, one], hops <= 3, rssi >= -56 dBm)",
    "not route(scout, base, [two, one], hops <= 3, rssi >= -58 dBm)",
    "route(scout, base, [two, one], hops <= 3, prr >= 0.9)",
    "route(scout, base, [two, one], hops <= 2, prr >= 0.3)",
    "route(scout, base, [two], prr >= 0.5)",
    "not route(scout, base, [two, one], hops <= 3, prr >= 0.8)",
    "route(scout, base, [two, one], hops <= 3, link_cost <= 4)",
    "not route(scout, base, [two, one], hops <= 3, link_cost <= 4)",
    "(route(scout, base, [two], prr >= 0.9) or route(scout, base, [two, one], prr >= 0.95))",
    "count(b in agents: rssi(base, b) >= -54 dBm) >= 2",
    "count(b in [scout, base, one]: rssi(two, b) >= -56 dBm) <= 1",
    "count(b in [scout, base, one]: rssi(two, b) >= -53 dBm) == 1",
]

_MOVES = np.array(list(product((-1.0, 0.0, 1.0), repeat=2)))


def _best(mission: Mission) -> tuple[float, int]:
    """Least effort of all runs that the verifier accepts (inf: none), and how many these are."""
    best, count, tables = np.inf, 0, ChannelTables(mission)
    for moves in product(_MOVES, repeat=2):
        names = list(mission.agents)
        starts = {n: mission.agents[n].start for n in names}
        inputs = {n: move[None] for n, move in zip(names, moves, strict=True)}
        states = {n: np.stack([starts[n], starts[n] + inputs[n][0]]) for n in names}
        report = verify(mission, make_plan(mission, states, inputs), tables)
        if report.ok:
            best, count = min(best, float(np.abs(np.array(moves)).sum())), count + 1
    return best, count


@pytest.mark.parametrize("formula", FORMULAS)
def test_the_best_plan_is_that_of_exhaustive_search(formula: str) -> None:
    mission = api.loads(MISSION.format(formula=formula))
    expected, count = _best(mission)
    try:
        outcome = api.solve(mission, SolveSettings(time_limit=60.0, gap=0.0))
    except InfeasibleError:
        assert count == 0
        return
    assert outcome.plan.solve.objective == pytest.approx(expected, abs=1e-6)


@pytest.mark.parametrize("formula", FORMULAS)
def test_parts_of_a_mission_ask_for_no_more_than_the_whole(formula: str) -> None:
    """A run of all agents satisfies what is left for some: alone, loosened, the others held."""
    mission = api.loads(MISSION.format(formula=formula))
    tables = ChannelTables(mission)
    moves = {"scout": np.array([[-1.0, 0.0]]), "two": np.array([[0.0, -1.0]])}
    states = {
        n: np.stack([mission.agents[n].start, mission.agents[n].start + move[0]])
        for n, move in moves.items()
    }
    report = verify(mission, make_plan(mission, states, moves), tables)
    runs = {n: (states[n], moves[n]) for n in moves}
    held = against(mission, ["scout"], {"two": runs["two"]}, tables, costs=False)
    alone = project(mission, ["scout"], tables)
    for part in (held, alone, loosened(alone, tables), loosened(mission, tables)):
        kept = {n: runs[n] for n in part.agents}
        plan = make_plan(
            part, {n: r[0] for n, r in kept.items()}, {n: r[1] for n, r in kept.items()}
        )
        if report.ok:
            assert verify(part, plan).ok
        compiled = compile_or_none(part)
        assert compiled is not None or not report.ok


def compile_or_none(mission: Mission) -> Compiled | None:
    """The model, None where no run can meet the requirements."""
    try:
        return compile_mission(mission)
    except InfeasibleError:
        return None
