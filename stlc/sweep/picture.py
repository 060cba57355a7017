"""A sweep as a picture: cost over a parameter, over two, or one cost over another."""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from stlc.errors import UsageError
from stlc.files import atomic_output
from stlc.plot import FORMATS as KNOWN
from stlc.plot.style import BAD, COLOURS, MARKERS, RC
from stlc.sweep.ask import Answer
from stlc.sweep.axes import Axis, Point
from stlc.sweep.frontier import Frontier
from stlc.sweep.heat_map import draw_map, varied
from stlc.sweep.work import Found

if TYPE_CHECKING:
    from matplotlib.axes import Axes

FORMATS = tuple(kind for kind in KNOWN if kind != "gif")  # nothing of a sweep moves
_SIZE = (7.0, 4.5)  # inches
_NUMBER = re.compile(r"\s*[+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?")

Results = Sequence[tuple[Point, Found]]


def check_name(path: Path) -> str:
    """The format by a file's ending. UsageError for another."""
    kind = path.suffix.lower().lstrip(".")
    if kind not in FORMATS:
        known = ", ".join(f".{name}" for name in FORMATS)
        raise UsageError(f"cannot draw {path}: the name must end in one of {known}")
    return kind


def draw(path: Path, axes: Sequence[Axis], costs: tuple[str, str] | None, found: Results) -> None:
    """Write the picture: trade-off curves, a map of the objective over the two parameters that
    vary, or the objective over the first one, a line for each combination of the others; there
    points without a plan are crosses at the foot.

    Raises UsageError for another ending, OutputError when the file can't be written.
    """
    import matplotlib
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    kind = check_name(path)
    metadata = {"svg": {"Date": None}, "pdf": {"CreationDate": None}}.get(kind)
    with matplotlib.rc_context(RC):
        figure = Figure(figsize=_SIZE, layout="constrained")
        FigureCanvasAgg(figure)
        ax = figure.add_subplot()
        both = varied(axes)
        if costs is not None:
            _trades(ax, costs, found)
        elif both is not None:
            draw_map(ax, *both, found)
        else:
            _lines(ax, axes, found)
        if len(ax.get_legend_handles_labels()[1]) > 1:
            ax.legend()
        with atomic_output(path) as stream:
            figure.savefig(stream, format=kind, dpi=130, metadata=metadata)


def _trades(ax: Axes, costs: tuple[str, str], found: Results) -> None:
    """One curve for each point of the grid."""
    for k, (point, curve) in enumerate(found):
        if isinstance(curve, Frontier) and curve.trades:
            xs, ys = zip(*((t.second, t.first) for t in curve.trades), strict=True)
            ax.plot(xs, ys, label=_label(point) or None, linewidth=1.4, markersize=5, **_look(k))
    ax.set_xlabel(costs[1])
    ax.set_ylabel(costs[0])


def _lines(ax: Axes, axes: Sequence[Axis], found: Results) -> None:
    """The objective over the first axis: its numbers, or its values one beside the other."""
    first = axes[0].values if axes else ("",)
    numbers = [_number(value) for value in first]
    place = {
        value: float(k) if None in numbers else number or 0.0
        for k, (value, number) in enumerate(zip(first, numbers, strict=True))
    }
    lost = []
    for k, (rest, line) in enumerate(_grouped(found)):
        good = [(place[v], a.objective) for v, a in line if a.objective is not None]
        lost += [place[v] for v, a in line if a.objective is None]
        if good:
            xs, ys = zip(*good, strict=True)
            ax.plot(xs, ys, label=rest or "objective", linewidth=1.4, markersize=5, **_look(k))
    if lost:
        ax.plot(lost, [0.02] * len(lost), "x", color=BAD, label="no plan",
                transform=ax.get_xaxis_transform())  # fmt: skip
    if None in numbers:
        ax.set_xticks(list(place.values()), list(place))
    ax.set_xlabel(axes[0].name if axes else "")
    ax.set_ylabel("objective")


def _grouped(found: Results) -> Iterator[tuple[str, list[tuple[str, Answer]]]]:
    """(values of all axes but the first, its (value, answer) pairs)."""
    lines: dict[str, list[tuple[str, Answer]]] = {}
    for point, answer in found:
        if isinstance(answer, Answer):
            value = point[0][1] if point else ""
            lines.setdefault(_label(point[1:]), []).append((value, answer))
    yield from lines.items()


def _label(point: Point) -> str:
    return ", ".join(f"{name} = {value}" for name, value in point)


def _look(k: int) -> dict[str, Any]:
    return {"color": COLOURS[k % len(COLOURS)], "marker": MARKERS[k % len(MARKERS)]}


def _number(value: str) -> float | None:
    found = _NUMBER.match(value)
    return None if found is None else float(found[0])
