"""stlc: communication-aware multi-robot missions in Signal Temporal Logic, compiled to MILP.

The Python API is `stlc.Mission` (`from_text`, `from_file`, `check`, `compile`, `solve`,
`verify`); it is imported on first use so that `stlc --version` stays fast.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from stlc.mission import Mission as Mission

__version__ = "0.1.0"
__all__ = ["Mission", "__version__"]


def __getattr__(name: str) -> object:
    if name == "Mission":
        from stlc.mission import Mission

        return Mission
    raise AttributeError(f"module 'stlc' has no attribute {name!r}")
