"""stlc: communication-aware multi-robot missions in Signal Temporal Logic, compiled to MILP.

    import stlc

    m = stlc.load("mission.stl")
    plan = m.solve(time_limit=5)
    plan.plot("plan.png")

Missions can be built in code too (`stlc.Mission`); printed, they are mission files. What lies below
is `stlc.api`: functions over plain data.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from stlc.version import __version__

if TYPE_CHECKING:
    from stlc.front import *  # noqa: F403

_FRONT = (
    "Formula", "Mission", "Plan", "Quantity", "Shape", "abs_", "all_of", "always", "any_of", "ber",
    "box", "distance", "effort", "eventually", "formula", "line", "link_cost", "load", "loads",
    "maximum", "minimum", "moving", "norm", "polygon", "probability", "prr", "quantity",
    "read_plan", "robustness", "rssi", "separation", "snr",
)  # fmt: skip

__all__ = ["__version__", *_FRONT]


def __getattr__(name: str) -> Any:
    """What `stlc.front` holds, imported when it is asked for."""
    if name not in _FRONT:
        raise AttributeError(f"module 'stlc' has no attribute {name!r}")
    from importlib import import_module

    return getattr(import_module("stlc.front"), name)


def __dir__() -> list[str]:
    return sorted({*globals(), *_FRONT})
