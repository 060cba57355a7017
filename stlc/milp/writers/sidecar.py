"""The JSON beside a written model: what each name stands for, and where it comes from."""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from stlc.milp.model import Block, Model, Origin
from stlc.milp.writers.form import CONSTANT, UPPER
from stlc.milp.writers.names import safe_prefixes


def sidecar_path(path: Path) -> Path:
    """`OUT.names.json` for a model file OUT."""
    return path.with_name(path.name + ".names.json")


def sidecar_json(model: Model) -> str:
    """Each block of columns and rows: names, shape, and the requirement it was compiled from."""
    free = np.isneginf(model.row_lower) & np.isposinf(model.row_upper)
    content = {
        "format": "stlc names 1",
        "model": model.name,
        "naming": (
            "member (i, j) of a block is PREFIX_i_j; a second half of a two-sided row "
            f"ends in {UPPER}"
        ),
        "sense": "minimize",
        "constant": {"column": CONSTANT, "fixed_at": 1, "cost": model.offset},
        "columns": _blocks(model.col_blocks, "c"),
        "rows": _blocks(model.row_blocks, "r"),
        "rows_left_out": np.flatnonzero(free).tolist(),  # they bound nothing
    }
    return json.dumps(content, indent=1) + "\n"


def _blocks(blocks: Sequence[Block], letter: str) -> list[dict[str, Any]]:
    """What the names with each prefix are: the block's name, shape and origin."""
    prefixes = safe_prefixes(blocks, letter)
    return [
        {
            "prefix": prefix,
            "block": block.name,
            "first": block.start,
            "shape": list(block.shape),
            **_origin(block.origin),
        }
        for block, prefix in zip(blocks, prefixes, strict=True)
    ]


def _origin(origin: Origin) -> dict[str, Any]:
    span = origin.span
    if span is None:
        return {"origin": origin.label}
    place = {"file": span.source.name, "line": span.line, "column": span.column}
    return {"origin": origin.label, **place, "text": span.text}
