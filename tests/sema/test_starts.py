"""Where agents may start."""

from __future__ import annotations

import pytest

from stlc.api import loads
from stlc.errors import MissionError

WORLD = """
horizon 6
workspace box [0, 10] x [0, 10]
agent c : double_integrator {{ start (1, 5, {rate}); control |u| <= 1; speed <= 2.05{more} }}
require q: always c.y >= 1
"""


@pytest.mark.parametrize(
    ("rate", "more"), [("3, 0", ""), ("1.6, 1.6", " polygon 8"), ("3, 0", " outer")]
)
def test_a_start_above_the_speed_is_refused(rate: str, more: str) -> None:
    with pytest.raises(MissionError) as found:
        loads(WORLD.format(rate=rate, more=more))
    assert [d.code for d in found.value.diagnostics] == ["E0405"]


def test_a_start_within_the_true_speed_is_taken_whatever_the_polygon() -> None:
    loads(WORLD.format(rate="2.04, 0", more=""))
