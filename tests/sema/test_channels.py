"""Channels: values, data files, partitions, links."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

from stlc.api import loads
from stlc.errors import MissionError
from stlc.ir.nodes import Always, Link, Node, Not, Or, Quantity, Relation
from stlc.mission import Bound, Channel, Mission
from stlc.radio.kernel import KernelName
from stlc.radio.link_budget import Modulation

HEAD = """
horizon 3
workspace box [0, 10] x [0, 4]
agent a : double_integrator { start (1, 1) }
agent b : double_integrator { start (9, 1) }
station base at (5, 0) { height 2 m }
channel radio {
"""
LOSS = "path_loss L0 = -40 dBm, n = 2.5; fading 10 dB^2; "
SAMPLES = "tx_x,tx_y,rx_x,rx_y,rssi_dbm\n" + "".join(
    f"{x},{y},{9 - x},{3 - y},{-40 - 25 * math.log10(math.hypot(9 - 2 * x, 3 - 2 * y)):.3f}\n"
    for x in range(4)
    for y in range(4)
)


def mission(channel: str, rest: str = "", folder: Path | None = None) -> Mission:
    text = f"{HEAD}{channel}\n}}\nrequire: always separation(a, b) >= 0.1 m\n{rest}\n"
    return loads(text, folder=folder)


def radio(channel: str, folder: Path | None = None) -> Channel:
    return mission(channel, folder=folder).channels["radio"]


def link(predicate: str) -> Node:
    channel = LOSS + "noise_floor -90 dBm; modulation bpsk; packet 32 bytes; partition 2 x 2"
    found = mission(channel, f"require: always {predicate}").requirements[1].formula
    assert isinstance(found, Always)
    return found.arg


def codes(channel: str, rest: str = "", folder: Path | None = None) -> list[str]:
    with pytest.raises(MissionError) as caught:
        mission(channel, rest, folder)
    return [d.code for d in caught.value.diagnostics]


def test_every_value() -> None:
    found = radio(
        LOSS + "shadowing 3 dB; deviation 2 dB; length 2 m; d0 50 cm; kernel paper_min;"
        "bandwidth 2 MHz;"
        "noise_figure 5 dB; rate 250 kbit/s; modulation oqpsk_802_15_4; packet 32 bytes;"
        "sensitivity -95 dBm; partition 5 x 2; cost outage; bound centre; cost_bound worst"
    )
    model, budget = found.model, found.budget
    assert model is not None
    assert budget is not None
    assert (model.l0, model.exponent, model.fading, model.shadowing) == (-40, 2.5, 10, 9)
    assert model.deviation == 4
    assert (model.length, model.d0, model.kernel) == (2.0, 0.5, KernelName.PAPER_MIN)
    assert budget.noise_floor == pytest.approx(-174 + 10 * math.log10(2e6) + 5)
    assert (budget.bandwidth, budget.rate, budget.packet) == (2e6, 250e3, 32)
    assert (budget.modulation, budget.sensitivity) == (Modulation.OQPSK_802_15_4, -95)
    assert (found.cost, found.predicate_bound, found.cost_bound) == (
        "outage",
        Bound.CENTRE,
        Bound.WORST,
    )
    assert found.partition.shape == (5, 2)
    assert found.partition.boxes[1].tolist() == [0, 2, 2, 4]


def test_no_noise_floor_is_not_a_number() -> None:
    budget = radio(LOSS + "partition 2 x 2").budget
    assert budget is not None
    assert math.isnan(budget.noise_floor)


def test_partitions_by_edges() -> None:
    found = radio(LOSS + "partition [0, 3, 10] x [0, 1, 2, 4]").partition
    assert found.shape == (2, 3)
    assert codes(LOSS + "partition [0, 3, 9] x [0, 4]") == ["E0208"]
    assert codes(LOSS + "partition [0, 3, 3, 10] x [0, 4]") == ["E0208"]
    assert codes(LOSS + "partition 1000 x 1000") == ["E0208"]


def test_a_quadtree_is_finer_where_the_strength_varies() -> None:
    found = radio(LOSS + "partition quadtree 2 x 2 tolerance 3 dB cells 40").partition
    assert 4 < len(found) <= 40
    assert found.edges is None


def test_samples_condition_the_channel(tmp_path: Path) -> None:
    (tmp_path / "rssi.csv").write_text(SAMPLES)
    found = radio(
        LOSS + 'shadowing 10 dB^2; length 2 m; partition 2 x 2; samples "rssi.csv"', tmp_path
    )
    assert found.model is not None
    assert found.model.posterior is not None
    assert found.model.posterior.samples == 16


def test_a_fit_needs_no_path_loss(tmp_path: Path) -> None:
    (tmp_path / "rssi.csv").write_text(SAMPLES)
    found = radio('partition 2 x 2; samples "rssi.csv" fit', tmp_path)
    assert found.model is not None
    assert found.model.exponent == pytest.approx(2.5, abs=0.2)


def test_what_a_fit_has_to_say_is_a_warning(tmp_path: Path) -> None:
    (tmp_path / "rssi.csv").write_text(SAMPLES)
    text = 'partition 2 x 2; samples "rssi.csv" fit floor -58 dBm'
    found = mission(text, folder=tmp_path).warnings
    assert "at or below the noise floor" in str(next(d for d in found if d.code == "W1009"))


def test_tables(tmp_path: Path) -> None:
    table = np.arange(16.0).reshape(4, 4)
    np.savez(tmp_path / "cost.npz", table)
    (tmp_path / "cost.csv").write_text("\n".join(",".join(map(str, row)) for row in table))
    for name in ("cost.npz", "cost.csv"):
        found = radio(f'partition 2 x 2; table "{name}"', tmp_path)
        assert found.model is None
        assert np.array_equal(found.tables[None], table)
    pairs = radio('partition 2 x 2; table (a, b) "cost.csv" (b, a) "cost.npz"', tmp_path)
    assert set(pairs.tables) == {("a", "b"), ("b", "a")}
    assert codes('partition 2 x 2; table "cost.txt"', folder=tmp_path) == ["E0215"]
    text = 'partition 2 x 2; table (a, base) "cost.csv"'
    assert codes(text, "minimize link_cost(radio)", tmp_path) == ["E0602"]


def test_link_predicates() -> None:
    assert link("rssi(a, b) + 3 dB >= -70 dBm") == Link(
        "radio", Quantity.RSSI, "a", "b", Relation.AT_LEAST, -73.0
    )
    assert link("2 * ber(a, base) <= 1e-3") == Link(
        "radio", Quantity.BER, "a", "base", Relation.AT_MOST, 5e-4, factor=2.0
    )
    assert link("0.9 <= prr(b, a, radio)") == Link(
        "radio", Quantity.PRR, "b", "a", Relation.AT_LEAST, 0.9
    )
    both = link("max(snr(a, b), snr(a, base)) >= 3")
    assert isinstance(both, Or)
    assert [part.receiver for part in both.args if isinstance(part, Link)] == ["b", "base"]


def test_chances() -> None:
    sure = link("P(rssi(a, b) >= -70 dBm) > 0.9")
    assert isinstance(sure, Link)
    assert (sure.probability, sure.threshold) == (0.9, -70.0)
    assert link("0.9 <= P(rssi(a, b) >= -70 dBm)") == sure
    rarely = link("P(rssi(a, b) >= -70 dBm) <= 0.9")
    assert isinstance(rarely, Not)
    assert rarely.arg == sure


def test_costs_in_formulas() -> None:
    found = link("link_cost(radio, (a, b)) <= 2")
    assert isinstance(found, Link)
    assert (found.quantity, found.threshold) == (Quantity.COST, 2.0)


@pytest.mark.parametrize(
    ("channel", "rest", "code"),
    [
        ("partition 2 x 2", "", "E0601"),
        (LOSS + "partition 2 x 2", "minimize link_cost(radio)", "E0601"),
        (LOSS + "partition 2 x 2; noise_floor -90 dBm; cost etx", "minimize link_cost", "E0601"),
        (LOSS + "partition 2 x 2; cost outage", "minimize link_cost(radio)", "E0601"),
        (LOSS + "partition 2 x 2; modulation qam", "", "E0208"),
        (LOSS + "partition 2 x 2; packet 3 m", "", "E0306"),
        (LOSS + "partition 2 x 2; rate 250 kbit/s", "", "E0208"),
        (LOSS + "partition 2 x 2; fading -3 dB^2", "", "E0202"),
        (LOSS + "partition 2 x 2; length -3 m", "", "E0208"),
    ],
)
def test_mistakes(channel: str, rest: str, code: str) -> None:
    assert codes(channel, rest) == [code]


def titles(text: str) -> list[str]:
    with pytest.raises(MissionError) as caught:
        loads(text)
    return [d.title_text for d in caught.value.diagnostics]


@pytest.mark.parametrize(
    "text",
    [
        HEAD.replace("[0, 10]", "[0 10]") + LOSS + "partition 2 x 2\n}",
        HEAD.replace("[0, 10]", "[10, 0]") + LOSS + "partition 2 x 2\n}",
        HEAD + LOSS + "partition 2 x 2\nrequire: always rssi(a, b) >= -70 dBm",
    ],
)
def test_a_broken_workspace_or_channel_is_one_mistake(text: str) -> None:
    assert len(titles(text)) == 1


def test_without_a_workspace_the_channel_says_so() -> None:
    text = HEAD.replace("workspace box [0, 10] x [0, 4]", "") + LOSS + "partition 2 x 2\n}"
    assert titles(text) == ["channel `radio`: a partition needs a workspace"]


def test_a_word_that_ends_too_early_is_completed() -> None:
    with pytest.raises(MissionError) as caught:
        mission(f"{LOSS} partition 2 x 2; modulation oqpsk")
    (found,) = caught.value.diagnostics
    assert found.help_text == "write it as `modulation oqpsk_802_15_4`"


def test_packets_not_heard_lie_below_the_floor(tmp_path: Path) -> None:
    rows = SAMPLES.splitlines()
    heard = rows[1].rsplit(",", 1)[0]
    (tmp_path / "rssi.csv").write_text("\n".join([*rows, f"{heard},127", f"{heard},-999"]))
    said = "floor -58 dBm not_heard 127 not_heard -999"
    text = f'partition 2 x 2; samples "rssi.csv" fit {said}'
    found = mission(text, folder=tmp_path).warnings
    assert "censored" in str(next(d for d in found if d.code == "W1009"))
