"""A mission and a plan of it, as most commands take them."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING

import click

from stlc.cli.common import load_with, parse_defines
from stlc.errors import MissionError, UsageError

if TYPE_CHECKING:
    from stlc.mission import Mission
    from stlc.plan import Plan


def load_planned(
    file: Path, plan: Path, define: tuple[str, ...], allow_path: tuple[Path, ...]
) -> tuple[Mission, Plan]:
    """The checked mission and the plan; the mission's warnings go to standard error.

    Parameters that `-D` doesn't set are as they were for the plan. Raises UsageError, with the
    place, for a plan that isn't one or whose parameters aren't the mission's.
    """
    from stlc.plan import read_plan

    run = read_plan(plan)
    given = parse_defines(define)
    params = {**_of_plan(file, run), **given}
    for name, value in run.params.items():
        if name in params and params[name] != value:
            text = f"the plan was made with -D {name}={value}; here it is {params[name]}"
            click.echo(f"{click.style('note', bold=True)}: {text}", err=True)
    try:
        return load_with(file, params, allow_path), run
    except MissionError as error:
        if (fault := _fault(error, plan, given)) is not None:
            raise fault from None
        raise


def _of_plan(file: Path, plan: Plan) -> Mapping[str, str]:
    """What `-D` set for a plan, where it is one of this very file: others have other parameters."""
    from stlc.plan import text_digest
    from stlc.syntax.read import read_source

    if not plan.params:
        return {}
    return plan.params if text_digest(read_source(file).text) == plan.sha256 else {}


def _fault(error: MissionError, plan: Path, given: Mapping[str, str]) -> UsageError | None:
    """The plan's own fault, where a value that the mission refuses is one of the plan's."""
    from stlc.plan_place import Place
    from stlc.sema.name_errors import BadOverride, UnknownOverride

    for diagnostic in error.diagnostics:
        match diagnostic:
            case BadOverride(name=name) if name not in given:
                wanted = "a number, alone or with a known unit"
            case UnknownOverride(name=name) if name not in given:
                wanted = "a `param` of the mission"
            case _:
                continue
        return Place(str(plan), f"params.{name}", None).fail(wanted)
    return None
