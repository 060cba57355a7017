"""Windows of steps, both ends included; the last may be infinite."""

from __future__ import annotations

from collections.abc import Sequence

Window = tuple[float, float]


def merged(windows: Sequence[Window]) -> tuple[Window, ...]:
    """Windows of steps in order, those that overlap or follow each other as one."""
    found: list[Window] = []
    for start, end in sorted(windows):
        if found and start <= found[-1][1] + 1.0:
            found[-1] = (found[-1][0], max(end, found[-1][1]))
        else:
            found.append((start, end))
    return tuple(found)


def common(one: Sequence[Window], other: Sequence[Window]) -> tuple[Window, ...]:
    """The steps in both of two merged lists."""
    both = ((max(a[0], b[0]), min(a[1], b[1])) for a in one for b in other)
    return tuple((start, end) for start, end in both if start <= end)
