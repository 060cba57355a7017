"""Which plots a suite gets."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import islice

from stlc.bench.drawing import cactus_svg, finite_gaps, gap_svg, growth_svg, profile_svg
from stlc.bench.groups import Table
from stlc.bench.growth import growths
from stlc.bench.measures import Curve, cactus, own_labels, performance_profile
from stlc.plot.style import looks

_GAPS = 4  # at most, so many problems' gaps over time are drawn: the longest


def plots(table: Table) -> Iterator[tuple[str, str]]:
    """(title, SVG)."""
    styles = looks(own_labels(table))
    curves = cactus(table)
    if len(table.rows) > 1 and any(len(xs) > 1 for xs, _ in curves.values()):
        limit = max(g.first.time_limit for row in table.rows.values() for g in row.values())
        if len(curves) > 1:
            yield "Performance profile", profile_svg(performance_profile(table), styles)
        yield "Cactus plot", cactus_svg(curves, styles, limit)
    for title, grown in growths(table):
        axis, _, quantity = title.partition(": ")
        yield title, growth_svg(grown, styles, axis.rpartition(" over ")[2], quantity)
    told = ((problem, _gaps(table, problem)) for problem in _longest_first(table))
    for problem, shown in islice(((p, gaps) for p, gaps in told if gaps), _GAPS):
        yield f"Gap over time: {problem}", gap_svg(shown, styles)


def _longest_first(table: Table) -> list[str]:
    def seconds(problem: str) -> float:
        return max(group.seconds for group in table.rows[problem].values())

    return sorted(table.rows, key=seconds, reverse=True)


def _gaps(table: Table, problem: str) -> dict[str, Curve]:
    row = table.rows[problem]
    curves = {label: finite_gaps(row[label].first.trace) for label in own_labels(table)
              if label in row}  # fmt: skip
    return {label: (xs, ys) for label, (xs, ys) in curves.items() if len(xs) > 1}
