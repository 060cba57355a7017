"""Lengths and times as options take them: `50 cm`, `100 ms`, or a number in the SI unit."""

from __future__ import annotations

from typing import TYPE_CHECKING

import click

if TYPE_CHECKING:
    from stlc.sema.units import Unit


def metres(context: click.Context, parameter: click.Parameter, value: str | None) -> float | None:
    """A length such as `1 m`, `50 cm` or `0.5`, in metres."""
    from stlc.sema.units import METRE

    return _quantity(value, METRE, "length such as '1 m' or '50 cm'")


def seconds(context: click.Context, parameter: click.Parameter, value: str | None) -> float | None:
    """A time such as `1 s`, `100 ms` or `0.5`, in seconds."""
    from stlc.sema.units import SECOND

    return _quantity(value, SECOND, "time such as '1 s' or '100 ms'")


def _quantity(value: str | None, unit: Unit, what: str) -> float | None:
    """The number in the SI unit; it is more than 0."""
    from stlc.sema.overrides import parse_value

    if value is None:
        return None
    found = parse_value(value)
    if found is None or found.unit not in (None, unit) or found.constant <= 0:
        raise click.BadParameter(f"{value!r} is no {what}")
    return found.constant
