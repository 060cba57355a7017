"""What the importers write, for each construct of each dialect."""

from __future__ import annotations

from fractions import Fraction

import pytest

from stlc.api import loads
from stlc.dialects import import_text
from stlc.source import Source


def body(text: str, dialect: str, step: str | None = None) -> list[str]:
    """The imported statements without the head, comments and empty lines; they must check."""
    given = None if step is None else Fraction(step)
    whole = import_text(Source("spec.stl", text), dialect, given).text
    assert loads(whole) is not None
    lines = [line.split("  #")[0] for line in whole.splitlines()]
    return [line for line in lines if line and not line.startswith("#")]


CASES = [
    (
        "breach",
        "param tau = 2, c=1.5\nsignal x, y\nnear := abs(x[t]-y[t]) < c\nphi := alw_[0, tau] near",
        ["step 1 s", "param tau = 2 s", "param c = 1.5", "signal x", "signal y",
         "let near = abs(x - y) < c", "require phi: always[0 s, tau] near"],
    ),
    (
        "breach",
        "param dt=.5\nup := (x[t+dt]-x[t])/dt > 1",
        ["step 0.5 s", "param dt = 0.5", "signal x",
         "require up: (ahead(x, dt * 1 s) - x) / dt > 1"],
    ),
    (
        "breach",
        "up := x[t+0.2] > x[t] and ev x[t] > 3",
        ["step 0.2 s", "signal x",
         "require up: ahead(x, 0.2 s) > x and (eventually (x > 3))"],
    ),
    (
        "breach",
        "a := x[t] > 1 or y[t] > 2 => z[t] > 3 and x[t] > 4",
        ["step 1 s", "signal x", "signal y", "signal z",
         "require a: x > 1 or (y > 2 implies (z > 3 and x > 4))"],
    ),
    (
        "breach",
        "a := alw (\n  x[t] > 1 => \n ev_[0, inf] (x[t] < 0))  # a comment\n",
        ["step 1 s", "signal x",
         "require a: always (x > 1 implies (eventually[0 s, inf] (x < 0)))"],
    ),
    (
        "breach",
        "a := alw_[lo, hi-2*d] not (b)",
        ["step 1 s", "param lo = 0 s", "param hi = 0 s", "param d = 0 s", "signal b",
         "require a: always[lo, hi - 2 * d] (not (b >= 0))"],
    ),
    (
        "breach",
        "a := gear[t] == 3",
        ["step 1 s", "param equal_within = 2e-6", "signal gear",
         "require a: abs(gear - 3) <= equal_within"],
    ),
    (
        "breach",
        "a := alw [] (x[t]>1)",
        ["step 1 s", "signal x", "require a: always (always (x > 1))"],
    ),
    (
        "breach",
        "param T=4, dt=0.5\na := alw_[0, T-2*dt] x[t] > dt\n"
        "param T=6\nb := ev_[T, T*dt*4] x[t] > 0",
        ["step 1 s", "param T = 4 s", "param dt = 0.5", "param T_2 = 6", "signal x",
         "require a: always[0 s, T - 2 * dt * 1 s] (x > dt)",
         "require b: eventually[T_2 * 1 s, T_2 * dt * 4 * 1 s] (x > 0)"],
    ),
    (
        "rtamt",
        "float x; float y; y = x + 1; y > 2",
        ["step 1 s", "signal x", "let y = x + 1", "require: y > 2"],
    ),
    (
        "breach",
        "p := x[t] > 1\np := x[t] > 2 and p\nq := ev p",
        ["step 1 s", "signal x", "let p = x > 1", "let p_2 = x > 2 and p",
         "require q: eventually p_2"],
    ),
    (
        "falcaun",
        "[] signal(0) < 3 -> <>_[0,2] (input(1) > 1)",
        ["step 1 s", "signal signal0", "signal input1",
         "require: always (signal0 < 3 implies (eventually[0, 2] (input1 > 1)))"],
    ),
    (
        "falcaun",
        "alw_[0, 2] $speed < $limit\nX (output(0) > -1.5)",
        ["step 1 s", "param limit = 0", "signal speed", "signal signal0",
         "require: always[0, 2] (speed < limit)", "require: next (signal0 > -1.5)"],
    ),
    (
        "falcaun",
        "(signal(0) > 1) U (signal(1) > 2)",
        ["step 1 s", "signal signal0", "signal signal1",
         "require: ((signal0 > 1) or (signal1 > 2)) until (signal1 > 2)"],
    ),
    (
        "falcaun",
        "(signal(0) > 1) R_[2,4] (signal(1) > 2)",
        ["step 1 s", "signal signal0", "signal signal1",
         "require: (signal0 > 1) release[1, 3] (next (signal1 > 2))"],
    ),
    (
        "rtamt",
        "specification s\nfloat req; input float gnt\nconst float c = 5\n"
        "slow = req <= c;\nout = slow -> eventually[0:c ms] gnt",
        ["step 0.005 s", "param c = 5", "signal req", "signal gnt", "let slow = req <= c",
         "require out: slow implies (eventually[0 ms, c * 1 ms] (gnt >= 0))"],
    ),
    (
        "rtamt",
        "kmh = v * 3.6; always[0, 2] (kmh <= 50)",
        ["step 1 s", "signal v", "let kmh = v * 3.6", "require: always[0 s, 2 s] (kmh <= 50)"],
    ),
    (
        "rtamt",
        "near = d <= 2; near >= 0.5",
        ["step 1 s", "signal d", "let near = d <= 2", "require: 2 - d >= 0.5"],
    ),
    (
        "rtamt",
        "from m.msg import Msg\ninput Msg req\n@ topic(req, m/req)\nout.value = F req.value >= 3",
        ["step 1 s", "signal req_value", "require out_value: eventually (req_value >= 3)"],
    ),
    (
        "breach",
        "param a=1\np := x[t] > a\nparam a=1, b=2\nq := ev p and x[t] < a",
        ["step 1 s", "param a = 1", "param b = 2", "signal x", "let p = x > a",
         "require q: (eventually p) and x < a"],
    ),
    (
        "rtamt",
        "pose.x >= goal/x",
        ["step 1 s", "signal pose_x", "signal goal_x", "require: pose_x >= goal_x"],
    ),
]  # fmt: skip


@pytest.mark.parametrize(("dialect", "text", "expected"), CASES)
def test_constructs(dialect: str, text: str, expected: list[str]) -> None:
    assert body(text, dialect) == expected


def test_a_name_of_the_language_gets_another_one() -> None:
    assert body("always := in[t] > 1", "breach")[1:] == ["signal in_", "require always_: in_ > 1"]


def test_step_is_as_asked_for() -> None:
    text = "a := ev_[0, 1] x[t] > 2"
    assert body(text, "breach", "1/4")[0] == "step 0.25 s"
    assert body(text, "breach")[0] == "step 1 s"
    assert body("[] signal(0) > 1", "falcaun", "0.1")[0] == "step 0.1 s"


def test_the_end_of_an_interval_without_a_value_comes_after_its_start() -> None:
    found = body("a := alw_[2, T] x[t] > c", "breach")
    assert "param T = 10 s" in found
    assert "require a: always[2 s, T] (x > c)" in found


def test_parameters_without_a_value_are_told() -> None:
    imported = import_text(Source("spec", "a := x[t] > k * c"), "breach")
    assert [w.code for w in imported.warnings] == ["W0901", "W0901"]
    assert "param k = 1  # the file gives no value" in imported.text


def test_odd_grouping_of_rtamt_is_told() -> None:
    imported = import_text(Source("spec", "a - b + c >= 0; a - (b + c) >= 0"), "rtamt")
    assert [w.code for w in imported.warnings] == ["W0903"]
    assert imported.text.count("a - (b + c) >= 0") == 2


def test_loose_unary_operators_of_falcaun_are_told() -> None:
    imported = import_text(Source("spec", "alw (signal(0) < 1) -> X (signal(1) < 2)"), "falcaun")
    assert [w.title_text for w in imported.warnings] == [
        "FalCAuN reads `alw (signal(0) < 1) -> X (signal(1) < 2)` as "
        "`alw ((signal(0) < 1) -> X (signal(1) < 2))`"
    ]
    assert "always (signal0 < 1 implies (next (signal1 < 2)))" in imported.text
    quiet = import_text(Source("spec", "alw ((signal(0) < 1) -> X (signal(1) < 2))"), "falcaun")
    assert quiet.warnings == ()
