"""What multiplies a link quality in the file scales its robustness, wherever it is judged."""

from __future__ import annotations

import pytest

from stlc import api
from stlc.ir.nodes import Link, walk
from stlc.ir.parser import parse_node
from stlc.ir.printer import print_node
from stlc.plan import Plan
from stlc.verify import Report, verify

MISSION = """step 1 s
horizon 3
workspace box [0, 10] x [0, 10]
agent a : single_integrator {{ start (1, 1); control |u| <= 2 }}
agent b : single_integrator {{ start (8, 8); control |u| <= 2 }}
channel radio {{
  path_loss L0 = -40 dBm, n = 2
  fading 4 dB^2; shadowing 4 dB^2; length 2 m
  noise_floor -60 dBm, modulation oqpsk_802_15_4, packet 32 bytes
  partition 4 x 4; bound mean
}}
require r: {formula}
{objective}
"""
SAME = [
    ("2 * prr(a, b) >= 0.1", "prr(a, b) >= 0.05", 2.0),
    ("-2 * prr(a, b) <= -0.1", "prr(a, b) >= 0.05", 2.0),
    ("0.02 <= prr(a, b) / 5 + 0.01", "prr(a, b) >= 0.05", 0.2),
    ("not (3 * prr(a, b) < 0.15)", "prr(a, b) >= 0.05", 3.0),
    ("0.5 * snr(a, b) >= -10 dB", "snr(a, b) >= -20 dB", 0.5),
    ("1 - 4 * ber(a, b) >= -1.1", "ber(a, b) <= 0.525", 4.0),
    ("4 * max(prr(a, b), 0.01) >= 0.2", "max(prr(a, b), 0.01) >= 0.05", 4.0),
    ("4 * |prr(a, b) - 1| <= 3.8", "|prr(a, b) - 1| <= 0.95", 4.0),
    ("10 * link_cost(radio, (a, b)) <= 1e6", "link_cost(radio, (a, b)) <= 1e5", 10.0),
    ("always[0, 1] (prr(a, b) + prr(a, b) >= 0)", "always[0, 1] prr(a, b) >= 0", 2.0),
]


def _solved(formula: str, objective: str) -> tuple[Plan, Report]:
    outcome = api.solve(api.loads(MISSION.format(formula=formula, objective=objective)))
    return outcome.plan, outcome.report


@pytest.mark.parametrize(("written", "plain", "factor"), SAME)
def test_verified_robustness(written: str, plain: str, factor: float) -> None:
    ahead = [f"eventually[0, 2] ({formula})" for formula in (written, plain)]
    plan, report = _solved(ahead[1], "minimize effort")
    other = verify(api.loads(MISSION.format(formula=ahead[0], objective="minimize effort")), plan)
    mine, theirs = other.requirements[0], report.requirements[0]
    assert theirs.robustness is not None
    assert theirs.true is not None
    assert abs(theirs.robustness) > 1e-9
    assert mine.robustness == pytest.approx(factor * theirs.robustness)
    assert mine.true == pytest.approx(factor * theirs.true)


@pytest.mark.parametrize(("written", "plain", "factor"), SAME[:7:2])
def test_maximised_robustness(written: str, plain: str, factor: float) -> None:
    best, of_plain = (
        _solved(f, "maximize robustness")[0].solve.objective for f in (written, plain)
    )
    assert of_plain is not None
    assert best == pytest.approx(factor * of_plain, rel=1e-4)


def test_minimum_of_scaled_and_plain_ones() -> None:
    formula = "(2 * prr(a, b) >= 0.1) and (a.x >= 0)"
    plan, report = _solved(formula, "minimize effort")
    assert report.requirements[0].robustness is not None
    alone = _solved("2 * prr(a, b) >= 0.1", "minimize effort")[1].requirements[0].robustness
    assert alone is not None
    assert report.requirements[0].robustness == pytest.approx(
        min(alone, plan.runs["a"].states[0, 0])
    )


def test_a_chance_keeps_the_robustness_of_its_level() -> None:
    text = "P({} >= -40 dB) >= 0.9"
    found = [
        api.loads(MISSION.format(formula=text.format(q), objective="minimize effort"))
        for q in ("snr(a, b)", "2 * snr(a, b)")
    ]
    links = [n for m in found for n in walk(m.requirements[0].formula) if isinstance(n, Link)]
    assert [(link.threshold, link.factor) for link in links] == [(-40.0, 1.0), (-20.0, 1.0)]


def test_text_form() -> None:
    text = "link(radio prr(a, b) >= 0.5 @2 times 2.5)"
    node = parse_node(text)
    assert isinstance(node, Link)
    assert (node.factor, node.shift) == (2.5, 2)
    assert print_node(node) == text
