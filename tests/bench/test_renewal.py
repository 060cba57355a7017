"""The benchmark of closed loops: its lines are read back, its figures are those of all worlds."""

from __future__ import annotations

import runpy
from pathlib import Path

BENCHMARK = Path(__file__).parents[2] / "benchmarks" / "renewal.py"


def test_worlds_that_are_there_are_read_back() -> None:
    found = runpy.run_path(str(BENCHMARK))
    row_type, figures = found["Row"], found["figures"]
    rows = [
        row_type("flat", "anew each step, channels learn", seed, 13, late, kept, (0.25, 0.5, 1.5))
        for seed, (late, kept) in enumerate([(0, 1), (2, 1), (1, 0)])
    ]
    assert [row_type.of(row.text()) for row in rows] == rows
    said = figures(rows)
    assert "9 steps, 39 plans, 3 not in time; median 0.50 s" in said
    assert "kept 2 of 3 (9% to 99%)" in said
