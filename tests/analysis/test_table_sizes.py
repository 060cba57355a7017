"""The size of link tables is known before they are built."""

from __future__ import annotations

import pytest
from support.command import inside as stlc

from stlc.analysis.reach import reach
from stlc.analysis.table_sizes import check_tables
from stlc.api import loads
from stlc.errors import MissionError, NoPlanError

PAIR = """
workspace box [0, 10] x [0, 10]
agent r1 : double_integrator { start (1, 1); control |u| <= 1; speed <= 2 }
agent r2 : double_integrator { start (9, 1); control |u| <= 1; speed <= 2 }
station base at (5, 5)
channel radio {
  path_loss L0 = -12.89 dBm, n = 3; fading 10 dB^2, shadowing 10 dB^2, length 2 m
  noise_floor -60 dBm; partition 100 x 100
}
require reach: eventually[0, 6] r1.x >= 4 m
"""
TALK = "require talk: always[2, 4] rssi(r1, r2) >= -50 dBm\n"
BOTH = "require both: always[2, 4] rssi(r2, r1) >= -50 dBm\n"
COST = "minimize link_cost(radio)\n"
STATION = "require talk: always[2, 4] rssi(r1, base) >= -50 dBm\n"


@pytest.mark.parametrize(("asked", "line"), [(TALK, 11), (COST, 11)])
def test_large_tables_are_refused_before_they_are_built(asked, line, tmp_path) -> None:
    (tmp_path / "m.stl").write_text(PAIR + asked, encoding="utf-8")
    for command in ("compile", "solve"):
        done = stlc(command, "m.stl", folder=tmp_path)
        assert done.returncode == 1
        assert "E0807" in done.stderr
        assert f"m.stl:{line}:" in done.stderr
        assert "raise the limit: `--max-size" in done.stderr


def _size(text: str) -> int:
    mission = loads(text)
    with pytest.raises(MissionError) as caught:
        check_tables(mission, reach(mission), 0)
    return caught.value.diagnostics[0].size


def test_each_table_counts_once_and_costs_by_what_is_in_reach() -> None:
    assert _size(PAIR + TALK) == 100**4
    assert _size(PAIR + TALK + BOTH) == 100**4
    assert _size(PAIR + TALK + BOTH.replace("-50", "-40")) == 2 * 100**4
    assert _size(PAIR + STATION) == 100**2
    few = PAIR.replace("100 x 100", "1 x 1")
    assert _size(few + COST) == 1 + 6  # one pair of cells a step
    check_tables(loads(few + COST), reach(loads(few + COST)), 1)


def test_running_out_of_memory_is_a_limit_reached(tmp_path, monkeypatch) -> None:
    def build(*_: object, **__: object) -> None:
        raise MemoryError

    (tmp_path / "m.stl").write_text(PAIR.replace("100 x 100", "2 x 2") + TALK, encoding="utf-8")
    monkeypatch.setattr("stlc.milp.builder.ModelBuilder.build", build)
    done = stlc("compile", "m.stl", folder=tmp_path)
    assert done.returncode == NoPlanError.exit_status
    assert "out of memory" in done.stderr
