"""A sweep as rows: for people, as CSV, as JSON."""

from __future__ import annotations

import csv
import io
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from stlc.sweep.axes import Point
from stlc.sweep.frontier import Frontier
from stlc.sweep.work import Found

Cell = str | float | None


@dataclass(frozen=True, slots=True)
class Table:
    """Columns and rows; a row has one cell for each column, None for what isn't known."""

    columns: tuple[str, ...]
    rows: tuple[tuple[Cell, ...], ...]

    def text(self) -> str:
        """Aligned columns."""
        shown = [self.columns, *([_shown(cell) for cell in row] for row in self.rows)]
        widths = [max(len(row[k]) for row in shown) for k in range(len(self.columns))]
        lines = ("  ".join(c.rjust(w) for c, w in zip(r, widths, strict=True)) for r in shown)
        return "\n".join(line.rstrip() for line in lines)

    def csv(self) -> str:
        """With every digit; what isn't known is empty."""
        out = io.StringIO()
        writer = csv.writer(out, lineterminator="\n")
        writer.writerow(self.columns)
        writer.writerows(["" if cell is None else cell for cell in row] for row in self.rows)
        return out.getvalue()

    def as_dicts(self) -> list[dict[str, Any]]:
        """One object a row."""
        return [dict(zip(self.columns, row, strict=True)) for row in self.rows]


def grid_table(names: Sequence[str], found: Sequence[tuple[Point, Found]]) -> Table:
    """One row for each point of the grid."""
    columns = (*names, "status", "objective", "bound", "seconds", "given_up")
    rows = []
    for point, answer in found:
        if isinstance(answer, Frontier):
            continue
        lost = ", ".join(answer.given_up)
        said = (answer.status, answer.objective, answer.bound, round(answer.seconds, 3), lost)
        rows.append((*(value for _, value in point), *said))
    return Table(columns, tuple(rows))


def trade_table(
    names: Sequence[str], costs: tuple[str, str], found: Sequence[tuple[Point, Found]]
) -> Table:
    """One row for each plan on a curve: both costs, the level the second was held at, and the bound
    on the first there; a curve that isn't there is one row that says why."""
    columns = (*names, *costs, "held_at", "bound", "status")
    rows: list[tuple[Cell, ...]] = []
    for point, curve in found:
        if not isinstance(curve, Frontier):
            continue
        head = tuple(value for _, value in point)
        for t in curve.trades:
            status = "optimal" if t.proven else "feasible"
            rows.append((*head, t.first, t.second, t.level, t.bound, status))
        if curve.why is not None:
            rows.append((*head, None, None, None, None, curve.why.status))
    return Table(columns, tuple(rows))


def _shown(cell: Cell) -> str:
    if cell is None:
        return "-"
    if isinstance(cell, str):
        return cell
    return f"{0.0 if abs(cell) < 1e-9 else cell:.6g}"
