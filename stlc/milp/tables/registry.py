"""The encodings by name, those of third parties included, and the choice `auto` makes."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from importlib.metadata import entry_points
from math import prod
from types import MappingProxyType

from stlc.errors import UsageError, hinted
from stlc.milp.context import Context
from stlc.milp.tables.encoding import Encoding
from stlc.milp.tables.hull import Hull
from stlc.milp.tables.lifted import Lifted
from stlc.milp.tables.link import Link
from stlc.milp.tables.literal import Literal
from stlc.milp.tables.logarithmic import Logarithmic
from stlc.milp.tables.unary import Unary

ENCODINGS: Mapping[str, Encoding] = MappingProxyType(
    {
        e.name: e
        for e in (
            Unary(),
            Hull(),
            Lifted(),
            Logarithmic(),
            Literal(),
            Literal("literal-tight", None),
        )
    }
)
"""Built-in encodings."""

ENTRY_POINTS = "stlc.encodings"
"""Entry-point group under which a package offers an `Encoding` object."""

MOST_PAIRS = 2_000_000
"""Pair columns of one cost beyond which `auto` turns to cuts without them."""


@dataclass(frozen=True, slots=True)
class Choice:
    """An encoding and why it was taken."""

    encoding: Encoding
    reason: str


def encoding_named(name: str) -> Encoding:
    """Built-in, or offered by an installed package. Raises UsageError for any other name."""
    if name in ENCODINGS:
        return ENCODINGS[name]
    offered = {e.name: e for e in entry_points(group=ENTRY_POINTS)}
    if name not in offered:
        known = ["auto", *ENCODINGS, *sorted(offered)]
        raise UsageError(f"no table encoding is called '{name}'; {hinted(name, known)}")
    loaded: Encoding = offered[name].load()
    return loaded


def choose(ctx: Context, links: Sequence[Link], name: str = "auto") -> Choice:
    """The encoding for one table over these links: the one named, or by structure."""
    if name != "auto":
        return Choice(encoding_named(name), "asked for")
    if not links or len(links[0].ends) < 2:
        return Choice(ENCODINGS["unary"], "at most one end moves: its cells are enough")
    pairs = sum(prod(link.shape(ctx)) for link in links)
    if pairs <= MOST_PAIRS:
        return Choice(ENCODINGS["unary"], f"{pairs} cell pairs in reach")
    return Choice(ENCODINGS["lifted"], f"{pairs} cell pairs in reach, too many for a column each")
