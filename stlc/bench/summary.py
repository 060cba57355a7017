"""The report for a terminal."""

from __future__ import annotations

from collections.abc import Sequence

from stlc.bench.about import about, commands
from stlc.bench.compare import Change
from stlc.bench.groups import Group, Table, disagreements, groups_of, tables_of
from stlc.bench.measures import Summary, summaries
from stlc.bench.record import Record


def summary_text(records: Sequence[Record]) -> str:
    """Machine and commands; for each suite its problems by configuration, then the means."""
    groups = groups_of(records)
    used = [run for group in groups for run in group.runs]
    head = "\n".join([*about(used), *commands(used)])
    return "\n\n".join([head, *(_suite(table) for table in tables_of(groups))])


def _suite(table: Table) -> str:
    lines = [
        f"suite {table.suite}: seconds of the solver (* no proof), then rows",
        f"{'':32}" + "".join(f"{label[:22]:>24}" for label in table.labels),
    ]
    for problem, row in table.rows.items():
        cells = "".join(f"{_cell(row.get(label)):>24}" for label in table.labels)
        lines.append(f"{problem[:32]:32}{cells}".rstrip())
    lines += [_line(one) for one in summaries(table)]
    lines += [f"DISAGREEMENT {text}" for text in disagreements(table)]
    return "\n".join(lines)


def _cell(group: Group | None) -> str:
    if group is None:
        return "-"
    rows = group.value("rows")
    mark = " " if group.solved else "*"
    return f"{group.seconds:.2f}{mark} {'-' if rows is None else format(rows, '.0f'):>8}"


def _line(one: Summary) -> str:
    ratio = "" if one.geometric is None else f", {one.geometric:.2f} times the reference"
    return (
        f"  {one.label}: {one.solved} of {one.problems} solved, mean {one.mean:.2f} s{ratio} "
        f"(geometric mean{'' if one.worst is None else f'; greatest {one.worst:.2f}'})"
    )


def changes_text(name: str, changes: Sequence[Change]) -> str:
    """One line a change, or that there is none."""
    if not changes:
        return f"\nnothing changed against {name} beyond the noise of the runs"
    lines = [f"  {c.kind:12} {c.suite}/{c.problem}, {c.label}: {c.text}" for c in changes]
    return "\n".join([f"\nagainst {name}:", *lines])
