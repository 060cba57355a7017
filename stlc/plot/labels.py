"""Labels that keep out of each other's way."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.transforms import Bbox

Array = NDArray[np.float64]

# (direction of the offset, horizontal and vertical alignment), best first
_PLACES = (
    (0, 1, "center", "bottom"), (0, -1, "center", "top"),
    (1, 0, "left", "center"), (-1, 0, "right", "center"),
    (1, 1, "left", "bottom"), (-1, 1, "right", "bottom"),
    (1, -1, "left", "top"), (-1, -1, "right", "top"),
)  # fmt: skip

_MARK = 5.0  # points from a marker's middle to its border


@dataclass(slots=True)
class Labels:
    """Collects labels of an axes and places them one after the other.

    `avoid` (K, 2) are data points that a label had better not cover; at `marks` (2,) there are
    markers, which it covers no more than another label.
    """

    axes: Axes
    avoid: list[Array] = field(default_factory=list)
    marks: list[Array] = field(default_factory=list)
    _wanted: list[tuple[str, Array, Array, dict[str, Any]]] = field(default_factory=list)

    def add(self, text: str, low: Array, high: Array, gap: float = 4.0, **style: Any) -> None:
        """Ask for a label `gap` points from the box `low` (2,) to `high` (2,), in data units."""
        spot = np.asarray(low, dtype=np.float64), np.asarray(high, dtype=np.float64)
        self._wanted.append((text, *spot, {"gap": gap, **style}))

    def place(self) -> None:
        """Draw every label where it covers least; the axes' limits must be final."""
        renderer = self.axes.figure.canvas.get_renderer()  # type: ignore[attr-defined]
        frame = self.axes.get_window_extent(renderer)
        points = self.axes.transData.transform(np.vstack(self.avoid)) if self.avoid else None
        taken = self._marked()
        for text, low, high, style in self._wanted:
            tried = []
            for order, place in enumerate(_PLACES):
                artist = self._draw(text, low, high, place, style)
                box = artist.get_window_extent(renderer).padded(1.5)
                tried.append((_cost(box, frame, taken, points, order), order, artist, box))
            tried.sort(key=lambda option: option[:2])
            for _, _, artist, _ in tried[1:]:
                artist.remove()
            taken.append(tried[0][3])

    def _marked(self) -> list[Bbox]:
        """The boxes of the markers, in pixels."""
        from matplotlib.transforms import Bbox

        half = _MARK * self.axes.figure.dpi / 72.0
        spots = [self.axes.transData.transform(mark) for mark in self.marks]
        return [Bbox([spot - half, spot + half]) for spot in spots]

    def _draw(
        self, text: str, low: Array, high: Array, place: tuple[int, int, str, str], style: Any
    ) -> Any:
        """One label on the box [low, high]; `place` = (dx, dy, alignments), gaps in points."""
        from matplotlib.patheffects import withStroke

        dx, dy, ha, va = place
        x, y = (low + high) / 2.0 + (high - low) / 2.0 * (dx, dy)
        gap, rest = style["gap"], {k: v for k, v in style.items() if k != "gap"}
        halo = [withStroke(linewidth=2.5, foreground="white")]
        label = self.axes.annotate(
            text, (float(x), float(y)), (gap * dx, gap * dy), textcoords="offset points",
            ha=ha, va=va, zorder=9, path_effects=halo, annotation_clip=False, **rest,
        )  # fmt: skip
        label.set_in_layout(False)
        return label


def _cost(box: Bbox, frame: Bbox, taken: list[Bbox], points: Array | None, order: int) -> float:
    """Overlaps weigh most, then leaving the frame, then covered points, then the order."""
    overlaps = sum(box.overlaps(other) for other in taken)
    outside = box.x0 < frame.x0 or box.x1 > frame.x1 or box.y0 < frame.y0 or box.y1 > frame.y1
    covered = 0
    if points is not None:
        inside = (points > (box.x0, box.y0)) & (points < (box.x1, box.y1))
        covered = int(inside.all(axis=1).sum())
    return float(1e6 * overlaps + 1e4 * outside + min(10.0 * covered, 5e3) + order)
