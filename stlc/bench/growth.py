"""How figures grow with a size: fitted powers."""

from __future__ import annotations

import json
import math
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass

from stlc.bench.groups import Group, Table
from stlc.bench.measures import own_labels

_QUANTITIES = (
    ("first_plan", "time to the first plan [s]"),
    ("seconds", "time of the solver to the proof [s]"),
    ("rows", "rows"),
    ("compile_seconds", "compile time [s]"),
)

_TREND = 0.5  # R^2


@dataclass(frozen=True, slots=True)
class Growth:
    """value ~ factor * size ** exponent, least squares over logarithms.

    None without three sizes, or where the fit explains less than half of how the values differ;
    `quality` is R^2 (1 for a perfect fit). `missing` problems have no
    value: they reached their time limit, so that the true exponent is greater.
    """

    label: str
    sizes: tuple[float, ...]
    values: tuple[float, ...]
    exponent: float | None
    factor: float
    quality: float
    missing: int = 0


def growth(label: str, points: Iterable[tuple[float, float]], missing: int = 0) -> Growth:
    """Fit positive points."""
    pairs = sorted((x, y) for x, y in points if x > 0 and y > 0)
    sizes, values = tuple(x for x, _ in pairs), tuple(y for _, y in pairs)
    if len(set(sizes)) < 3:
        return Growth(label, sizes, values, None, 0.0, 0.0, missing)
    import numpy as np

    x, y = np.log(sizes), np.log(values)
    exponent, offset = (float(v) for v in np.polyfit(x, y, 1))
    left = float(np.sum((y - exponent * x - offset) ** 2))
    total = float(np.sum((y - y.mean()) ** 2))
    quality = 1.0 - left / total if total > 0 else 1.0
    fitted = exponent if quality >= _TREND else None
    return Growth(label, sizes, values, fitted, math.exp(offset), quality, missing)


def _by_axis(table: Table) -> dict[str, list[tuple[float, Group]]]:
    """Sizes and groups that lie on a growth curve, by axis."""
    found: dict[str, list[tuple[float, Group]]] = {}
    for label in own_labels(table):
        for group in table.of(label).values():
            for axis, size in json.loads(group.first.axes).items():
                found.setdefault(axis, []).append((float(size), group))
    return found


def growths(table: Table) -> Iterator[tuple[str, list[Growth]]]:
    """(title, a curve for each configuration) of every axis and quantity with three sizes."""
    for axis, members in _by_axis(table).items():
        generator, _, size = axis.rpartition(" ")
        for name, quantity in _QUANTITIES:
            curves = [c for c in _curves(members, name) if len(set(c.sizes)) > 2]
            if curves:
                yield f"{generator} over {size}: {quantity}", curves


def _curves(members: Sequence[tuple[float, Group]], name: str) -> list[Growth]:
    """One curve a configuration. Times of the solver count only where there was a proof: a time
    limit has no exponent."""
    found: dict[str, list[tuple[float, float | None]]] = {}
    for size, group in members:
        found.setdefault(group.first.label, []).append((size, _value(group, name)))
    return [
        growth(
            label, ((x, y) for x, y in points if y is not None), sum(y is None for _, y in points)
        )
        for label, points in found.items()
    ]


def _value(group: Group, name: str) -> float | None:
    if name != "seconds":
        return group.value(name)
    return group.seconds if group.solved else None
