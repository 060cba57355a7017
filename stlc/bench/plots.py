"""Which plots a suite gets."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from stlc.bench.drawing import Styles, cactus_svg, finite_gaps, gap_svg, growth_svg, profile_svg
from stlc.bench.groups import Group, Table
from stlc.bench.measures import (
    Curve,
    Growth,
    cactus,
    families,
    growth,
    own_labels,
    performance_profile,
)
from stlc.plot.style import looks

_QUANTITIES = (
    ("seconds", "solver time [s]"),
    ("rows", "rows"),
    ("compile_seconds", "compile time [s]"),
)
_GAPS = 4  # at most, so many problems' gaps over time are drawn: the longest


def plots(table: Table) -> Iterator[tuple[str, str]]:
    """(title, SVG)."""
    styles = looks(own_labels(table))
    curves = cactus(table)
    if len(table.rows) > 1 and any(xs for xs, _ in curves.values()):
        limit = max(g.first.time_limit for row in table.rows.values() for g in row.values())
        if len(curves) > 1:
            yield "Performance profile", profile_svg(performance_profile(table), styles)
        yield "Cactus plot", cactus_svg(curves, styles, limit)
    for axis, groups in families(table).items():
        yield from _growth_plots(axis, groups, styles)
    for problem in _longest(table):
        shown = _gaps(table, problem)
        if shown:
            yield f"Gap over time: {problem}", gap_svg(shown, styles)


def _growth_plots(axis: str, groups: Sequence[Group], styles: Styles) -> Iterator[tuple[str, str]]:
    generator, _, size = axis.rpartition(" ")
    for name, title in _QUANTITIES:
        curves = [c for c in _curves(groups, name) if len(set(c.sizes)) > 2]
        if curves:
            yield f"{generator} over {size}: {title}", growth_svg(curves, styles, size, title)


def _curves(groups: Sequence[Group], name: str) -> list[Growth]:
    """One curve a configuration. Times count only where there was a proof: a time limit has no
    exponent."""
    found = []
    for label in dict.fromkeys(group.first.label for group in groups):
        members = [g for g in groups if g.first.label == label]
        if name == "seconds":
            points = [(g.first.size, g.seconds) for g in members if g.solved]
        else:
            points = [(g.first.size, v) for g in members if (v := g.value(name)) is not None]
        found.append(growth(label, points))
    return found


def _longest(table: Table) -> list[str]:
    def seconds(problem: str) -> float:
        return max(group.seconds for group in table.rows[problem].values())

    return sorted(table.rows, key=seconds, reverse=True)[:_GAPS]


def _gaps(table: Table, problem: str) -> dict[str, Curve]:
    row = table.rows[problem]
    curves = {label: finite_gaps(row[label].first.trace) for label in own_labels(table)
              if label in row}  # fmt: skip
    return {label: (xs, ys) for label, (xs, ys) in curves.items() if len(xs) > 1}
