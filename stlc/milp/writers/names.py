"""Names that every reader accepts: `[A-Za-z_][A-Za-z0-9_]*`, at most 100 characters, unique."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Sequence
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from stlc.milp.model import Block, Model

Texts: TypeAlias = NDArray[np.bytes_]

LONGEST = 100  # CBC's reader of LP files takes no longer ones
_FOREIGN = re.compile(r"[^A-Za-z0-9_]")
# Words of the LP format, exponents (`e5`), and what readers take for a number.
_RESERVED = re.compile(
    r"(?:inf|nan|e\d*$|free$|st$|such$|subject|bounds?$|min|max|end$|bin|gen|int|semi|sos|sin$|sec)",
    re.IGNORECASE,
)


_INDICES = re.compile(r"(?:_\d+)+$")


def safe_names(model: Model) -> tuple[list[str], list[str]]:
    """Names of columns and rows in files: those of the model, made safe. In order, unique."""
    columns, rows = safe_texts(model)
    return columns.astype(str).tolist(), rows.astype(str).tolist()


def safe_texts(model: Model) -> tuple[Texts, Texts]:
    """`safe_names` as arrays of bytes, (n,) and (m,)."""
    return _safe(model.col_blocks, "c"), _safe(model.row_blocks, "r")


def plain_texts(model: Model) -> tuple[Texts, Texts]:
    """Short names by position: c0, c1, ... and r0, r1, ... (for hand-over by file)."""
    return _indexed(b"c", model.columns), _indexed(b"r", model.rows)


def safe_prefixes(blocks: Sequence[Block], letter: str) -> list[str]:
    """What the names of each block's members begin with; the rest are the indices `_i_j`."""
    prefixes = [_prefix(block.name) for block in blocks]
    if _distinct(blocks, prefixes):
        return prefixes
    return [f"{letter}{k}_{prefix}" for k, prefix in enumerate(prefixes)]


def _distinct(blocks: Sequence[Block], prefixes: Sequence[str]) -> bool:
    """No two members are named alike: only blocks equal up to trailing indices can clash."""
    stems = [_INDICES.sub("", prefix) for prefix in prefixes]
    count = Counter(stems)
    doubtful = [k for k, stem in enumerate(stems) if count[stem] > 1]
    names = [_members(blocks[k], prefixes[k]).tolist() for k in doubtful]
    return len(set().union(*names)) == sum(map(len, names))


def _safe(blocks: Sequence[Block], letter: str) -> Texts:
    prefixes = safe_prefixes(blocks, letter)
    parts = [_members(block, prefix) for block, prefix in zip(blocks, prefixes, strict=True)]
    return np.concatenate([np.empty(0, dtype="S1"), *parts])


def _members(block: Block, prefix: str) -> Texts:
    names = np.array([prefix.encode()])
    for extent in block.shape:
        names = np.char.add(names[:, None], _indexed(b"_", extent)[None, :]).ravel()
    return names


def _indexed(text: bytes, count: int) -> Texts:
    width = len(text) + len(str(max(count - 1, 0)))
    return np.array([b"%s%d" % (text, i) for i in range(count)], dtype=f"S{width}")


def _prefix(name: str) -> str:
    clean = _FOREIGN.sub("_", name)[: LONGEST - 40]  # room for indices and a distinguishing number
    if not clean or clean[0].isdigit() or _RESERVED.match(clean):
        return f"x_{clean}"
    return clean
