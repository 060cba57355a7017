"""Model files that every solver reads alike: `write_model(model, "mission.mps.gz")`."""

from __future__ import annotations

import gzip
import os
from collections.abc import Iterator
from pathlib import Path

from stlc.errors import UsageError
from stlc.files import atomic_output, write_atomic
from stlc.milp.model import Model
from stlc.milp.writers.lp import lp_chunks
from stlc.milp.writers.mps import mps_chunks
from stlc.milp.writers.names import safe_names, safe_texts
from stlc.milp.writers.sidecar import Made, sidecar_json, sidecar_path

__all__ = ["safe_names", "sidecar_path", "write_model"]

_WRITERS = {".mps": mps_chunks, ".lp": lp_chunks}


def write_model(
    model: Model,
    path: str | os.PathLike[str],
    *,
    sidecar: bool = True,
    made: Made | None = None,
) -> None:
    """Write LP or MPS by the suffix (`.gz` compresses), and `PATH.names.json` beside it.

    `made` is noted in the latter: how the model came about.

    The same model gives the same bytes. Raises UsageError for another suffix, OutputError when a
    file cannot be written (nothing half-written is left).
    """
    target = Path(path)
    suffixes = target.suffixes[-2:] if target.suffix == ".gz" else target.suffixes[-1:]
    writer = _WRITERS.get(suffixes[0].lower()) if suffixes else None
    if writer is None:
        raise UsageError(f"{target}: name a file .lp, .mps, .lp.gz or .mps.gz")
    chunks = writer(model, *safe_texts(model))
    if sidecar:
        write_atomic(sidecar_path(target), sidecar_json(model, made))
    _write(chunks, target, compress=target.suffix == ".gz")


def _write(chunks: Iterator[bytes], target: Path, *, compress: bool) -> None:
    with atomic_output(target) as stream:
        if not compress:
            stream.writelines(chunks)
            return
        # No name and no time in the header: the same model gives the same bytes.
        with gzip.GzipFile("", "wb", 6, stream, mtime=0) as packed:
            for chunk in chunks:
                packed.write(chunk)
