"""Every link predicate through the whole pipeline: solved by HiGHS, certified, verified."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from stlc.api import loads, solve, verify
from stlc.channels import ChannelTables
from stlc.errors import StlcError
from stlc.ir.nodes import Quantity, Relation
from stlc.milp.compile import compile_mission
from stlc.mission import Bound, Mission
from stlc.radio.link_budget import Modulation, required_ebn0_db
from stlc.verify.report import Report

WORLD = """
step 1 s
horizon 4
workspace box [0, 8] x [0, 4]
agent a : double_integrator {
  start (1, 1)
  control |u| <= 1.5
  speed <= 2
}
agent b : double_integrator {
  start (7, 1)
  control |u| <= 1.5
  speed <= 2
}
station base at (4, 3.5)
region left = box [0, 2] x [2, 4]
"""
MODEL = """
  path_loss L0 = -40 dBm, n = 2.5
  fading 4 dB^2, shadowing 6 dB^2, length 2 m
  noise_floor -62 dBm; modulation oqpsk_802_15_4; packet 16 bytes; sensitivity -64 dBm
"""


def mission(
    *lines: str,
    cells: str = "partition 4 x 2",
    more: str = "",
    model: str = MODEL,
    folder: Path | None = None,
) -> Mission:
    channel = f"channel radio {{ {model} {cells}; {more} }}"
    return loads("\n".join([WORLD, channel, *lines]), folder=folder)


def solved(task: Mission) -> Report:
    outcome = solve(task)
    report = verify(task, outcome.plan)
    assert report.ok
    return report


PREDICATES = [
    "rssi(a, {}) >= -56 dBm",
    "snr(a, {}) >= 6 dB",
    "ber_at_mean(a, {}) <= 1e-3",
    "ber(a, {}) <= 1e-2",
    "prr(a, {}) >= 0.6",
    "P(rssi(a, {}) >= -60 dBm) >= 0.8",
]


@pytest.mark.parametrize("bound", ["centre", "worst"])
@pytest.mark.parametrize("other", ["b", "base"])
@pytest.mark.parametrize("predicate", PREDICATES)
def test_a_predicate_is_met_within_the_horizon(predicate: str, other: str, bound: str) -> None:
    text = f"require talk: eventually[1, 4] {predicate.format(other)}"
    solved(mission(text, "minimize effort", more=f"bound {bound}"))


@pytest.mark.parametrize("bound", ["centre", "worst"])
@pytest.mark.parametrize("predicate", PREDICATES)
def test_a_negated_predicate_is_met(predicate: str, bound: str) -> None:
    text = f"require hush: eventually[2, 4] not ({predicate.format('b')})"
    noisy = MODEL.replace("-62 dBm", "-54 dBm")
    solved(
        mission(
            text, "minimize effort", cells="partition 8 x 2", more=f"bound {bound}", model=noisy
        )
    )


@pytest.mark.parametrize(
    "cells",
    ["partition 5 x 3", "partition quadtree 2 x 2 tolerance 6 dB cells 20"],
)
def test_other_partitions(cells: str) -> None:
    text = "require talk: eventually[1, 4] rssi(a, base) >= -54 dBm"
    solved(mission(text, "minimize effort", cells=cells))


def test_partition_with_uneven_edges_and_starts_on_borders() -> None:
    cells = "partition [0, 1, 4, 7, 8] x [0, 1, 4]"  # both agents start on corners of cells
    text = "require talk: always rssi(a, b) >= -70 dBm and eventually rssi(a, b) >= -52 dBm"
    solved(mission(text, "minimize effort", cells=cells))


def test_agents_in_one_cell() -> None:
    text = "require meet: eventually[4, 4] (a in left and b in left and rssi(a, b) >= -50 dBm)"
    solved(mission(text, "minimize effort", cells="partition 2 x 1", more="bound centre"))


@pytest.mark.parametrize("bound", ["centre", "worst"])
def test_robustness_of_a_link_is_maximised(bound: str) -> None:
    text = "require talk: eventually[2, 4] rssi(a, base) >= -60 dBm"
    task = mission(text, "maximize robustness(talk)", more=f"bound {bound}")
    report = solved(task)
    table = ChannelTables(task).thresholds(task.requirements[0].formula.arg)
    assert report.requirements[0].robustness <= table.high.max() + 1e-6
    assert report.requirements[0].robustness > 0


@pytest.mark.parametrize("modulation", Modulation)
def test_every_modulation(modulation: Modulation) -> None:
    """Error rates of a plan, and the strength from which they are met, by its own modulation."""
    needed = required_ebn0_db(modulation, 1e-2)
    fading = "0" if modulation.rayleigh else "4"
    channel = MODEL.replace("oqpsk_802_15_4", modulation.value)
    channel = channel.replace("-62 dBm", f"{-62.0 - needed:.3f} dBm")
    channel = channel.replace("fading 4", f"fading {fading}")
    task = mission(
        "require mean: eventually[1, 4] ber_at_mean(a, base) <= 1e-2",
        "require talk: eventually[1, 4] ber(a, b) <= 3e-2",
        "require late: always[3, 4] prr(b, base) >= 0.01",
        "minimize 0.1 * effort + 0.01 * link_cost(radio, (a, b), (a, base))",
        model=channel,
        more="cost etx",
    )
    report = solved(task)
    talk = next(r for r in report.requirements if r.name == "talk")
    assert 0.0 <= talk.robustness <= 3e-2
    tables = ChannelTables(task)
    levels = tables.thresholds(task.requirements[0].formula.arg)
    strong = ChannelTables(task).thresholds(
        replace(task.requirements[0].formula.arg, quantity=Quantity.RSSI, threshold=-62.0,
                relation=Relation.AT_LEAST)
    )  # fmt: skip
    np.testing.assert_array_equal(levels.low >= 0, strong.low >= 0)


def test_rayleigh_and_a_fading_variance_count_fading_twice() -> None:
    channel = MODEL.replace("oqpsk_802_15_4", "rayleigh_bpsk")
    with pytest.raises(StlcError, match="fading"):
        compile_mission(mission("require talk: eventually[1, 4] ber(a, b) <= 3e-2", model=channel))


def test_pairs_of_agents_share_one_table() -> None:
    task = mission("minimize link_cost(radio, (a, b))")
    tables = ChannelTables(task)
    cost = tables.cost("radio", ("a", "b"))
    assert tables.cost("radio", ("b", "a")) is cost
    np.testing.assert_array_equal(cost, cost.T)


def test_a_given_table_wins_over_the_model_for_its_pair(tmp_path: Path) -> None:
    given = np.arange(64.0).reshape(8, 8)
    np.savetxt(tmp_path / "ab.csv", given, delimiter=",")
    more = 'table (a, b) "ab.csv"; cost neg_rssi'
    lines = (
        "require: always rssi(a, b) >= -90 dBm",
        "require: always link_cost(radio, (a, b)) <= 50",
    )
    task = mission(*lines, "minimize link_cost(radio, (a, b))", more=more, folder=tmp_path)
    tables = ChannelTables(task)
    np.testing.assert_array_equal(tables.cost("radio", ("a", "b")), given)
    np.testing.assert_array_equal(tables.cost("radio", ("b", "a")), given.T)
    assert tables.cost("radio", ("a", "base")).max() > 40.0
    assert tables.cost("radio", ("a", "base"), Bound.WORST).shape == (8,)
    solved(task)
