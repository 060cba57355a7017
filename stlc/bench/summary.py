"""The report for a terminal."""

from __future__ import annotations

from collections.abc import Sequence

from stlc.bench.about import about, commands
from stlc.bench.compare import Change
from stlc.bench.families import Family, families_of, gap_title, spread_text
from stlc.bench.groups import Group, Table, disagreements, groups_of, tables_of
from stlc.bench.growth import Growth, growths
from stlc.bench.measures import Summary, summaries
from stlc.bench.record import Record


def summary_text(records: Sequence[Record]) -> str:
    """Machine and commands; for each suite its problems by configuration, then the means."""
    groups = groups_of(records)
    used = [run for group in groups for run in group.runs]
    head = "\n".join([*about(used), *commands(used)])
    return "\n\n".join([head, *(_suite(table) for table in tables_of(groups))])


def _suite(table: Table) -> str:
    """One suite as text: problems by configurations, summaries, families, growth, disagreements."""
    lines = [
        f"suite {table.suite}: seconds of the solver (* no proof), then rows",
        f"{'':32}" + "".join(f"{label[:22]:>24}" for label in table.labels),
    ]
    for problem, row in table.rows.items():
        cells = "".join(f"{_cell(row.get(label)):>24}" for label in table.labels)
        lines.append(f"{problem[:32]:32}{cells}".rstrip())
    lines += [_line(one) for one in summaries(table)]
    lines += _families(families_of(table))
    lines += _growth(table)
    lines += [f"DISAGREEMENT {text}" for text in disagreements(table)]
    return "\n".join(lines)


def _cell(group: Group | None) -> str:
    if group is None:
        return "-"
    rows = group.value("rows")
    mark = " " if group.solved else "*"
    return f"{group.seconds:.2f}{mark} {'-' if rows is None else format(rows, '.0f'):>8}"


def _line(one: Summary) -> str:
    head = f"  {one.label}: {one.solved} of {one.problems} solved, mean {one.mean:.2f} s"
    if one.geometric is None:
        return head
    return (
        f"{head}, {one.mark}{one.geometric:.2f} times the reference "
        f"(geometric mean; {one.least:.2f} to {one.greatest_mark}{one.greatest:.2f})"
    )


def _families(families: Sequence[Family]) -> list[str]:
    if not families:
        return []
    gap = gap_title(family.limit for family in families)
    head = (
        f"{'median / worst of each family':32}{'first plan [s]':>20}{gap:>20}"
        f"{'proof [s]':>20}{'processor [s]':>20}{'proven':>10}"
    )
    return ["", head, *(_family(family) for family in families)]


def _family(family: Family) -> str:
    """One line: first plan, gap, proof, solver's time (median / worst), and proofs."""
    name = family.name if family.label == "auto" else f"{family.name} ({family.label})"
    cells = [
        spread_text(spread, family.limit) for spread in (family.first, family.proof, family.cpu)
    ]
    cells.insert(1, spread_text(family.gap, None))
    return (
        f"{name[:32]:32}"
        + "".join(f"{c:>20}" for c in cells)
        + (f"{f'{family.proofs} of {family.problems}':>10}")
    )


def _growth(table: Table) -> list[str]:
    """Fitted exponents of each axis."""
    found = []
    for title, curves in growths(table):
        fitted = [_exponent(curve) for curve in curves if curve.exponent is not None]
        if fitted:
            found.append(f"  {title}: {', '.join(fitted)}")
    return ["", "growth, fitted exponents", *found] if found else []


def _exponent(curve: Growth) -> str:
    missing = f" ({curve.missing} without)" if curve.missing else ""
    return f"{curve.label} {curve.exponent:.2f}{missing}"


def changes_text(name: str, changes: Sequence[Change]) -> str:
    """One line a change, or that there is none."""
    if not changes:
        return f"\nnothing changed against {name} beyond the noise of the runs"
    lines = [f"  {c.kind:12} {c.suite}/{c.problem}, {c.label}: {c.text}" for c in changes]
    return "\n".join([f"\nagainst {name}:", *lines])
