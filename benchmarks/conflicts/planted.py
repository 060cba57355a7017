"""Missions without a plan, by family and seed: five agents with work of their own, one conflict.

Everything beside the planted clauses can be done, with room to spare, so that a conflict has to
name planted clauses only.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

Random = np.random.Generator

_WORLD = """step 1 s
horizon {horizon}
workspace box [0, 12] x [0, 12]
agent a : double_integrator {{ start (1, {y:g}); {limits} }}
agent b : double_integrator {{ start (1, 10); control |u| <= 1; speed <= 2 }}
agent c : double_integrator {{ start (10, 10); control |u| <= 1; speed <= 2 }}
agent d : double_integrator {{ start (10, 1); control |u| <= 1; speed <= 2 }}
agent e : double_integrator {{ start (11, 3); control |u| <= 1; speed <= 2 }}
station base at (6, 0)
region near_b = box [4, 7] x [9, 12]
region near_c = box [8, 11] x [6, 9]
region near_d = box [7, 10] x [3, 5]
obstacle pillar = box [5, 6] x [5, 6] inflate 0.2 m
channel radio {{
  path_loss L0 = -40 dBm, n = 3; fading 4 dB^2, shadowing 4 dB^2, length 3 m
  partition {grid}
}}
{declared}
require clear: always forall r in agents: r outside pillar
require work_b: eventually[0, 8] b in near_b
require work_c: eventually[0, 8] (c in near_c and c.vy <= 1)
require work_d: eventually[0, 8] d in near_d
require work_e: eventually[0, 9] e in near_b
require apart_bc: always separation(b, c) >= 0.5 m swept
require apart_de: always separation(d, e) >= 0.5 m swept
require apart_be: always separation(b, e) >= 0.5 m swept
require heard: always[4, 8] rssi(d, base) >= -80 dBm
{planted}
minimize effort
"""

_LIMITS = "control |u| <= 1; speed <= 2"


@dataclass(frozen=True, slots=True)
class Planted:
    """A mission without a plan; `causes` are sets of names of requirements that conflict."""

    family: str
    seed: int
    text: str
    causes: tuple[frozenset[str], ...]
    given: str = ""  # a kind of given that takes part, where one must

    @property
    def name(self) -> str:
        """`link-3`."""
        return f"{self.family}-{self.seed}"


@dataclass(frozen=True, slots=True)
class _Parts:
    """What a family adds to the world."""

    planted: str
    causes: tuple[frozenset[str], ...]
    declared: str = ""
    limits: str = _LIMITS
    grid: str = "6 x 6"
    given: str = ""


def planted(family: str, seed: int) -> Planted:
    """The mission of a family and a seed."""
    rng = np.random.default_rng([seed, *family.encode()])
    parts = FAMILIES[family](rng)
    text = _WORLD.format(
        horizon=10, y=_number(rng, 1, 2), limits=parts.limits, grid=parts.grid,
        declared=parts.declared, planted=parts.planted,
    )  # fmt: skip
    return Planted(family, seed, text, parts.causes, parts.given)


def everything() -> tuple[Planted, ...]:
    """Sixty of them."""
    counts = dict.fromkeys(FAMILIES, 7) | {"chance": 6, "contradiction": 6, "bounds": 6}
    return tuple(planted(f, seed) for f, n in counts.items() for seed in range(n))


def _number(rng: Random, low: float, high: float) -> float:
    return round(float(rng.uniform(low, high)), 1)


def _deadline(rng: Random) -> _Parts:
    """A goal that takes six steps and more, by a step before."""
    x, end = _number(rng, 9, 10), int(rng.integers(2, 5))
    return _Parts(
        f"require late: eventually[0, {end}] a in goal", (frozenset({"late"}),),
        f"region goal = box [{x:g}, 12] x [1, 3]",
    )  # fmt: skip


def _geometry(rng: Random) -> _Parts:
    """A goal behind a wall from border to border, or above a line not to be crossed."""
    if rng.random() < 0.5:
        x = _number(rng, 3, 5)
        return _Parts(
            "require go: eventually a in goal\nrequire out: always a outside wall swept",
            (frozenset({"go", "out"}),),
            f"region goal = box [{x + 2:g}, {x + 4:g}] x [0.5, 3]\n"
            f"obstacle wall = box [{x:g}, {x + 0.5:g}] x [0, 12]",
        )
    line, end = _number(rng, 3, 4), int(rng.integers(8, 11))
    return _Parts(
        f"require go: eventually[0, {end}] a in goal\nrequire low: always a.y <= {line:g} m",
        (frozenset({"go", "low"}),), f"region goal = box [1, 3] x [{line + 0.5:g}, 6]",
    )  # fmt: skip


def _separation(rng: Random) -> _Parts:
    """Two agents in one small place at the same time, and apart."""
    step, wide = int(rng.integers(7, 10)), _number(rng, 1, 2)
    return _Parts(
        f"require a_in: always[{step}, {step}] a in dock\n"
        f"require b_in: always[{step}, {step}] b in dock\n"
        f"require apart: always separation(a, b) >= {wide + 0.5:g} m",
        (frozenset({"a_in", "b_in", "apart"}),),
        f"region dock = box [1, {1 + wide:g}] x [5, {5 + wide:g}]",
    )


def _link(rng: Random) -> _Parts:
    """A far place and a strong link at the same time."""
    step, level = int(rng.integers(7, 10)), _number(rng, -60, -56)
    return _Parts(
        f"require visit: always[{step}, {step}] a in corner\n"
        f"require talk: always[{step - 1}, {step}] rssi(a, base) >= {level:g} dBm",
        (frozenset({"visit", "talk"}),), "region corner = box [0, 2] x [6, 8]",
    )  # fmt: skip


def _partition(rng: Random) -> _Parts:
    """A link that is there at points of the cells, and in no whole cell."""
    level, start = _number(rng, -61, -58), int(rng.integers(4, 7))
    return _Parts(
        f"require talk: eventually[{start}, 10] rssi(a, base) >= {level:g} dBm",
        (frozenset({"talk"}),), grid="2 x 2", given="partition",
    )  # fmt: skip


def _chance(rng: Random) -> _Parts:
    """More certain than a link at that distance is."""
    p, step = (0.9, 0.95, 0.99)[int(rng.integers(3))], int(rng.integers(2, 4))
    level = _number(rng, -52, -48)
    return _Parts(
        f"require sure: always[{step}, {step + 3}] P(rssi(a, base) >= {level:g} dBm) >= {p:g}",
        (frozenset({"sure"}),),
    )


def _contradiction(rng: Random) -> _Parts:
    """Two places at once, or above and below."""
    x, end = _number(rng, 2, 3), int(rng.integers(5, 9))
    places = f"region one = box [{x:g}, 4] x [1, 3]\nregion two = box [4.5, 6] x [1, 3]"
    if rng.random() < 0.5:
        formula = f"eventually[2, {end}] (a in one and a.vx <= 1 and a in two)"
    else:
        formula = f"a.x <= 11 until[2, {end}] (a.y >= {x + 2:g} and a.y <= {x + 1:g})"
    return _Parts(f"require both: {formula}", (frozenset({"both"}),), places)


def _bounds(rng: Random) -> _Parts:
    """A robot that is too weak, or too slow, overall or along one axis."""
    which = int(rng.integers(3))
    limits = (
        f"control |u| <= {_number(rng, 0.05, 0.15):g}; speed <= 2",
        f"control |u| <= 1; speed <= {_number(rng, 0.3, 0.6):g}",
        f"control |u| <= 1; vx in [-2, {_number(rng, 0.3, 0.6):g}]",
    )
    return _Parts(
        "require go: eventually[0, 10] a in goal", (frozenset({"go"}),),
        "region goal = box [9, 10] x [1, 3]", limits[which],
        given=("control", "speed", "speed")[which],
    )  # fmt: skip


def _several(rng: Random) -> _Parts:
    """Three conflicts at once: of a by itself, of b by itself, of b and c."""
    end = int(rng.integers(2, 5))
    return _Parts(
        f"require late: eventually[0, {end}] a in goal\n"
        "require low: always b.y <= 8.5\n"
        "require meet: always[9, 9] separation(b, c) <= 1 m\n"
        "require far: always[9, 9] separation(b, c) >= 1.2 m",
        (frozenset({"late"}), frozenset({"low"}), frozenset({"meet", "far"})),
        "region goal = box [9, 12] x [1, 3]",
    )


FAMILIES: dict[str, Callable[[Random], _Parts]] = {
    "deadline": _deadline,
    "geometry": _geometry,
    "separation": _separation,
    "link": _link,
    "partition": _partition,
    "chance": _chance,
    "contradiction": _contradiction,
    "bounds": _bounds,
    "several": _several,
}
