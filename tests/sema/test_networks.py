"""What `connected`, `route` and `count` mean, in text and in the intermediate representation."""

from __future__ import annotations

import pytest

from stlc.api import loads
from stlc.errors import MissionError
from stlc.ir.networks import Count, Network
from stlc.ir.nodes import Always, And, Const, Link, Node, Not, Or
from stlc.ir.parser import parse_node
from stlc.ir.printer import print_node
from stlc.source import Source
from stlc.syntax.parse import parse
from stlc.syntax.printer import format_file

HEAD = """
horizon 4
workspace box [0, 10] x [0, 10]
agent r[1..3] : single_integrator { start (2 * i, 2); control |u| <= 1 }
station base at (0, 0)
station mast at (9, 9)
channel radio {
  path_loss L0 = -12.89 dBm, n = 3
  fading 10 dB^2
  noise_floor -60 dBm, modulation oqpsk_802_15_4, packet 32 bytes
  cost etx
  partition 4 x 4
}
"""


def _formula(text: str) -> Node:
    return loads(f"{HEAD}require a: {text}\n").requirements[0].formula


def _body(text: str) -> Node:
    formula = _formula(f"always {text}")
    assert isinstance(formula, Always)
    return formula.arg


def test_connected_has_an_edge_for_each_pair_of_radios() -> None:
    node = _body("connected([agents, base], radio, rssi >= -40 dBm)")
    assert isinstance(node, Network)
    assert node.vertices == ("r[1]", "r[2]", "r[3]", "base")
    assert len(node.args) == 6
    ends = [(a.sender, a.receiver) for a in node.args if isinstance(a, Link)]
    assert ends == [(node.vertices[a], node.vertices[b]) for a, b in node.ends]


def test_two_stations_have_a_link_that_never_changes() -> None:
    node = _body("connected([base, mast, r[1]], rssi >= -40 dBm)")
    assert isinstance(node, Network)
    first = node.args[0]
    assert isinstance(first, Link)
    assert (first.sender, first.receiver) == ("base", "mast")


def test_a_route_relays_by_all_agents_unless_some_are_named() -> None:
    node = _body("route(r[1], base, prr >= 0.9)")
    assert isinstance(node, Network)
    assert node.vertices == ("r[1]", "base", "r[2]", "r[3]")
    assert (node.hops, node.composed) == (3, True)
    named = _body("route(r[1], base, [r[3], mast], hops <= 2, snr >= 3 dB)")
    assert isinstance(named, Network)
    assert named.vertices == ("r[1]", "base", "r[3]", "mast")
    assert (named.hops, named.composed) == (2, False)


@pytest.mark.parametrize(
    "condition", ["P(rssi >= -40 dBm) >= 0.9", "rssi >= -40 dBm and snr >= 3 dB", "snr >= 3 dB"]
)
def test_any_formula_of_one_link_is_a_condition(condition: str) -> None:
    node = _body(f"route(r[1], base, {condition})")
    assert isinstance(node, Network)
    assert not node.composed


@pytest.mark.parametrize(
    ("text", "least"),
    [
        ("count(b in agents: rssi(r[1], b) >= -40 dBm) >= 2", 2),
        ("count(b in agents: rssi(r[1], b) >= -40 dBm) > 1", 2),
        ("1.5 <= count(b in agents: rssi(r[1], b) >= -40 dBm)", 2),
    ],
)
def test_counts_leave_out_a_radio_with_itself(text: str, least: int) -> None:
    node = _body(text)
    assert isinstance(node, Count)
    assert (node.least, len(node.args)) == (least, 2)


def test_fewer_is_the_negation_of_more() -> None:
    node = _body("count((a, b) in pairs: separation(a, b) >= 2 m) <= 1")
    assert isinstance(node, Not)
    assert isinstance(node.arg, Count)
    assert (node.arg.least, len(node.arg.args)) == (2, 3)
    assert isinstance(_body("count(a in agents: a.x >= 2 m) == 2"), And)
    assert isinstance(_body("count(a in agents: a.x >= 2 m) != 2"), Or)
    with pytest.raises(MissionError, match="E0705"):
        _body("count(a in agents: a.x >= 2 m) >= 4")
    assert _body("count(a in agents: a.x >= 2 m) >= 0") == Const(True)


@pytest.mark.parametrize(
    "text",
    [
        "connected(agents, rssi >= -40 dBm)",
        "not connected(agents, rssi >= -40 dBm)",
        "route(r[1], base, hops <= 2, prr >= 0.9)",
        "route(r[1], base, hops <= 2, link_cost <= 4)",
        "route(r[1], base, hops <= 2, snr >= 3 dB)",
        "count(a in agents: a.x >= 2 m) >= 2",
    ],
)
def test_texts_of_the_representation_and_of_files_read_back(text: str) -> None:
    node = _formula(text)
    assert parse_node(print_node(node)) == node
    source = f"{HEAD}require a: {text}\n"
    printed = format_file(parse(Source("a.stl", source)).file)
    assert text in printed
    assert loads(printed).requirements[0].formula == node


@pytest.mark.parametrize(
    "line",
    [
        "require always route(a, base, hops <= 2, prr >= 0.9)",
        "require always connected([a, b, base], radio, rssi >= -60 dBm)",
        "require always count(x in agents: rssi(x, base) >= -60 dBm) >= 1",
        "require always link_cost(radio, (a, b)) <= 3",
        "minimize link_cost(radio, (a, b))",
    ],
)
def test_a_channel_with_mistakes_is_the_only_mistake(line: str) -> None:
    text = f"""step 1 s
horizon 2
workspace box [0, 9] x [0, 9]
agent a : single_integrator {{ start (1, 1); control |u| <= 1 }}
agent b : single_integrator {{ start (2, 1); control |u| <= 1 }}
station base at (5, 5)
channel radio {{ }}
{line}
"""
    with pytest.raises(MissionError) as caught:
        loads(text)
    assert {d.code for d in caught.value.diagnostics} == {"E0601"}
