"""Random small missions with link costs, one for each kind of mission that `stlc` reads.

Starts, goals, obstacle faces and cell borders lie on one coarse raster, so that they often
coincide.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from stlc.api import loads
from stlc.mission import Mission

SIZE = 6
STEPS = 4
_SPEED = "speed <= 2 polygon 8 outer"
_MODEL = """
  path_loss L0 = -40 dBm, n = 2.5
  fading 4 dB^2, shadowing 6 dB^2, length 2 m
  noise_floor -56 dBm; modulation oqpsk_802_15_4; packet 16 bytes; sensitivity -56 dBm
"""


@dataclass(frozen=True, slots=True)
class Kind:
    """What sets a kind apart from two double integrators on a 4 x 4 grid with a table.

    agents   what each is: its dynamics and properties but the start
    channels channel blocks: {table} is a symmetric random table of `cells` cells
    spread   standard deviation of the table's logarithm
    goals    requirements for each agent; {a} its name, {g} and {h} regions near its start
    more     further lines
    cost     the objective
    """

    agents: tuple[str, ...] = (f"double_integrator {{ control |u| <= 1; {_SPEED} }}",) * 2
    channels: str = "channel radio { partition 4 x 4; {table} }"
    cells: int = 16
    spread: float = 0.7
    goals: str = "eventually[2, {T}] {a} in {g}"
    more: str = ""
    cost: str = "0.2 * effort + 0.9 * link_cost(radio)"
    dt: float = 1.0
    steps: int = STEPS
    known: bool = True  # whether the search takes it on


_DOUBLE = Kind().agents[0]
_SINGLE = "single_integrator { control |u| <= 1.5 }"
_DISC = "single_integrator { control |u| <= 1.6 polygon 8 }"
_HEAVY = f"double_integrator {{ mass 2 kg; control |u| <= 2 N; {_SPEED} }}"
_FAST = "double_integrator { control |u| <= 4; speed <= 4 polygon 8 }"
_TURNING = "double_integrator { control |u| <= 1; speed <= 2 polygon 8; turn_rate on }"
_WEIGHED = (
    "double_integrator { control |u| <= 1; "
    f"{_SPEED}; effort_state (0.3, 0, 1, 0.5); effort_input (2, 1) }}"
)
_DRAG = "boat { control |u| <= 2; state |v| <= 2 }"
_TIED = "tied { control |u| <= 1; vx in [-2, 2]; vy in [-2, 2] }"
_STAIR = "stair { control |u| <= 1 }"


def _model(extra: str, cells: str = "partition 4 x 4") -> str:
    return f"channel radio {{ {_MODEL} {cells}; {extra} }}"


_LOUD = _model("cost neg_rssi").replace("-40 dBm", "10 dBm")
_STATION = "station base at (4.3, 1.7)\n"

KINDS: dict[str, Kind] = {
    "plain": Kind(),
    "quadtree": Kind(channels=_model("", "partition quadtree 2 x 2 tolerance 2 dB cells 10")),
    "quadtree station": Kind(
        channels=_model("", "partition quadtree 2 x 2 tolerance 1 dB cells 13"),
        more=_STATION, cost="0.1 * effort + link_cost(radio, (a0, a1), (a0, base))",
    ),
    "wide": Kind(channels="channel radio { partition 5 x 2; {table} }", cells=10),
    "uneven": Kind(
        channels="channel radio { partition [0, 1, 3, 6] x [0, 2, 2.5, 6]; {table} }", cells=9
    ),
    "two channels": Kind(
        channels="channel radio { partition 4 x 4; {table} }\n"
        "channel voice { partition 4 x 4; {table} }",
        cost="0.2 * effort + 0.5 * link_cost(radio) + 0.4 * link_cost(voice)",
    ),
    "two partitions": Kind(
        channels="channel radio { partition 4 x 4; {table} }\n"
        "channel voice { partition 2 x 8; {table} }",
        cost="0.2 * effort + 0.5 * link_cost(radio) + 0.4 * link_cost(voice, (a1, a0))",
    ),
    "station": Kind(
        more=_STATION,
        cost="0.2 * effort + link_cost(radio, (a1, a0)) + 0.5 * link_cost(radio, (a1, base))",
    ),
    "lone third": Kind(
        agents=(_DOUBLE, _DOUBLE, _SINGLE), more=_STATION, steps=3, channels=_LOUD,
        cost="0.2 * effort + link_cost(radio, (a0, a1)) + 2 * link_cost(radio, (a2, base))",
    ),
    "three": Kind(agents=(_DOUBLE, _SINGLE, _DOUBLE), steps=3),
    "chain": Kind(
        agents=(_DOUBLE,) * 3, more=_STATION, steps=3,
        cost="0.1 * effort + link_cost(radio, (a0, a1), (a1, a2), (a2, base))",
    ),
    "window": Kind(cost="0.2 * effort[1, 2] + 0.9 * link_cost(radio)[2, 3]"),
    "two windows": Kind(
        cost="0.2 * effort(a0) + link_cost(radio)[1, 2] + 3 * link_cost(radio, (a1, a0))[3, 4]"
    ),
    "normalised": Kind(cost="normalised(effort) + 3 * normalised(link_cost(radio))"),
    "negative": Kind(channels=_LOUD),
    "mixed signs": Kind(
        channels=_LOUD + "\nchannel voice { partition 4 x 4; {table} }",
        cost="0.2 * effort + 0.1 * link_cost(radio)[1, 3] + 0.7 * link_cost(voice)[2, 4]",
    ),
    "zero effort": Kind(cost="0 * effort + link_cost(radio)"),
    "robustness beside": Kind(
        cost="0 * effort + link_cost(radio) - 0.5 * robustness(go_a0)", known=False
    ),
    "heavy tails": Kind(spread=4.0),
    "large": Kind(cost="200 * effort + 900 * link_cost(radio)"),
    "small": Kind(cost="2e-4 * effort + 9e-4 * link_cost(radio)"),
    **{
        cost: Kind(channels=_model(f"cost {cost}"))
        for cost in ("inv_snr", "etx", "neg_log_prr", "outage", "neg_rssi", "paper_inv_rssi")
    },
    "worst cost": Kind(channels=_model("cost_bound worst")),
    "single": Kind(agents=(_SINGLE,) * 2),
    "disc": Kind(agents=(_DISC, _DISC)),
    "one of each": Kind(agents=(_SINGLE, _DOUBLE)),
    "mass": Kind(agents=(_HEAVY, _DOUBLE)),
    "half steps": Kind(agents=(_FAST,) * 2, dt=0.5),
    "weighed states": Kind(agents=(_WEIGHED, _WEIGHED)),
    "turn rate": Kind(agents=(_TURNING, _DOUBLE), steps=3),
    "drag": Kind(agents=(_DRAG, _DOUBLE), known=False),
    "one input for both axes": Kind(agents=(_TIED, _DOUBLE), known=False),
    "one axis drives the other": Kind(agents=(_STAIR, _DOUBLE), known=False),
    "whole inputs": Kind(
        agents=("double_integrator { control |u| <= 1; integer }", _DOUBLE), known=False
    ),
    "several goals": Kind(
        goals="eventually[1, 3] {a} in {g} and eventually[2, {T}] {a} in {h}", steps=5
    ),
    "stay": Kind(goals="eventually[1, {T} - 1] always[0, 1] {a} in {g}"),
    "either goal": Kind(goals="eventually[1, {T}] ({a} in {g} or {a} in {h})"),
    "together": Kind(goals="true", more="require: eventually[1, 4] (a0 in g0 and a1 in g1)"),
    "until": Kind(goals="{a}.x <= 5 until[1, {T}] {a} in {g}"),
    "nested": Kind(goals="always[0, 2] ({a} in {g} or eventually[1, 2] {a} in {h})"),
    "implies": Kind(
        goals="true", more="require: always[1, 4] (a0.x >= 2 implies a1 in g1)\n"
        "require: eventually[2, 4] a0 in h0",
    ),
    "margins": Kind(more="margin 0.2"),
    "swept": Kind(more="require: always[0, 2] a0 outside block swept", steps=3),
    "swept apart": Kind(more="require: always separation(a0, a1) >= 0.5 swept", steps=3),
    "triangle": Kind(
        more="obstacle roof = polygon (1, 1) (3, 1) (2, 3)\nrequire: always a1 outside roof"
    ),
    "moving": Kind(
        more="obstacle cart = moving { 0: box [2, 3] x [2, 3]; 2: box [3, 4] x [2, 3] }\n"
        "require: always[1, {T}] a0 outside cart"
    ),
    "cut corner": Kind(more="require: always a0.x + a0.y <= 9"),
    "talk": Kind(
        channels=_model(""), more="require: eventually[1, 4] rssi(a0, a1) >= -56 dBm"
    ),
    "talk surely": Kind(
        channels=_model(""), more="require: always[2, 4] P(rssi(a0, a1) >= -62 dBm) >= 0.9"
    ),
    "hush": Kind(
        channels=_model("bound centre"),
        more="require: eventually[2, 4] not rssi(a0, a1) >= -50 dBm",
    ),
    "only talk": Kind(
        channels=_model(""), more="require: always[2, 4] rssi(a0, a1) >= -57 dBm", cost="effort"
    ),
    "only hush": Kind(
        channels=_model("bound centre"),
        more="require: always[2, 4] not rssi(a0, a1) >= -50 dBm", cost="effort(a0)",
    ),
    "talk to a station": Kind(
        channels=_model(""),
        more=_STATION + "require: always[2, 3] rssi(a0, base) >= -57 dBm\n"
        "require: always[3, 4] rssi(a1, a0) >= -60 dBm",
        cost="0.1 * effort + 0.01 * link_cost(radio, (a0, a1))",
    ),
    "dear link": Kind(more="require: always[2, 4] link_cost(radio, (a0, a1)) <= 3"),
}  # fmt: skip


def write_kind(folder: Path, kind: Kind, seed: int) -> Mission:
    """A mission of a kind. Raises MissionError for a draw that makes none."""
    rng = np.random.default_rng(seed)
    corner = rng.integers(1, SIZE - 2, 2)
    hole = np.stack([corner, corner + rng.integers(1, 3, 2)], 1)
    lines = [
        f"step {kind.dt:g} s", f"horizon {kind.steps}", f"workspace box [0, {SIZE}] x [0, {SIZE}]",
        *_DYNAMICS,
        f"obstacle block = box [{hole[0, 0]}, {hole[0, 1]}] x [{hole[1, 0]}, {hole[1, 1]}]",
    ]  # fmt: skip
    for i, what in enumerate(kind.agents):
        start = _free_point(rng, hole)
        name, dynamics, rest = f"a{i}", *what.split(" ", 1)
        zero = ", 0, 0" if "double" not in dynamics and "single" not in dynamics else ""
        if dynamics == "stair":
            zero = ""
        place = f"start ({start[0]}, {start[1]}{zero}); "
        lines.append(f"agent {name} : {dynamics} {rest.replace('{ ', '{ ' + place, 1)}")
        for region in "gh":
            low = np.clip(start + rng.integers(-2, 3, 2), 0, SIZE - 1)
            lines.append(
                f"region {region}{i} = box [{low[0]}, {low[0] + 1}] x [{low[1]}, {low[1] + 1}]"
            )
        goal = kind.goals.format(a=name, g=f"g{i}", h=f"h{i}", T=kind.steps)
        lines.append(f"require go_{name}: {goal}")
        lines.append(f"require clear_{name}: always[1, {kind.steps}] {name} outside block")
    lines += [
        _with_tables(folder, kind, rng), kind.more.replace("{T}", str(kind.steps)),
        f"require apart: always[1, {kind.steps}] separation(a0, a1) >= 0.5",
        f"minimize {kind.cost}",
    ]  # fmt: skip
    return loads("\n".join(lines) + "\n", folder=folder)


_DYNAMICS = (
    "dynamics boat { A = [[1, 0, 1, 0], [0, 1, 0, 1], [0, 0, 0.8, 0], [0, 0, 0, 0.8]]; "
    "B = [[0.5, 0], [0, 0.5], [1, 0], [0, 1]]; states px py vx vy; inputs ux uy; "
    "position px py; velocity vx vy }",
    "dynamics tied { A = [[1, 0, 1, 0], [0, 1, 0, 1], [0, 0, 1, 0], [0, 0, 0, 1]]; "
    "B = [[0.5], [0.5], [1], [1]]; states px py vx vy; inputs u; "
    "position px py; velocity vx vy }",
    "dynamics stair { A = [[1, 0.5], [0, 1]]; B = [[0.25], [1]]; states px py; inputs u; "
    "position px py }",
)


def _with_tables(folder: Path, kind: Kind, rng: np.random.Generator) -> str:
    text, number = kind.channels, 0
    while "{table}" in text:
        table = np.exp(kind.spread * rng.normal(size=(kind.cells, kind.cells)))
        np.savetxt(folder / f"cost{number}.csv", table + table.T, delimiter=",")
        text = text.replace("{table}", f'table "cost{number}.csv"', 1)
        number += 1
    return text


def _free_point(rng: np.random.Generator, hole: np.ndarray) -> np.ndarray:
    while True:
        point: np.ndarray = rng.integers(0, SIZE + 1, 2)
        if not ((point > hole[:, 0]) & (point < hole[:, 1])).all():
            return point
