"""What a motion keeps out of: unions closed with what is around them, made once for each form."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from stlc.places import Polytope
from stlc.verify.shapes import Stay
from stlc.verify.unions import TOUCH, closed_union, moved, past_borders


@dataclass(frozen=True, slots=True, eq=False)
class Out:
    """What not to be in by more than the tolerance; the union with what is around; itself."""

    core: Any
    border: Any
    solid: Any


def kept_out(stay: Stay, space: Polytope | None) -> Out:
    """`keep_out` of a body alone, made once."""
    key = (space is None, stay.start.tobytes(), stay.move.tobytes())
    if key not in stay.form.made:
        stay.form.made[key] = keep_out(stay.form.parts, space, stay)
    made: Out = stay.form.made[key]
    return made


def keep_out(parts: Sequence[Any], space: Polytope | None, stay: Stay) -> Out:
    """Polygons to keep out of while they move; what lies beyond the workspace adds to them."""
    import shapely

    past = [moved(p, -stay.start) for p in past_borders(space, stay.move)]
    whole, solid = closed_union(parts, past), closed_union(parts)
    core = whole.buffer(-2.0 * TOUCH, join_style="mitre")
    if past:
        far = shapely.union_all(past).buffer(-TOUCH, join_style="mitre")
        own = solid.buffer(-2.0 * TOUCH, join_style="mitre")
        core = shapely.union_all([shapely.difference(core, far), own])
    shapely.prepare(core)
    return Out(core, whole, solid)
