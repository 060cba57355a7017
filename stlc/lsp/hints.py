"""Small remarks within the text: times of intervals, the horizon that follows."""

from __future__ import annotations

from collections.abc import Iterator

from stlc.lsp.document import Document
from stlc.record import Record
from stlc.sema.units import SECOND, UnknownUnitName, parse_unit
from stlc.syntax import ast


def hints(document: Document, start: int = 0, end: int | None = None) -> list[tuple[int, str]]:
    """Offsets among the characters [start, end), and what stands there."""
    mission = document.mission
    if mission is None:
        return []
    end = len(document.text) if end is None else end
    found = [
        (at + interval.span.end, text)
        for at, statement in document.pieces.within(start, end)
        for interval in _intervals(statement)
        if (text := _interval(interval, mission.step))
    ]
    return sorted(hint for hint in (*found, *_horizon(document)) if start <= hint[0] <= end)


def _horizon(document: Document) -> Iterator[tuple[int, str]]:
    """Behind `step`, where the file gives no horizon."""
    mission = document.mission
    assert mission is not None
    placed = list(document.pieces.within(0, len(document.text)))
    if any(isinstance(s, ast.Horizon) for _, s in placed):
        return
    for at, statement in placed:
        if isinstance(statement, ast.Step):
            whole = mission.horizon * mission.step
            yield at + statement.span.end, f" horizon {mission.horizon} steps, {whole:g} s"


def _intervals(node: object) -> Iterator[ast.Interval]:
    if isinstance(node, tuple):
        for item in node:
            yield from _intervals(item)
    elif isinstance(node, ast.Interval):
        yield node
    elif isinstance(node, Record):
        for field in type(node).record_fields:
            yield from _intervals(getattr(node, field))


def _interval(interval: ast.Interval, step: float) -> str:
    """Steps as seconds, or seconds as steps; nothing where ends aren't plain numbers, or both are
    the same."""
    ends = [interval.start, interval.end] if interval.end is not None else [interval.start]
    numbers = [e for e in ends if isinstance(e, ast.Number)]
    if len(numbers) < len(ends) or not any(n.value for n in numbers):
        return ""
    timed = [n.unit is not None for n in numbers if n.value]
    if all(timed):
        steps = [_seconds(n) / step for n in numbers]
        return f" steps {_range(steps, interval)}"
    if any(timed) or step == 1.0:
        return ""
    return f" {_range([n.value * step for n in numbers], interval)} s"


def _seconds(number: ast.Number) -> float:
    if number.unit is None:
        return 0.0
    try:
        unit = parse_unit(number.unit)
    except UnknownUnitName:
        return float("nan")
    return number.value * unit.scale if unit.unit == SECOND else float("nan")


def _range(values: list[float], interval: ast.Interval) -> str:
    low, *high = (f"{round(v, 9):g}" for v in values)
    if interval.end is None:
        return f"{low}.."
    return low if high == [low] else f"{low}..{high[0]}"
