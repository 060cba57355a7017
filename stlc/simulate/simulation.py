"""A plan carried out many times over."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace
from functools import reduce

import numpy as np
from numpy.typing import NDArray

from stlc.errors import UsageError
from stlc.ir.nodes import Linear, Link, Node, walk
from stlc.ir.requirement import Requirement
from stlc.measurements import with_learned
from stlc.mission import Mission
from stlc.plan import Plan
from stlc.preferences import Measure, Preference
from stlc.simulate.estimate import Estimate, Simulation, interval
from stlc.simulate.radio import draw_packets
from stlc.simulate.runs import Runs, draw_runs, has_noise, is_noisy
from stlc.verify.requirements import swept_override
from stlc.verify.robots import drives
from stlc.verify.robustness import TOLERANCE, Evaluator, unit
from stlc.verify.subject import check_shape
from stlc.verify.trace import Trace

Array = NDArray[np.float64]

ALL = "all together"
WORKSPACE = "workspace"
_INSIDE = Requirement(WORKSPACE, Linear((), 0.0, "m"))


def simulate(
    mission: Mission,
    plan: Plan,
    *,
    draws: int = 10_000,
    seed: int = 0,
    confidence: float = 0.95,
    fading: bool = True,
) -> Simulation:
    """The probability of each requirement, jointly over time, of all of them together, and of each
    preference.

    In each draw every channel is one draw of its posterior, at the positions of all links and
    steps together, every link predicate is that of one packet (of many packets' mean, with
    `fading` false), and agents with noise are off their plan by it. The same seed gives the same
    draws. `confidence` in (0, 1) is that of the intervals.

    Raises UsageError when the plan doesn't fit the mission, RadioError as the channels do.
    """
    check_shape(mission, plan)
    mission = with_learned(mission, plan.learned)
    if draws < 1 or not 0.0 < confidence < 1.0:
        raise UsageError("a simulation needs at least one draw and a confidence between 0 and 1")
    runs = draw_runs(mission, plan, draws, rng := np.random.default_rng(seed))
    wishes = [p for p in mission.preferences if not p.cost]
    formulas = [r.formula for r in mission.requirements] + [p.formula for p in wishes]
    packets = draw_packets(mission, runs, formulas, draws, rng, fading)
    trace = Trace(mission.horizon + 1, runs.signals, packets.robustness, many=True)
    evaluator = Evaluator(trace, _certain_motion(mission, plan))
    judged = [(r, evaluator.robustness(r.formula)[:1]) for r in mission.requirements]
    judged += [(_INSIDE, value) for value in _in_workspace(mission, runs)]
    holds = [_holds(value, r.margin) for r, value in judged]
    together = reduce(np.logical_and, holds, np.ones(1, dtype=bool))
    return Simulation(
        mission.source.name, draws, seed, confidence,
        tuple(_estimate(r, value, draws, confidence) for r, value in judged),
        _counted(ALL, 0.0, together, draws, confidence),
        tuple(_notes(mission, plan, formulas, fading)),
        tuple(_wished(p, evaluator, draws, confidence) for p in wishes),
    )  # fmt: skip


def _wished(p: Preference, evaluator: Evaluator, draws: int, confidence: float) -> Estimate:
    """How often a preference is kept, and how much it is violated on average."""
    lack = _lack(p, evaluator)
    kept = lack <= TOLERANCE  # NaN is none
    found = _counted(p.name, p.margin, kept, draws, confidence, None, p.unit)
    mean = float(lack.mean())
    return replace(found, violation=mean if np.isfinite(mean) else None)


def _lack(p: Preference, evaluator: Evaluator) -> Array:
    """The violation in each draw (D,), or (1,) where all are alike; NaN if it can't be judged."""
    parts = (p.formula,) if p.measure is Measure.ROBUSTNESS else p.parts
    values = [evaluator.robustness(part)[:1] for part in parts]
    if not all(len(value) for value in values):
        return np.array([np.nan])
    if p.measure is Measure.ROBUSTNESS:
        return np.asarray(np.maximum(0.0, p.margin - values[0][0]))
    missed = [value[0] < p.margin - TOLERANCE for value in values]
    return np.asarray(p.worth * np.sum(np.broadcast_arrays(*missed), axis=0), dtype=np.float64)


def _holds(value: Array, margin: float) -> NDArray[np.bool_]:
    """In which draws a requirement's robustness (1, D) reaches its margin; (0, D): in none."""
    return value[0] >= margin - TOLERANCE if len(value) else np.zeros(1, dtype=bool)


def _estimate(rule: Requirement, value: Array, draws: int, confidence: float) -> Estimate:
    units = {unit(n) for n in walk(rule.formula) if isinstance(n, Linear | Link)}
    measured = units.pop() if len(units) == 1 else ""
    hold = _holds(value, rule.margin)
    robustness = np.broadcast_to(value[0], draws) if len(value) else None
    return _counted(rule.name, rule.margin, hold, draws, confidence, robustness, measured)


def _counted(
    name: str,
    margin: float,
    hold: NDArray[np.bool_],
    draws: int,
    confidence: float,
    robustness: Array | None = None,
    measured: str = "",
) -> Estimate:
    """`hold` (1,) is what is the same in every draw."""
    certain = len(hold) == 1 < draws
    count = int(np.broadcast_to(hold, draws).sum())
    low, high = interval(count, draws, confidence)
    if certain:
        low = high = float(hold[0])
    return Estimate(name, margin, count, draws, low, high, certain, robustness, measured)


def _certain_motion(mission: Mission, plan: Plan) -> Callable[[Node], Array | None]:
    """Judges `swept` conditions in continuous time where all who take part move as planned.

    Others are judged by what is sufficient for them at the steps, so that probabilities are too
    low rather than too high.
    """
    motion = swept_override(mission, plan.runs, plan.executed)
    shaken = {name for name, agent in mission.agents.items() if is_noisy(agent)}

    def override(node: Node) -> Array | None:
        if node.swept is None or _movers(node) & shaken:
            return None
        value = motion(node)
        return None if value is None else value[:, None]

    return override


def _movers(node: Node) -> set[str]:
    """Agents that a node is about."""
    parts = (n for n in walk(node) if isinstance(n, Linear))
    return {signal.owner for part in parts for signal, _ in part.terms}


def _in_workspace(mission: Mission, runs: Runs) -> Iterator[Array]:
    """Least distance (1, D) [m] to the workspace's border at the steps, where noise may carry
    agents across it."""
    space = mission.workspace
    noisy = [name for name, agent in mission.agents.items() if is_noisy(agent)]
    placed = [runs.positions[name] for name in noisy if name in runs.positions]
    if space is None or not placed:
        return
    slacks = [
        (space.offsets[:, None] - np.einsum("kp,tpd->tkd", space.normals, place[:, :2])).min(
            axis=(0, 1)
        )
        for place in placed
    ]
    yield np.min(slacks, axis=0)[None, :]


def _driven(mission: Mission, plan: Plan) -> Iterator[str]:
    """How far robots are off their plans, where their controllers take them."""
    for name, driven in drives(mission, plan.runs, plan.executed).items():
        robot = mission.agents[name].robot
        off = float(driven.off[plan.executed * driven.periods :].max(initial=0.0))
        assert robot is not None
        yield (
            f"{name} is driven along the plan by its controller: at most {off:.4g} m off it, "
            f"in its tube of {robot.radius:.4g} m"
        )


def _shaken(mission: Mission, names: set[str]) -> Iterator[str]:
    """What shakes agents, and whether feedback brings them back to their plans."""
    steered = {name for name in names if mission.agents[name].tube is not None}
    noisy = {name for name in steered if has_noise(mission.agents[name])}
    for some, what in (
        (names - steered, "noise, and the plan as it stands, without feedback"),
        (steered - noisy, "disturbances, half of them as large as they get, under feedback"),
        (noisy, "noise and disturbances, half of these as large as they get, under feedback"),
    ):
        if some:
            yield f"{what}: {', '.join(sorted(some))}"


def _notes(mission: Mission, plan: Plan, formulas: list[Node], fading: bool) -> Iterator[str]:
    """What a reader should know of how the draws were made."""
    nodes = [node for formula in formulas for node in walk(formula)]
    if any(isinstance(n, Link) for n in nodes):
        what = "of one packet a step and direction" if fading else "of the mean of many packets"
        yield f"links are {what}, channels drawn jointly over pairs and steps"
    shaken = {name for name, agent in mission.agents.items() if is_noisy(agent)}
    yield from _shaken(mission, shaken)
    yield from _driven(mission, plan)
    if any(n.swept is not None and _movers(n) & shaken for n in nodes):
        yield "`swept` of noisy agents is judged by what is sufficient: it holds at least as often"
