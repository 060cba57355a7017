"""Damage to the files that a mission reads: bytes, cells of tables, values of JSON, arrays."""

from __future__ import annotations

import io
import json
import random
from typing import Any

import numpy as np

CELLS = (
    "", "nan", "inf", "-inf", "1e309", "1e300", "-1e300", "1e-320", "0", "-0", "abc", '"', "'1'",
    "1,5", "1 2", "0x1f", "NULL", "9" * 400, "٣", "\ufeff1", "1e5", "-200", "None", "#", "=1+1",
)  # fmt: skip
VALUES: tuple[Any, ...] = (
    None, True, "x", [], {}, 0, -1, 1e300, float("nan"), float("inf"), [[1]], "1", 10**400,
)  # fmt: skip


def damaged_file(rng: random.Random, name: str, data: bytes) -> bytes:
    """One file, changed by what it is or by its bytes."""
    if rng.random() < 0.25:
        return _bytes(rng, data)
    if name.endswith((".csv", ".txt")):
        return _table(rng, data)
    if name.endswith((".json", ".geojson")):
        return _json(rng, data)
    if name.endswith(".npz"):
        return _arrays(rng, data)
    return _bytes(rng, data)


def _bytes(rng: random.Random, data: bytes) -> bytes:
    made = bytearray(data)
    at = rng.randrange(len(made) + 1)
    match rng.randrange(6):
        case 0:
            made[at : at + 1] = bytes([rng.randrange(256)])
        case 1:
            del made[at:]
        case 2:
            del made[at : at + rng.randint(1, 50)]
        case 3:
            made[at:at] = rng.randbytes(rng.randint(1, 8))
        case 4:
            return b""
        case _:
            return data.decode("latin-1").encode("utf-16")
    return bytes(made)


def _table(rng: random.Random, data: bytes) -> bytes:
    rows = [line.split(",") for line in data.decode("utf-8", "replace").splitlines()]
    if not rows:
        return b"\n"
    row = rng.randrange(len(rows)) if rng.random() < 0.8 else 0
    column = rng.randrange(len(rows[row]))
    match rng.randrange(9):
        case 0 | 1 | 2:
            rows[row][column] = rng.choice(CELLS)
        case 3:
            del rows[row][column]
        case 4:
            del rows[row]
        case 5:
            rows = [r[:column] + r[column + 1 :] for r in rows]
        case 6:
            rows.insert(row, rows[rng.randrange(len(rows))])
        case 7:
            rows = rows[: rng.choice((1, 2, 3))]
        case _:
            value = rng.choice(CELLS)
            rows = rows[:1] + [[*r[:column], value, *r[column + 1 :]] for r in rows[1:]]
    end, delimiter = rng.choice(("\n", "\n", "\r\n", "\r")), rng.choice((",", ",", ",", ";", "\t"))
    return end.join(delimiter.join(r) for r in rows).encode("utf-8", "replace")


def _json(rng: random.Random, data: bytes) -> bytes:
    try:
        whole = json.loads(data)
    except ValueError:
        return _bytes(rng, data)
    places = list(_places(whole))
    if not places:
        return b"{}"
    holder, key = rng.choice(places)
    if rng.random() < 0.7:
        holder[key] = rng.choice(VALUES)
    elif isinstance(holder, list):
        holder.insert(key, holder[key])
    else:
        del holder[key]
    return json.dumps(whole).encode()


def _places(value: Any) -> list[tuple[Any, Any]]:
    """Every (container, key) of a JSON value."""
    if not isinstance(value, dict | list):
        return []
    own = list(value.items() if isinstance(value, dict) else enumerate(value))
    return [(value, k) for k, _ in own] + [p for _, v in own for p in _places(v)]


def _arrays(rng: random.Random, data: bytes) -> bytes:
    try:
        with np.load(io.BytesIO(data)) as file:
            arrays = {name: file[name] for name in file.files}
    except (ValueError, OSError, KeyError):
        return _bytes(rng, data)
    name = rng.choice(sorted(arrays))
    arrays[name] = _array(rng, arrays[name].copy())
    if rng.random() < 0.1:
        arrays[f"{name}_2"] = arrays.pop(name)
    out = io.BytesIO()
    np.savez(out, **arrays)
    return out.getvalue()


def _array(rng: random.Random, array: Any) -> Any:
    match rng.randrange(8):
        case 0 | 1 | 2 if array.size and array.dtype.kind == "f":
            array.flat[rng.randrange(array.size)] = rng.choice(
                (np.nan, np.inf, -np.inf, 1e300, -1.0, 0.0, 1e-320)
            )
        case 3:
            return array[:-1]
        case 4:
            return array.ravel()
        case 5:
            return array.astype(rng.choice(("int64", "complex128", "U8", "bool", "float16")))
        case 6:
            return array[None]
        case _:
            return np.zeros((0, 0))
    return array
