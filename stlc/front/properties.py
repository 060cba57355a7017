"""Properties of blocks from keyword arguments: `speed=2` is `speed <= 2`."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any

from stlc.front.text import matrix, point, words, written

_MATRICES = ("A", "B", "c")
_POINTS = ("start", "effort_state", "effort_input", "start_noise", "control_noise",
           "disturbance")  # fmt: skip
_NAMES = ("states", "inputs", "state_units", "input_units", "position", "velocity")
_PLAIN = ("heading", "lookahead", "wheelbase", "directions", "period", "mass", "dimensions",
          "height", "length", "fading", "shadowing", "noise_floor", "modulation", "packet", "cost",
          "bound", "bandwidth", "noise_figure", "frequency", "power", "antenna")  # fmt: skip


def block(given: Iterable[str], named: Mapping[str, Any]) -> str:
    """` { .. }` of properties as written and of keyword arguments; nothing where there are none."""
    lines = [*given, *(_property(key, value) for key, value in named.items() if value is not None)]
    return f" {{ {'; '.join(lines)} }}" if lines else ""


def _property(key: str, value: Any) -> str:
    """One property, by what its name takes.

    True and False are `on` and nothing; a pair bounds a state or an input from both sides.
    """
    if key in _MATRICES:
        return f"{key} = {matrix(value)}"
    if key in _POINTS:
        return f"{key} {point(value)}"
    if key in _NAMES:
        return f"{key} {words(value)}"
    if key in _PLAIN:
        return f"{key} {written(value)}"
    if key == "control":
        return f"control |u| <= {written(value)}"
    if key == "path_loss":
        level, exponent = value
        return f"path_loss L0 = {_level(level)}, n = {written(exponent)}"
    if key == "partition":
        return f"partition {value if isinstance(value, str) else ' x '.join(map(written, value))}"
    if key in ("samples", "laws"):
        return f'{key} "{value}"'
    return _bound(key, value)


def _level(value: Any) -> str:
    return written(value) if isinstance(value, str) else f"{written(value)} dBm"


def _bound(key: str, value: Any) -> str:
    """A flag, a range or an upper bound."""
    if value is True:
        return f"{key} on" if key == "turn_rate" else key
    if isinstance(value, tuple | list):
        low, high = value
        return f"{key} in [{written(low)}, {written(high)}]"
    return f"{key} <= {written(value)}"
