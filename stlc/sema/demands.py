"""What a mission demands and what it would like: `require`, `prefer` and `margin`."""

from __future__ import annotations

from stlc.ir.requirement import Requirement
from stlc.mission import ObjectiveTerm, TermKind
from stlc.preferences import Preference
from stlc.sema import quotas
from stlc.sema.durations import durations
from stlc.sema.joints import joined
from stlc.sema.name_errors import Redeclared
from stlc.sema.objective_errors import BadPreference
from stlc.sema.preferences import parted, preference
from stlc.sema.report import Mistake, Report, with_note
from stlc.sema.scope import Scope
from stlc.sema.shapes import Shaper
from stlc.sema.statements import of, single
from stlc.sema.time_errors import BadStep
from stlc.sema.values import Env
from stlc.syntax import ast


def carried_on(
    statements: list[ast.Statement],
    requirements: list[Requirement],
    wishes: list[Preference],
    steps: int,
    shaper: Shaper,
) -> tuple[list[Requirement], list[Preference]]:
    """Requirements and preferences once more, with obstacles that move for ever carried on to the
    horizon."""
    scope = shaper.scope
    moving = [s for s in of(statements, ast.ObstacleDecl) if s.velocity is not None]
    if not moving or scope.report.errors:
        return requirements, wishes
    scope.last_step, scope.placed = steps, 0
    with scope.report.guard():
        quotas.check_all(moving, scope)
        for statement in moving:
            shaper.obstacle(statement)
    if scope.report.errors:
        return requirements, wishes
    report, scope.report = scope.report, Report()  # warnings were reported the first time
    scope.memo.clear()
    scope.requirements.clear()
    again = required(statements, scope)
    wishes = preferred(statements, scope)
    for error in scope.report.errors:
        report.add(error)
    scope.report = report
    return again, wishes


def preferred(statements: list[ast.Statement], scope: Scope) -> list[Preference]:
    """Every `prefer`; requirements and preferences have one set of names."""
    margin = next((s for s in statements if isinstance(s, ast.Margin)), None)
    least = 0.0
    if margin is not None:
        with Report().guard():  # what is wrong with it was told of the requirements
            least = scope.constant(margin.value).constant
    taken = {name: None for name in scope.requirements}
    found: list[Preference] = []
    for number, item in enumerate(of(statements, ast.Prefer), start=1):
        name = item.name.text if item.name else _free_name(f"preference{number}", set(taken))
        if name in taken and item.name is not None:
            scope.report.add(Redeclared(span=item.name.span, name=name))
        taken[name] = None
        with scope.report.guard():
            found.append(preference(item, name, least, scope))
    return found


def together(requirements: list[Requirement], wishes: list[Preference]) -> list[Requirement]:
    """All that has to be judged within the horizon."""
    return [*requirements, *(Requirement(w.name, w.formula, span=w.span) for w in wishes)]


def finished(
    wishes: list[Preference],
    terms: list[ObjectiveTerm],
    requirements: list[Requirement],
    steps: int,
    scope: Scope,
) -> list[Preference]:
    """Preferences, and times that cost, with their parts, once the mission is known to be sound so
    far; whether the objective may stand beside them."""
    found = []
    for wish in [] if scope.report.errors else [*wishes, *durations(requirements, scope)]:
        with scope.report.guard():
            found.append(parted(wish, steps, scope.step))
    _check_beside(terms, wishes, scope.report)
    return found


def _check_beside(terms: list[ObjectiveTerm], wishes: list[Preference], report: Report) -> None:
    """Preferences are no part of the mission's robustness: it has to name its requirement."""
    for term in terms if wishes else ():
        if term.kind is TermKind.ROBUSTNESS and term.requirement is None:
            problem = "the robustness of everything beside what is only preferred"
            hint = "name the requirement: `maximize robustness(name)`"
            report.add(BadPreference(span=term.span, problem=problem, hint=hint))


def required(statements: list[ast.Statement], scope: Scope) -> list[Requirement]:
    """All that can be read, under their own names or the next free `requirementN`."""
    margin = 0.0
    statement = single(statements, ast.Margin, scope.report)
    if statement is not None:
        with scope.report.guard():
            margin = _margin(statement.value, scope)
    found: dict[str, Requirement] = {}
    taken = {s.name.text for s in of(statements, ast.Require) if s.name}
    for number, item in enumerate(of(statements, ast.Require), start=1):
        name = item.name.text if item.name else _free_name(f"requirement{number}", taken)
        if name in found and item.name is not None:
            diagnostic = Redeclared(span=item.name.span, name=name)
            scope.report.add(with_note(diagnostic, "declared here before", found[name].span))
        scope.requirements.append(name)
        with scope.report.guard():
            found[name] = _requirement(item, name, margin, scope)
    return joined(list(found.values()), scope)


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
