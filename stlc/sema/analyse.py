"""From syntax to a checked mission: declarations in the order they need one another."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Mapping
from dataclasses import replace
from typing import TypeVar

from stlc.errors import MissionError
from stlc.loader import Loader, MemoryLoader
from stlc.mission import Mission, ObjectiveTerm
from stlc.sema import (
    agents,
    channels,
    checks,
    clock,
    demands,
    horizon,
    imports,
    objective,
    preferences,
    props,
)
from stlc.sema.costs import is_cost
from stlc.sema.durations import durations
from stlc.sema.expressions import evaluate
from stlc.sema.files import Files
from stlc.sema.name_errors import Redeclared
from stlc.sema.overrides import overrides
from stlc.sema.report import Mistake, Report, with_note
from stlc.sema.scope import Scope
from stlc.sema.shapes import Shaper
from stlc.sema.signals import ByTheClock, check_known, read_signals
from stlc.sema.statements import of, single
from stlc.sema.stations import station
from stlc.sema.time_errors import BadStep
from stlc.sema.tubes import check_tubes
from stlc.sema.unit_errors import UnknownUnit
from stlc.sema.units import SECOND, UnknownUnitName, parse_unit
from stlc.sema.values import Env
from stlc.sema.walls import declare_wall
from stlc.sema.workspace import declare_workspace, holds_between
from stlc.syntax import ast

SHORTEST_STEP, LONGEST_STEP = 1e-12, 1e9  # s; beyond them its square is lost or overflows

S = TypeVar("S", bound=ast.Statement)

Named = (
    ast.Param | ast.DynamicsDecl | ast.AgentDecl | ast.StationDecl | ast.RegionDecl
    | ast.ObstacleDecl | ast.ChannelDecl | ast.WallDecl | ast.Let
)  # fmt: skip


def analyse(
    file: ast.File,
    *,
    params: Mapping[str, str | float] | None = None,
    loader: Loader | None = None,
    report: Report | None = None,
) -> Mission:
    """The checked mission. Raises MissionError with every mistake; warnings stay in the mission.

    `params` override `param` declarations (in their units). `report` may hold diagnostics of the
    parser already; they are raised together with those found here.
    """
    report = report or Report()
    files = Files(loader or MemoryLoader())
    scope = Scope(report, evaluate)
    statements = imports.statements(file, files, report)
    _declare_names(statements, scope)
    if report.errors:
        scope.broken.update(_unread_names(file.source.text, scope))
    scope.overrides = overrides(params or {}, scope.declarations, report)
    mission = _build(file, statements, scope, files)
    if report.errors:
        raise MissionError(report.errors)
    return replace(mission, params={name: str(value) for name, value in (params or {}).items()})


def _each(items: Iterable[S], declare: Callable[[S], object], report: Report) -> None:
    for item in items:
        with report.guard():
            declare(item)


def _build(file: ast.File, statements: list[ast.Statement], scope: Scope, files: Files) -> Mission:
    """The mission: step, places, agents, radio, then the formulas that refer to them.

    Mistakes of one statement are reported and the next is read. The horizon comes last: it follows
    from the formulas.
    """
    report, shaper = scope.report, Shaper(scope, files)
    _numbers(statements, scope, files)
    space = single(statements, ast.Workspace, report)
    declare_workspace(space, file.source.text, shaper)
    _declare_all(statements, shaper, files)
    _unused_lets(of(statements, ast.Let), scope)
    given = scope.given_horizon = _horizon(single(statements, ast.Horizon, report), scope)
    requirements = demands.required(statements, scope)
    wishes = demands.preferred(statements, scope)
    terms = _objective(of(statements, ast.Objective), scope)
    moves = None if report.errors else next((a.span for a in scope.agents.values()), None)
    formulas = demands.together(requirements, [*wishes, *durations(requirements, scope)])
    steps = horizon.derive(formulas, given, objective.last_step(terms), moves, report)
    requirements, wishes = demands.carried_on(statements, requirements, wishes, steps, shaper)
    check_known(steps, scope, report)
    swept = holds_between(space, formulas, scope)
    check_tubes((f.formula for f in formulas), scope)
    wishes = demands.finished(wishes, terms, requirements, steps, scope)
    mission = Mission(
        source=file.source, step=scope.step, horizon=steps, workspace=scope.workspace,
        agents=scope.agents, stations=scope.stations, regions=scope.regions,
        obstacles=scope.obstacles, channels=scope.channels, requirements=tuple(requirements),
        objective=(
            *objective.finish(terms, tuple(requirements), steps, scope),
            *preferences.terms(wishes, None),
        ),
        sense=objective.sense(of(statements, ast.Objective)),
        signals=tuple(name for name in scope.signals if name not in scope.series),
        workspace_swept=swept, workspace_levels=scope.space_levels, preferences=tuple(wishes),
        walls=scope.walls,
    )  # fmt: skip
    return checks.checked(mission, scope)


def _numbers(statements: list[ast.Statement], scope: Scope, files: Files) -> None:
    """The step, signals that are known beforehand, and parameters."""
    _step(single(statements, ast.Step, scope.report), scope)
    known = [s for s in of(statements, ast.SignalDecl) if s.file is not None]
    _each(known, lambda s: read_signals(s, scope, files), scope.report)
    _each(of(statements, ast.Param), lambda s: scope.value(s.value), scope.report)


def _declare_all(statements: list[ast.Statement], shaper: Shaper, files: Files) -> None:
    """Places first, then agents, then channels, which may speak of all of them."""
    scope, report = shaper.scope, shaper.scope.report
    _each(_first(statements, ast.RegionDecl, scope), shaper.region, report)
    _each(_first(statements, ast.ObstacleDecl, scope), shaper.obstacle, report)
    _each(_first(statements, ast.WallDecl, scope), lambda s: declare_wall(s, shaper), report)
    first = _first(statements, ast.DynamicsDecl, scope)
    _each(first, lambda s: agents.declare_dynamics(s, scope, files), report)
    _each(_first(statements, ast.AgentDecl, scope), lambda s: agents.declare(s, scope), report)
    _each(_first(statements, ast.StationDecl, scope), lambda s: station(s, shaper), report)
    radios = _first(statements, ast.ChannelDecl, scope)
    _each(radios, lambda s: channels.declare(s, scope, files), report)


# --- names -------------------------------------------------------------------------------------


def _declare_names(statements: list[ast.Statement], scope: Scope) -> None:
    for statement in statements:
        if isinstance(statement, ast.SignalDecl):
            for name in statement.names:
                _declare(name, statement, scope)
            with scope.report.guard():
                _signal_units(statement, scope)
        elif isinstance(statement, Named):
            _declare(statement.name, statement, scope)


_DECLARES = re.compile(
    r"^[ \t]*(?:param|dynamics|agent|station|region|obstacle|wall|(channel)|let|signal)\s+(\w+)",
    re.M,
)


def _unread_names(text: str, scope: Scope) -> set[str]:
    """Names whose declaration has a syntax error: using them is no further mistake.

    `channel` is among them if a channel is, since a mission's only channel need not be named.
    """
    unread = [m for m in _DECLARES.finditer(text) if m[2] not in scope.declarations]
    return {word for match in unread for word in match.groups() if word}


def _declare(name: ast.Ident, statement: ast.Statement, scope: Scope) -> None:
    known = scope.declarations.get(name.text)
    if known is None:
        scope.declarations[name.text] = statement
        return
    diagnostic = Redeclared(span=name.span, name=name.text)
    scope.report.add(with_note(diagnostic, "declared here before", known.span))


def _signal_units(statement: ast.SignalDecl, scope: Scope) -> None:
    unit = None
    if statement.unit:
        try:
            unit = parse_unit(statement.unit.strip("[] ")).unit
        except UnknownUnitName as error:
            hint = "known: m, s, kg, N, Hz, rad, dB, dBm, .."
            raise Mistake(UnknownUnit(span=statement.span, unit=error.name, hint=hint)) from None
    for name in statement.names:
        scope.signals.setdefault(name.text, unit)


def _first(statements: list[ast.Statement], kind: type[S], scope: Scope) -> list[S]:
    """The declarations of a kind, without those whose name was taken before."""
    declared = set(map(id, scope.declarations.values()))
    return [s for s in of(statements, kind) if id(s) in declared]


# --- single statements -------------------------------------------------------------------------


def _step(statement: ast.Step | None, scope: Scope) -> None:
    """The sampling time [s], or the default."""
    if statement is None:
        return
    with scope.report.guard():
        value = scope.number(statement.duration, SECOND)
        if not SHORTEST_STEP <= value <= LONGEST_STEP:
            expected = "above 0 s" if value <= 0 else "between 1e-12 s and 1e9 s"
            raise Mistake(
                BadStep(span=statement.span, name="step", expected=expected, usage="step 1 s")
            )
        scope.step = value


def _horizon(statement: ast.Horizon | None, scope: Scope) -> int | None:
    """The steps that the file asks for; one where they can't be read, for what follows to go on."""
    if statement is None:
        return None
    with scope.report.guard():
        count = clock.steps(statement.length, scope)
        if count >= 1:
            return count
        expected = "at least one step"
        scope.report.add(
            BadStep(span=statement.span, name="horizon", expected=expected, usage="horizon 20")
        )
    return 1


def _unused_lets(lets: list[ast.Let], scope: Scope) -> None:
    """A plain `let` is evaluated even if nobody uses it, so that its mistakes are found; no
    parameter of any stands twice."""
    for let in lets:
        with scope.report.guard():
            props.distinct(let.parameters)
        if let.parameters or let.name.text in scope.memo:
            continue
        if not is_cost(let.body, Env({}), scope):
            with scope.report.guard():
                used = set(scope.used)
                _try(let.body, scope)
                scope.used = used


def _try(body: ast.Expr, scope: Scope) -> None:
    """Evaluate for its mistakes; known signals have some value."""
    try:
        scope.value(body)
    except ByTheClock:
        scope.value(body, Env({}, clock=0))


# --- objective ---------------------------------------------------------------------------------


def _objective(statements: list[ast.Objective], scope: Scope) -> list[ObjectiveTerm]:
    terms: list[ObjectiveTerm] = []
    for statement in statements:
        with scope.report.guard():
            terms.extend(objective.objective(statement, scope))
    return terms
