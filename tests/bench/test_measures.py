"""Means, profiles, cactus plots and growth exponents, against values known by hand."""

from __future__ import annotations

import json
from dataclasses import replace

import pytest
from support.tiny import record

from stlc.bench.families import families_of, spread_text
from stlc.bench.groups import BEST_PEER, disagreements, groups_of, seconds_of, tables_of
from stlc.bench.growth import growth, growths
from stlc.bench.measures import (
    cactus,
    performance_profile,
    shifted_geometric_mean,
    summaries,
)


def test_shifted_geometric_mean() -> None:
    assert shifted_geometric_mean([3.0, 3.0]) == pytest.approx(3.0)
    assert shifted_geometric_mean([0.0, 3.0]) == pytest.approx(1.0)  # sqrt(1 * 4) - 1
    with pytest.raises(ValueError, match="value"):
        shifted_geometric_mean([])


def test_growth_finds_the_exponent() -> None:
    fitted = growth("auto", [(x, 3.0 * x**1.5) for x in (1, 2, 4, 8)])
    assert fitted.exponent == pytest.approx(1.5)
    assert fitted.factor == pytest.approx(3.0)
    assert fitted.quality == pytest.approx(1.0)
    assert growth("auto", [(1, 1), (2, 2)]).exponent is None
    assert growth("auto", [(1, 1), (2, 0), (3, 3)]).exponent is None  # 0 has no logarithm
    scattered = growth("auto", [(1, 3), (2, 1), (4, 2), (8, 3)])
    assert scattered.exponent is None  # no trend
    assert scattered.quality < 0.5


def test_ratios_medians_and_limits() -> None:
    runs = [record("p", "auto", s, k) for k, s in enumerate((1.0, 2.0, 9.0))]
    runs += [record("p", "literal", None), record("q", "auto", 1.0), record("q", "literal", 4.0)]
    (table,) = tables_of(groups_of(runs))
    ours, literal = summaries(table)
    assert (ours.label, ours.solved, literal.solved, literal.plans) == ("auto", 2, 1, 1)
    assert table.rows["p"]["auto"].seconds == 2.0  # the median
    assert table.rows["p"]["literal"].seconds == 10.0  # the limit
    assert literal.geometric == pytest.approx((5.0 * 4.0) ** 0.5)
    assert literal.greatest == pytest.approx(5.0)


def test_two_time_limits_say_nothing() -> None:
    runs = [record("p", "auto", None), record("p", "log", None)]
    runs += [record("q", "auto", 1.0), record("q", "log", 3.0)]
    (table,) = tables_of(groups_of(runs))
    log = summaries(table)[1]
    assert (log.problems, log.solved, log.geometric) == (2, 1, pytest.approx(3.0))


def test_profile_and_cactus() -> None:
    runs = [record("p", "auto", 1.0), record("p", "log", 2.0)]
    runs += [record("q", "auto", None), record("q", "log", 3.0)]
    (table,) = tables_of(groups_of(runs))
    profile = performance_profile(table)
    assert profile["auto"] == ([1.0], [0.5])
    assert profile["log"] == ([1.0, 2.0], [0.5, 1.0])
    assert cactus(table)["log"] == ([1.0, 2.0], [2.0, 3.0])


def test_the_better_peer_counts() -> None:
    runs = [record("p", "auto", 1.0), record("p", "peer a", None), record("p", "peer b", 6.0)]
    (table,) = tables_of(groups_of(runs))
    assert table.labels == ("auto", BEST_PEER, "peer a", "peer b")
    assert {s.label: s.geometric for s in summaries(table)}[BEST_PEER] == pytest.approx(6.0)
    assert BEST_PEER not in performance_profile(table)


def test_proven_optima_that_differ_are_named() -> None:
    runs = [record("p", "auto", 1.0), record("p", "log", 1.0, objective=1.1)]
    assert len(disagreements(tables_of(groups_of(runs))[0])) == 1
    runs[1] = record("p", "log", 1.0, objective=1.0001)  # within both gaps
    assert disagreements(tables_of(groups_of(runs))[0]) == []


def test_only_the_latest_version_counts() -> None:
    old = record("p", "auto", 1.0, code="old", finished="2025-01-01T00:00:00+00:00")
    groups = groups_of([record("p", "auto", 5.0), old])
    assert [g.seconds for g in groups] == [5.0]


def test_processor_time_is_compared_where_there_is_one_thread() -> None:
    run = record("p", "auto", 4.0, cpu_seconds=3.0)
    assert seconds_of(run) == 3.0
    assert seconds_of(replace(run, threads=2)) == 4.0
    stopped = record("p", "auto", None, cpu_seconds=8.0)  # of 10 s, on a busy machine
    assert seconds_of(stopped) == 8.0
    assert seconds_of(replace(stopped, status="failed")) == 10.0


def test_ratios_say_which_way_they_are_bounds() -> None:
    runs = [record("p", "auto", 1.0), record("p", "log", None), record("p", "hull", 2.0)]
    assert [s.mark for s in summaries(tables_of(groups_of(runs))[0])] == ["", "≥ ", ""]
    runs += [record("q", "auto", None), record("q", "log", 1.0), record("q", "hull", 2.0)]
    assert [s.mark for s in summaries(tables_of(groups_of(runs))[0])] == ["", "~ ", "≤ "]


def test_median_and_worst_of_a_family() -> None:
    values = ((1.0, 2.0), (3.0, 4.0), (None, None))
    runs = [
        record(f"p{k}", "auto", proof, family="ten", first_plan=first, gap_60=0.1 * k)
        for k, (first, proof) in enumerate(values)
    ]
    (family,) = families_of(tables_of(groups_of(runs))[0])
    assert (family.problems, family.plans, family.proofs) == (3, 2, 2)
    assert spread_text(family.first, 10.0) == "3.0 / > 10"
    assert spread_text(family.cpu, 10.0) == "4.0 / > 10"
    assert spread_text(family.gap, None) == "10.0% / 20.0%"


def test_growth_leaves_out_what_reached_its_limit() -> None:
    runs = [
        record(f"p{x}", "auto", None if x == 8 else 0.1 * x, axes=json.dumps({"walk steps": x}))
        for x in (1, 2, 4, 8)
    ]
    curves = dict(growths(tables_of(groups_of(runs))[0]))
    (times,) = curves["walk over steps: time of the solver to the proof [s]"]
    assert (times.exponent, times.missing) == (pytest.approx(1.0), 1)
    (rows,) = curves["walk over steps: rows"]
    assert rows.missing == 1  # unsolved runs of these records have none
