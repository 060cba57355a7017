"""The JSON beside a written model: what each name stands for, and where it comes from."""

from __future__ import annotations

import glob
import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from stlc.milp.model import Block, Model, Origin
from stlc.milp.writers.form import CONSTANT, UPPER
from stlc.milp.writers.names import safe_prefixes


def sidecar_path(path: Path) -> Path:
    """`OUT.names.json` for a model file OUT."""
    return path.with_name(path.name + ".names.json")


def sidecar_json(model: Model, made: Mapping[str, Any] | None = None) -> str:
    """Each block of columns and rows: names, shape, and the requirement it was compiled from.

    `made` tells how, so that a solution can be read the same way.
    """
    free = np.isneginf(model.row_lower) & np.isposinf(model.row_upper)
    content = {
        "format": "stlc names 1",
        "model": model.name,
        "made": dict(made or {}),
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


def made_before(solution: Path, sha256: str) -> Mapping[str, Any]:
    """What a model beside a solution, of the same name, was made with, if of the text `sha256`."""
    stem = glob.escape(solution.name.partition(".")[0])
    for path in sorted(solution.parent.glob(f"{stem}.*names.json")):
        try:
            content = json.loads(path.read_text(encoding="utf-8"))
        except (OSError, ValueError, RecursionError):
            continue
        made = content.get("made") if isinstance(content, dict) else None
        if isinstance(made, dict) and made.get("sha256") == sha256:
            return made
    return {}


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
