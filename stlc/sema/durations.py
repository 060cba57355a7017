"""`time(reach)`: the first time at which a formula holds, as a cost.

It is what a preference measured by `late` violates: the deadlines that pass before the formula
holds, counted in steps' lengths from the first that there could be.
"""

from __future__ import annotations

from dataclasses import replace

from stlc.ir.nodes import Eventually, Node, Until
from stlc.ir.requirement import Requirement
from stlc.mission import ObjectiveTerm, TermKind
from stlc.preferences import Measure, Preference
from stlc.sema.objective_errors import BadObjective
from stlc.sema.report import Mistake
from stlc.sema.scope import Scope
from stlc.sema.values import Env
from stlc.syntax import ast


def duration(
    expr: ast.Expr, args: tuple[ast.Expr, ...], weight: float, env: Env, scope: Scope
) -> ObjectiveTerm:
    """The term of `time(..)` of a requirement with a deadline, or of a formula. Raises Mistake."""
    if len(args) != 1:
        hint = "write `minimize time(reach)`, or `time(r1 in dock)`"
        raise Mistake(BadObjective(span=expr.span, problem="time is of one thing", hint=hint))
    name = " ".join(expr.span.text.split())
    if not _is_requirement(args[0], scope):
        scope.formula(args[0], env)  # for its mistakes
    scope.times[name] = (args[0], env)
    return ObjectiveTerm(TermKind.VIOLATION, weight, requirement=name, span=expr.span)


def durations(requirements: list[Requirement], scope: Scope) -> list[Preference]:
    """What the objective's times are measured by, parts not yet known; mistakes are reported."""
    found = []
    for name, (expr, env) in scope.times.items():
        with scope.report.guard():
            formula, margin = _meant(expr, env, requirements, scope)
            found.append(
                Preference(
                    name, formula, 0.0, measure=Measure.LATE, margin=margin, unit="s",
                    cost=True, span=expr.span,
                )
            )  # fmt: skip
    return found


def _is_requirement(expr: ast.Expr, scope: Scope) -> bool:
    return isinstance(expr, ast.Name) and expr.text in scope.requirements


def _meant(
    expr: ast.Expr, env: Env, requirements: list[Requirement], scope: Scope
) -> tuple[Node, float]:
    """What has to hold by the first deadline there could be, and its margin."""
    if not _is_requirement(expr, scope):
        return Eventually(scope.formula(expr, env), 0, 0, span=expr.span), env.margin
    assert isinstance(expr, ast.Name)
    named = next((r for r in requirements if r.name == expr.text), None)
    formula = None if named is None else named.formula
    if named is not None and isinstance(formula, Eventually | Until):
        return replace(formula, end=formula.start), named.margin
    problem = f"`{expr.text}` holds over time, not from one time on"
    hint = "name a requirement with `eventually` or `until`, or a formula: `time(r1 in dock)`"
    raise Mistake(BadObjective(span=expr.span, problem=problem, hint=hint))
