"""Signals that are known beforehand: `signal price from "prices.csv"`.

A comparison that such a signal stands in is evaluated once for each step, with the signal's value
at that step as a number: what comes of it is a formula that changes with the clock (`Timed`). So a
product with a known signal is linear, and nothing after semantic analysis meets the signal.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace

import numpy as np

from stlc.errors import UsageError
from stlc.ir.nodes import Node, Timed
from stlc.mission import Array
from stlc.recording import read_recording
from stlc.sema.files import Files
from stlc.sema.horizon import Reach
from stlc.sema.name_errors import CannotRead, NotHere
from stlc.sema.report import Mistake, Report, Reported
from stlc.sema.scope import Scope
from stlc.sema.time_errors import SignalEnds
from stlc.sema.units import parse_unit
from stlc.sema.values import Env, Scalar
from stlc.source import Span
from stlc.syntax import ast

MOST_CASES = 20_000
"""Steps over which one comparison is written out."""


class ByTheClock(Mistake):
    """What is evaluated depends on the step; a mistake where there is none."""


@dataclass(frozen=True, slots=True)
class Need:
    """A comparison that is known at `steps` steps only and looks `ahead` on top of them."""

    steps: int
    ahead: int
    span: Span


def read_signals(statement: ast.SignalDecl, scope: Scope, files: Files) -> None:
    """Read the values of known signals, in SI units. Raises Mistake."""
    try:
        scope.series.update(_read(statement, scope, files))
    except (Mistake, Reported):
        scope.broken.update(name.text for name in statement.names)
        raise


def _read(statement: ast.SignalDecl, scope: Scope, files: Files) -> Iterator[tuple[str, Array]]:
    """Each signal's name and values (N,), from step 0 on."""
    assert statement.file is not None
    name, span = statement.file.value, statement.file.span
    path = files.path(name, span)
    try:
        table = read_recording(path, scope.step)
        values = {n.text: table.columns[n.text] for n in statement.names}
    except KeyError as error:
        listed = ", ".join(c for c in table.columns if c not in ("time", "t"))
        reason = f"it has no column {error.args[0]!r}; columns: {listed or 'none'}"
        raise Mistake(CannotRead(span=span, path=name, reason=reason)) from None
    except UsageError as error:
        reason = str(error).removeprefix(f"{path}: ").replace(str(path), name)
        raise Mistake(CannotRead(span=span, path=name, reason=reason)) from None
    if abs(table.times[0]) > 1e-9 * scope.step:
        reason = f"it begins at {table.times[0]:g} s; a known signal begins at 0 s"
        raise Mistake(CannotRead(span=span, path=name, reason=reason))
    scaled = None if statement.unit is None else parse_unit(statement.unit.strip("[] "))
    for key, column in values.items():
        inside = column if scaled is None else column * scaled.scale + scaled.offset
        yield key, np.asarray(inside, dtype=np.float64)


def known_signal(expr: ast.Name, env: Env, scope: Scope) -> Scalar:
    """The value of a known signal at the clock's step."""
    values = scope.series[expr.text]
    if env.clock is None:
        problem = f"`{expr.text}` changes from step to step"
        hint = "use it in a comparison, or in `total(..)` of the objective"
        raise ByTheClock(NotHere(span=expr.span, problem=problem, hint=hint))
    if env.clock >= len(values):
        raise EndOfSignal(_ends(expr.span, len(values), env.clock))
    return Scalar(float(values[env.clock]), unit=scope.signals.get(expr.text))


class EndOfSignal(Mistake):
    """A known signal is asked for after its end."""


def _ends(span: Span, count: int, needed: int) -> SignalEnds:
    return SignalEnds(span=span, last=count - 1, needed=needed)


def timed(span: Span, env: Env, scope: Scope, at: Callable[[Env], Node]) -> Node:
    """The formula `at(env)` where it changes with the clock, as far as the signals are known."""
    last = min(scope.given_horizon or MOST_CASES, MOST_CASES)
    cases: list[Node] = []
    for step in range(last + 1):
        try:
            cases.append(at(replace(env, clock=step)))
        except EndOfSignal:
            if not cases:
                raise
            break
    reach = Reach()
    ahead = max(reach.of(case) for case in cases)
    scope.needs.append(Need(len(cases), ahead, span))
    return Timed(tuple(cases), span=span)


def check_known(horizon: int, scope: Scope, report: Report) -> None:
    """Report comparisons whose signals end before the mission does."""
    for need in scope.needs:
        last = horizon - need.ahead
        if need.steps <= last:
            report.add(_ends(need.span, need.steps, last))
