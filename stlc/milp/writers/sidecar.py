"""The JSON beside a written model: what each name stands for, and where it comes from."""

from __future__ import annotations

import glob
import json
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from stlc.milp.model import Block, Model, Origin
from stlc.milp.writers.form import CONSTANT, UPPER
from stlc.milp.writers.names import safe_prefixes


@dataclass(frozen=True, slots=True)
class Made:
    """How a model was compiled, so that a solution can be read the same way.

    `sha256` is the digest of the mission's text, `params` its parameters as `-D` takes them.
    """

    sha256: str
    params: Mapping[str, str] = field(default_factory=dict)
    encoding: str = "auto"
    disable: tuple[str, ...] = ()


def sidecar_path(path: Path) -> Path:
    """`OUT.names.json` for a model file OUT."""
    return path.with_name(path.name + ".names.json")


def sidecar_json(model: Model, made: Made | None = None) -> str:
    """Each block of columns and rows: names, shape, and the requirement it was compiled from.

    `made` is how the model came about, where that is known.
    """
    free = np.isneginf(model.row_lower) & np.isposinf(model.row_upper)
    content = {
        "format": "stlc names 1",
        "model": model.name,
        "made": asdict(made) if made else {},
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


def made_before(solution: Path, sha256: str) -> Made | None:
    """How a model beside a solution, of the same name, was made, if of the text `sha256`."""
    stem = glob.escape(solution.name.partition(".")[0])
    for path in sorted(solution.parent.glob(f"{stem}.*names.json")):
        try:
            content = json.loads(path.read_text(encoding="utf-8"))
        except (OSError, ValueError, RecursionError):
            continue
        made = content.get("made") if isinstance(content, dict) else None
        if isinstance(made, dict) and made.get("sha256") == sha256:
            return _read(made)
    return None


def _read(made: dict[str, Any]) -> Made | None:
    """What `made` says, or None where somebody has put values of other types there."""
    known = Made(made["sha256"])
    params, encoding = made.get("params", known.params), made.get("encoding", known.encoding)
    disable = made.get("disable", [])
    if not isinstance(params, dict) or not isinstance(encoding, str):
        return None
    if not isinstance(disable, list) or not all(isinstance(word, str) for word in disable):
        return None
    return Made(known.sha256, {k: str(v) for k, v in params.items()}, encoding, tuple(disable))


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
