"""The two ends of a link as the radio sees them: cells, stations and heights, as boxes."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from stlc.radio.errors import RadioError
from stlc.radio.partition import Partition
from stlc.radio.taylor import Boxes

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True, eq=False)
class LinkEnds:
    """The two ends of a link: cells, and either cells or a station.

    first     cells of the first end
    second    cells of the second end (None: the same as the first), or a point (2,) [m]
    heights   of the two ends [m], None for an end that may be anywhere in its cells' layers; an end
              of a known height is there in every layer. None for a channel in the plane
    receiver  name whose calibration offset applies
    """

    first: Partition
    second: Partition | Array | None = None
    heights: tuple[float | None, float | None] | None = None
    receiver: str | None = None

    @property
    def station(self) -> bool:
        """True when the second end does not move."""
        return isinstance(self.second, np.ndarray)

    @property
    def symmetric(self) -> bool:
        """True when both ends share cells and height: the table is stored once."""
        same = self.second is None or self.second is self.first
        return same and (self.heights is None or self.heights[0] == self.heights[1])

    @property
    def second_cells(self) -> Partition | None:
        """Cells of the second end, None for a station."""
        if isinstance(self.second, np.ndarray):
            return None
        return self.first if self.second is None else self.second

    def boxes(self) -> tuple[Boxes, Boxes]:
        """Both ends as boxes with 2 or 3 axes."""
        heights = (None, None) if self.heights is None else self.heights
        axes = 2 if self.heights is None else 3
        first = _cell_boxes(self.first, axes, heights[0])
        if isinstance(self.second, np.ndarray):
            point = np.asarray(self.second, dtype=np.float64)[None, :2]
            return first, _raised(Boxes(point, np.zeros_like(point)), heights[1])
        if self.symmetric:
            return first, first
        return first, _cell_boxes(self.second or self.first, axes, heights[1])


def _cell_boxes(partition: Partition, axes: int, height: float | None) -> Boxes:
    """Cells as boxes with `axes` axes, at one height where that is known."""
    if height is None and partition.axes < axes:
        raise RadioError("an end without a height needs a partition with layers")
    flat = axes if height is None else 2
    half = (partition.high - partition.low) / 2.0
    return _raised(Boxes(partition.centres[:, :flat], half[:, :flat]), height)


def _raised(boxes: Boxes, height: float | None) -> Boxes:
    """With a third axis, on which the boxes have no width; as they are where no height is given."""
    if height is None:
        return boxes
    level = np.full((len(boxes), 1), height)
    return Boxes(np.hstack([boxes.centre, level]), np.hstack([boxes.half, np.zeros_like(level)]))
