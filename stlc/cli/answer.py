"""The one JSON object that a command with `--json` prints on standard output, however it ends."""

from __future__ import annotations

import sys
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from contextvars import ContextVar
from typing import Any

import click

from stlc.errors import MissionError, NoPlanError

_ENDS = {
    1: "mistakes", 2: "usage", 3: "infeasible", 4: "no_plan", 5: "solver_failed",
    6: "violated", 70: "disagreement", 74: "not_written", 130: "interrupted",
}  # fmt: skip

_GIVEN: ContextVar[list[bool] | None] = ContextVar("answer", default=None)


@contextmanager
def one_answer() -> Iterator[None]:
    """A command's run, in which `answer` is called once at most."""
    token = _GIVEN.set([])
    try:
        yield
    finally:
        _GIVEN.reset(token)


def answer(value: Mapping[str, Any]) -> None:
    """Print the object; numbers that JSON lacks are "inf", "-inf" and null."""
    from stlc.plan_json import layout, plain

    given = _GIVEN.get()
    if given is not None:
        given.append(True)
    click.echo(layout(plain(value)), nl=False)


def answer_end(status: int, error: BaseException | str, **more: object) -> None:
    """Say with what exit status a command ends that has no result, if `--json` was asked for and
    nothing was said yet: status, exit_status, message, bound, diagnostics, and `more`."""
    if "--json" not in sys.argv[1:] or _GIVEN.get():
        return
    from stlc.render.json import as_dict

    mistakes = error.diagnostics if isinstance(error, MissionError) else ()
    end = {
        "status": _ENDS.get(status, "failed"),
        "exit_status": status,
        "message": str(error),
        "bound": error.bound if isinstance(error, NoPlanError) else None,
        "diagnostics": [as_dict(d) for d in mistakes],
    }
    answer(end | more)
