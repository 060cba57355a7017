"""Imported formulas mean what they meant: against each dialect's definition, and against rtamt."""

from __future__ import annotations

import random
import sys
from collections.abc import Mapping, Sequence
from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from support.dialects import (
    BREACH,
    FALCAUN,
    NAMES,
    RTAMT,
    Formula,
    Style,
    formulas,
    holds,
    horizon,
    robustness,
    write,
)

from stlc.api import loads
from stlc.dialects import import_text
from stlc.monitor import Monitored, monitor_formulas
from stlc.recording import Recording
from stlc.source import Source

STYLES = {"breach": BREACH, "falcaun": FALCAUN, "rtamt": RTAMT}


def judge(
    text: str,
    dialect: str,
    signals: Mapping[str, Sequence[float]],
    step: Fraction | None = None,
) -> list[Monitored]:
    """Import a text and monitor it; FalCAuN's signals are numbered in the order of NAMES."""
    mission = loads(import_text(Source("spec", text), dialect, step).text)
    renamed = {f"signal{NAMES.index(k)}": v for k, v in signals.items() if k in NAMES}
    columns = {k: np.asarray(v, float) for k, v in {**signals, **renamed}.items()}
    length = len(next(iter(columns.values())))
    recording = Recording("trace", np.arange(length) * mission.step, columns)
    return list(monitor_formulas(mission.requirements, recording, mission).formulas)


def trace(formula: Formula, seed: int, *, discrete: bool = False) -> dict[str, list[float]]:
    """Signals long enough to judge the formula at a few steps."""
    draw, length = random.Random(seed), horizon(formula) + 4
    if discrete:
        return {n: [float(draw.randint(0, 3)) for _ in range(length)] for n in NAMES}
    return {n: [draw.uniform(-4, 4) for _ in range(length)] for n in NAMES}


@pytest.mark.parametrize("dialect", STYLES)
@given(data=st.data(), seed=st.integers(0, 10**6))
def test_robustness_is_that_of_the_definition(dialect: str, data: st.DataObject, seed: int) -> None:
    style: Style = STYLES[dialect]
    formula = data.draw(formulas(style))
    signals = trace(formula, seed)
    (found,) = judge(write(formula, style), dialect, signals, Fraction(style.step))
    expected = [robustness(formula, signals, t, style.open_until) for t in range(4)]
    assert len(found.robustness) >= 4
    assert found.robustness[:4] == pytest.approx(expected, abs=1e-9)


@pytest.mark.parametrize("dialect", ["breach", "falcaun"])
@given(data=st.data(), seed=st.integers(0, 10**6))
def test_equality_of_discrete_signals_is_exact(
    dialect: str, data: st.DataObject, seed: int
) -> None:
    style: Style = STYLES[dialect]
    formula = data.draw(formulas(style, discrete=True))
    signals = trace(formula, seed, discrete=True)
    (found,) = judge(write(formula, style), dialect, signals, Fraction(style.step))
    expected = [holds(formula, signals, t, style.open_until) for t in range(4)]
    assert found.satisfied[:4].tolist() == expected
    values = [robustness(formula, signals, t, style.open_until) for t in range(4)]
    assert found.robustness[:4] == pytest.approx(values, abs=3e-6)


# rtamt 0.4 imports modules that Python 3.13 dropped; with earlier ones it must be there.
meets_rtamt = pytest.mark.skipif(sys.version_info >= (3, 13), reason="rtamt needs Python < 3.13")


def rtamt_robustness(text: str, signals: Mapping[str, Sequence[float]], step: float) -> list[float]:
    import rtamt

    specification = rtamt.StlDiscreteTimeSpecification()
    for name in signals:
        specification.declare_var(name, "float")
    specification.spec = text
    specification.set_sampling_period(round(step * 1000), "ms", 0.1)
    specification.parse()
    length = len(next(iter(signals.values())))
    rows = specification.evaluate({**signals, "time": [k * step for k in range(length)]})
    return [value for _, value in rows]


@meets_rtamt
@given(formula=formulas(RTAMT), seed=st.integers(0, 10**6))
def test_random_formulas_agree_with_rtamt(formula: Formula, seed: int) -> None:
    signals, text = trace(formula, seed), write(formula, RTAMT)
    (found,) = judge(text, "rtamt", signals)
    expected = rtamt_robustness(text, signals, 1.0)
    assert found.robustness[:4] == pytest.approx(expected[:4], abs=1e-9)


WRITTEN = [
    "always (p until q)",
    "eventually (p until (q >= 1))",
    "not (p until q)",
    "p - q + r",
    "p - q - r",
    "p / 2 * 4",
    "p / 2 / 4",
    "p - q + r - p",
    "(p until[0,3] q) or r",
    "p until[2,5] (q >= 1)",
    "p unless[1,3] q",
    "p until q until r",
    "always p and q",
    "always[0,2] p or eventually[1,3] q",
    "p -> q -> r",
    "not p >= q and r",
    "p xor q",
    "(p >= 1) iff (q <= 2)",
    "next p + q",
    "(next p) + q >= 2",
    "p >= not q",
    "abs(p - 2*q) <= 3 implies next (r == 0)",
    "p and q or r and not p",
    "not (p until[0,0] q)",
    "(p >= 2) + (q <= 3) > 0",
    "(p and q) - (p -> r) <= 0",
    "out = (p > 2) -> eventually[100ms:300ms](q < 1.5)",
    "eventually[0:0.5s] p",
    "historic = p !== 2",
]


@meets_rtamt
@pytest.mark.parametrize("text", WRITTEN)
@pytest.mark.parametrize("whole", [False, True])
def test_written_formulas_agree_with_rtamt(text: str, whole: bool) -> None:
    draw = random.Random(len(text))
    numbers = [lambda: float(draw.randint(-3, 5)), lambda: draw.uniform(-4, 5)]
    signals = {n: [numbers[not whole]() for _ in range(30)] for n in NAMES}
    imported = loads(import_text(Source("spec", text), "rtamt").text)
    used = {n: signals[n] for n in imported.signals}
    (found,) = judge(text, "rtamt", used)
    expected = rtamt_robustness(text, used, imported.step)
    assert len(found.robustness) >= 20
    assert found.robustness == pytest.approx(expected[: len(found.robustness)], abs=1e-9)


def test_unbounded_until_is_judged_up_to_the_last_sample() -> None:
    text = "[] ((signal(0) > 2) || ((signal(0) < 2) U (signal(1) > 0)))"
    signals = {"p": [3.0, 1.0, 1.0, 3.0], "q": [-1.0, -1.0, 1.0, -1.0], "r": [0.0] * 4}
    (found,) = judge(text, "falcaun", signals)
    assert found.satisfied.tolist() == [True] * 4
    signals["p"][3] = 1.0
    (found,) = judge(text, "falcaun", signals)
    assert found.satisfied.tolist() == [False] * 4
