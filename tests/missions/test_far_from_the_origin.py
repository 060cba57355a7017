"""A mission that is moved as a whole has the same answer, as far as doubles tell places apart."""

from __future__ import annotations

from collections.abc import Callable

import pytest

from stlc.api import loads, solve, verify
from stlc.errors import MissionError
from stlc.solve.outcome import SolveSettings

OPTIONS = SolveSettings(time_limit=60.0, threads=1)
SHIFTS = [1e3, 1e5, 1e6, 1e7, 9.9e7]
AGENT = "agent r : {kind} {{ start {start}; control |u| <= 2 }}\n"
Moved = Callable[..., str]


def moved(far: float) -> tuple[Moved, Moved]:
    """Points and boxes, told about the origin, as they are told `far` to the east and south."""

    def point(x: float, y: float) -> str:
        return f"({x + far!r}, {y - far!r})"

    def box(x0: float, x1: float, y0: float, y1: float) -> str:
        return f"box [{x0 + far!r}, {x1 + far!r}] x [{y0 - far!r}, {y1 - far!r}]"

    return point, box


def around(far: float, obstacle: bool = True) -> str:
    """Past a wedge into a small box, between the steps too."""
    point, box = moved(far)
    wedge = f"polygon {point(4, 3)} {point(6, 3)} {point(5, 7)}"
    keep_out = f"obstacle o = {wedge} inflate 0.2 m\nrequire b: always r outside o swept\n"
    return (
        f"horizon 5\nworkspace {box(0, 10, 0, 10)}\n"
        + AGENT.format(kind="double_integrator", start=point(1, 4))
        + f"region g = {box(8, 8.25, 4, 4.25)}\nrequire a: eventually r in g\n"
        + keep_out * obstacle
        + "minimize effort\n"
    )


def deep(far: float) -> str:
    """As deep into a rhombus as may be, around two boxes that touch."""
    point, box = moved(far)
    rhombus = f"polygon {point(8, 4)} {point(9, 5)} {point(8, 6)} {point(7, 5)}"
    return (
        f"horizon 6\nworkspace {box(0, 10, 0, 10)}\n"
        + AGENT.format(kind="single_integrator", start=point(1, 5))
        + f"region g = {rhombus}\nobstacle p = {box(4, 5, 2, 6)}\nobstacle q = {box(5, 6, 4, 8)}\n"
        "require a: eventually r in g\nrequire b: always (r outside p and r outside q)\n"
        "maximize robustness(a)\n"
    )


def apart(far: float) -> str:
    """Past an obstacle that moves, near another agent and within its reach by radio."""
    point, box = moved(far)
    return (
        f"horizon 4\nworkspace {box(0, 10, 0, 10)}\n"
        + AGENT.format(kind="single_integrator", start=point(1, 1))
        + AGENT.format(kind="single_integrator", start=point(9, 1)).replace("agent r", "agent s")
        + f"station base at {point(5, 5)}\n"
        f"obstacle o = {box(4, 5, -1, 2)} velocity (0.25, 0.5)\n"
        "channel c { path_loss L0 = -12.89 dBm, n = 3; fading 10 dB^2; partition 5 x 5 }\n"
        "require a: eventually (distance(r, s) <= 3 m and rssi(r, base) >= -30 dBm)\n"
        "require b: always (r outside o swept and separation(r, s) >= 1 m)\nminimize effort\n"
    )


@pytest.mark.parametrize("text", [around, deep, apart])
def test_a_moved_mission_has_the_same_optimum(text: Callable[[float], str]) -> None:
    want = solve(loads(text(0.0)), OPTIONS)
    assert want.report.ok
    for far in SHIFTS:
        found = solve(loads(text(far)), OPTIONS)
        assert found.report.ok
        assert found.plan.solve.objective == pytest.approx(want.plan.solve.objective, abs=1e-5)


def test_a_moved_plan_violates_as_much() -> None:
    """Straight through the wedge, by the verifier's own shapes."""
    depths = []
    for far in (0.0, *SHIFTS):
        through = solve(loads(around(far, obstacle=False)), OPTIONS)
        report = verify(loads(around(far)), through.plan)
        assert not report.ok
        (missed,) = (r for r in report.requirements if r.name == "b")
        depths.append(missed.swept)
    assert depths[0] < -0.5
    assert depths == pytest.approx([depths[0]] * len(depths), abs=1e-5)


def test_further_away_is_an_error() -> None:
    with pytest.raises(MissionError, match="E0416") as caught:
        loads(around(1.1e8))
    assert all(d.span is not None for d in caught.value.diagnostics)
