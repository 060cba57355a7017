"""`--against`: only what lies beyond the noise is named."""

from __future__ import annotations

from support.tiny import record

from stlc.bench.compare import changes, noise
from stlc.bench.groups import groups_of
from stlc.bench.record import Record


def _kinds(now: list[Record], before: list[Record]) -> list[str]:
    return [c.kind for c in changes(groups_of(now), groups_of(before))]


def _times(*seconds: float) -> list[Record]:
    return [record("p", "auto", s, k) for k, s in enumerate(seconds)]


def test_noise_is_that_of_the_repeats() -> None:
    assert noise(groups_of(_times(4.0, 5.0, 6.0))[0]) == 0.2
    assert noise(groups_of(_times(5.0))[0]) == 0.25
    assert noise(groups_of(_times(5.0, 5.0))[0]) == 0.1


def test_slower_within_the_noise_is_nothing() -> None:
    assert _kinds(_times(5.6, 5.8, 6.0), _times(4.0, 5.0, 6.0)) == []
    assert _kinds(_times(0.15), _times(0.08)) == []  # too short to tell


def test_slower_and_faster_beyond_it() -> None:
    assert _kinds(_times(8.0, 8.1, 8.2), _times(4.0, 5.0, 6.0)) == ["regression"]
    assert _kinds(_times(1.0, 1.1, 1.2), _times(4.0, 5.0, 6.0)) == ["improvement"]


def test_lost_proofs_other_optima_larger_models() -> None:
    now = [record("p", "auto", None), record("q", "auto", 1.0, objective=2.0),
           record("r", "auto", 1.0, rows=20), record("new", "auto", 1.0)]  # fmt: skip
    before = [record(name, "auto", 1.0) for name in "pqr"]
    assert _kinds(now, before) == ["disagreement", "regression", "larger"]


def test_another_text_is_another_problem() -> None:
    assert _kinds([record("p", "auto", 9.0, digest="other")], _times(1.0)) == []
