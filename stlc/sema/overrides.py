"""`-D name=value`: numbers, or texts with a unit, in place of a parameter's value."""

from __future__ import annotations

import re
from collections.abc import Mapping
from math import isfinite

from stlc.sema.name_errors import BadOverride, UnknownOverride
from stlc.sema.report import Report, nearest
from stlc.sema.units import UnknownUnitName, parse_unit
from stlc.sema.values import Scalar
from stlc.syntax import ast

_VALUE = re.compile(r"\s*([+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?)\s*(\S.*?)?\s*")


def overrides(
    params: Mapping[str, str | float], declarations: Mapping[str, ast.Statement], report: Report
) -> dict[str, Scalar]:
    """The values that replace those of the mission's parameters, by name."""
    known = [n for n, s in declarations.items() if isinstance(s, ast.Param)]
    found: dict[str, Scalar] = {}
    for name, value in params.items():
        if name not in known:
            near = nearest(name, known)
            hint = f"did you mean `{near}`?" if near else _params(known)
            report.add(UnknownOverride(name=name, hint=hint))
            continue
        scalar = parse_value(value)
        if scalar is None:
            report.add(BadOverride(name=name, value=str(value)))
        else:
            found[name] = scalar
    return found


def parse_value(value: str | float) -> Scalar | None:
    """A number, a text with a number, or one with a number and a unit; None if it is neither."""
    if not isinstance(value, str):
        return Scalar(float(value)) if isfinite(value) else None
    match = _VALUE.fullmatch(value)
    if match is None or not isfinite(float(match[1])):
        return None
    if match[2] is None:
        return Scalar(float(match[1]))
    try:
        scaled = parse_unit(match[2])
    except UnknownUnitName:
        return None
    return Scalar(float(match[1]) * scaled.scale + scaled.offset, unit=scaled.unit)


def _params(known: list[str]) -> str:
    if known:
        return f"it has: {', '.join(known)}"
    return "it has none; a line such as `param v = 2 m/s` declares one"
