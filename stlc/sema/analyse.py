"""From syntax to a checked mission: declarations in the order they need one another."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Mapping
from dataclasses import replace
from typing import TypeVar

from stlc.errors import MissionError
from stlc.ir.requirement import Requirement
from stlc.loader import Loader, MemoryLoader
from stlc.mission import Mission, ObjectiveTerm
from stlc.sema import agents, channels, checks, clock, horizon, imports, objective
from stlc.sema.costs import is_cost
from stlc.sema.expressions import evaluate
from stlc.sema.files import Files
from stlc.sema.joints import joined
from stlc.sema.name_errors import NotHere, Redeclared
from stlc.sema.overrides import overrides
from stlc.sema.report import Mistake, Report, with_note
from stlc.sema.scope import Scope
from stlc.sema.shapes import Shaper
from stlc.sema.time_errors import BadStep
from stlc.sema.unit_errors import UnknownUnit
from stlc.sema.units import SECOND, UnknownUnitName, parse_unit
from stlc.sema.values import Env
from stlc.sema.workspace import declare_workspace, holds_between
from stlc.syntax import ast

SHORTEST_STEP, LONGEST_STEP = 1e-12, 1e9  # s; beyond them its square is lost or overflows

S = TypeVar("S", bound=ast.Statement)

Named = (
    ast.Param | ast.DynamicsDecl | ast.AgentDecl | ast.StationDecl | ast.RegionDecl
    | ast.ObstacleDecl | ast.ChannelDecl | ast.Let
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


def _of(statements: Iterable[ast.Statement], kind: type[S]) -> list[S]:
    return [s for s in statements if isinstance(s, kind)]


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
    _step(_single(statements, ast.Step, report), scope)
    _each(_of(statements, ast.Param), lambda s: scope.value(s.value), report)
    space = _single(statements, ast.Workspace, report)
    declare_workspace(space, file.source.text, shaper)
    _each(_first(statements, ast.RegionDecl, scope), shaper.region, report)
    _each(_first(statements, ast.ObstacleDecl, scope), shaper.obstacle, report)
    first = _first(statements, ast.DynamicsDecl, scope)
    _each(first, lambda s: agents.declare_dynamics(s, scope), report)
    _each(_first(statements, ast.AgentDecl, scope), lambda s: agents.declare(s, scope), report)
    _each(_first(statements, ast.StationDecl, scope), lambda s: agents.station(s, shaper), report)
    radios = _first(statements, ast.ChannelDecl, scope)
    _each(radios, lambda s: channels.declare(s, scope, files), report)
    _unused_lets(_of(statements, ast.Let), scope)
    requirements = joined(_requirements(statements, scope), scope)
    terms = _objective(_of(statements, ast.Objective), scope)
    given = _horizon(_single(statements, ast.Horizon, report), scope)
    moves = None if report.errors else next((a.span for a in scope.agents.values()), None)
    steps = horizon.derive(requirements, given, objective.last_step(terms), moves, report)
    requirements = _carried_on(statements, requirements, steps, shaper)
    swept = holds_between(space, requirements, scope)
    mission = Mission(
        source=file.source, step=scope.step, horizon=steps, workspace=scope.workspace,
        agents=scope.agents, stations=scope.stations, regions=scope.regions,
        obstacles=scope.obstacles, channels=scope.channels, requirements=tuple(requirements),
        objective=objective.finish(terms, tuple(requirements), steps, report),
        sense=objective.sense(_of(statements, ast.Objective)), signals=tuple(scope.signals),
        workspace_swept=swept,
    )  # fmt: skip
    return checks.checked(mission, scope)


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
    r"^[ \t]*(?:param|dynamics|agent|station|region|obstacle|(channel)|let|signal)\s+(\w+)", re.M
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
    return [s for s in _of(statements, kind) if id(s) in declared]


def _single(statements: list[ast.Statement], kind: type[S], report: Report) -> S | None:
    found = _of(statements, kind)
    for again in found[1:]:
        what = kind.__name__.lower()
        problem, hint = f"`{what}` stands twice", "keep one of the two"
        report.add(NotHere(span=again.span, problem=problem, hint=hint))
    return found[0] if found else None


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
    """A plain `let` is evaluated even if nobody uses it, so that its mistakes are found."""
    for let in lets:
        if let.parameters or let.name.text in scope.memo:
            continue
        if not is_cost(let.body, Env({}), scope):
            with scope.report.guard():
                used = set(scope.used)
                scope.value(let.body)
                scope.used = used


# --- requirements ------------------------------------------------------------------------------


def _carried_on(
    statements: list[ast.Statement],
    requirements: list[Requirement],
    steps: int,
    shaper: Shaper,
) -> list[Requirement]:
    """The requirements once more, with obstacles that move for ever carried on to the horizon."""
    scope = shaper.scope
    moving = [s for s in _of(statements, ast.ObstacleDecl) if s.velocity is not None]
    if not moving or scope.report.errors:
        return requirements
    scope.last_step, scope.placed = steps, 0
    for statement in moving:
        with scope.report.guard():
            shaper.obstacle(statement)
    report, scope.report = scope.report, Report()  # all was reported the first time
    scope.memo.clear()
    scope.requirements.clear()
    again = joined(_requirements(statements, scope), scope)
    scope.report = report
    return again


def _requirements(statements: list[ast.Statement], scope: Scope) -> list[Requirement]:
    """All that can be read, under their own names or the next free `requirementN`."""
    margin = 0.0
    statement = _single(statements, ast.Margin, scope.report)
    if statement is not None:
        with scope.report.guard():
            margin = _margin(statement.value, scope)
    found: dict[str, Requirement] = {}
    taken = {s.name.text for s in _of(statements, ast.Require) if s.name}
    for number, item in enumerate(_of(statements, ast.Require), start=1):
        name = item.name.text if item.name else _free_name(f"requirement{number}", taken)
        if name in found and item.name is not None:
            diagnostic = Redeclared(span=item.name.span, name=name)
            scope.report.add(with_note(diagnostic, "declared here before", found[name].span))
        scope.requirements.append(name)
        with scope.report.guard():
            found[name] = _requirement(item, name, margin, scope)
    return list(found.values())


def _free_name(name: str, taken: set[str]) -> str:
    """The name, lengthened until no requirement has it."""
    while name in taken:
        name += "_"
    return name


def _margin(expr: ast.Expr, scope: Scope) -> float:
    value = scope.constant(expr).constant
    if value < 0:
        expected = "0 or more"
        raise Mistake(BadStep(span=expr.span, name="margin", expected=expected, usage="margin 0.1"))
    return value


def _requirement(statement: ast.Require, name: str, margin: float, scope: Scope) -> Requirement:
    own = margin if statement.margin is None else _margin(statement.margin, scope)
    formula = scope.formula(statement.formula, Env({}, margin=own))
    return Requirement(name, formula, own, statement.span)


def _objective(statements: list[ast.Objective], scope: Scope) -> list[ObjectiveTerm]:
    terms: list[ObjectiveTerm] = []
    for statement in statements:
        with scope.report.guard():
            terms.extend(objective.objective(statement, scope))
    return terms
