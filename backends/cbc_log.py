"""What CBC prints and its solution file leaves out: the bound, the node count."""

from __future__ import annotations

import re

_BOUND = re.compile(r"^Lower bound:\s+(\S+)", re.MULTILINE)
_NODES = re.compile(r"^Enumerated nodes:\s+(\d+)", re.MULTILINE)
_VERSION = re.compile(r"^(?:Version:\s+(\S+)|CBC (devel \(git:\w+\)))", re.MULTILINE)


def bound(log: str) -> float | None:
    """The lower bound at a limit, without the objective's constant; None when not printed."""
    found = _BOUND.search(log)
    return float(found[1]) if found else None


def nodes(log: str) -> int | None:
    """Enumerated nodes, None when not printed."""
    found = _NODES.search(log)
    return int(found[1]) if found else None


def version(log: str) -> str:
    """Such as 'CBC 2.10.3', or 'CBC' when the log does not say."""
    found = _VERSION.search(log)
    return f"CBC {found[1] or found[2]}" if found else "CBC"
