"""stlc: communication-aware multi-robot missions in Signal Temporal Logic, compiled to MILP.

The Python API is `stlc.api` (`load`, `loads`, `check`, `compile`, `solve`, `verify`, `explain`).
"""

from __future__ import annotations

__version__ = "0.2.0"
__all__ = ["__version__"]
