"""What can be wrong with a table before any solver sees it."""

from __future__ import annotations

from stlc.errors import StlcError


class TableError(StlcError):
    """A table, its partition and its pair of radios don't fit together."""
