"""The objective: a weighted sum of efforts, link costs and robustness, all to be minimised.

The sense that a person meant is kept beside it: reports go its way.
"""

from __future__ import annotations

from collections.abc import Sequence

from stlc.ir.networks import Network
from stlc.ir.nodes import walk
from stlc.ir.requirement import Requirement
from stlc.mission import ObjectiveTerm, TermKind
from stlc.sema.costs import cost_term, is_cost
from stlc.sema.name_errors import NotHere
from stlc.sema.objective_errors import (
    BadObjective,
    EndToEndRobustness,
    MixedRobustness,
    NegativeWeight,
    NoTime,
)
from stlc.sema.quantifiers import assignments, bound_with
from stlc.sema.report import Mistake, Report
from stlc.sema.robust_units import units_in
from stlc.sema.scope import EMPTY, Scope
from stlc.sema.totals import total_over
from stlc.sema.values import Env
from stlc.sense import Sense
from stlc.syntax import ast


def objective(statement: ast.Objective, scope: Scope) -> list[ObjectiveTerm]:
    """Terms of one `minimize` or `maximize`. Raises Mistake."""
    sign = 1.0 if statement.sense == "minimize" else -1.0
    terms: list[ObjectiveTerm] = []
    _collect(statement.expression, sign, EMPTY, scope, terms)
    return [t for t in terms if t.weight != 0.0]


def sense(statements: Sequence[ast.Objective]) -> Sense:
    """MAXIMIZE where every statement does; where both stand, their sum is minimised."""
    maximised = [statement.sense == "maximize" for statement in statements]
    return Sense.MAXIMIZE if maximised and all(maximised) else Sense.MINIMIZE


def _collect(
    expr: ast.Expr, weight: float, env: Env, scope: Scope, terms: list[ObjectiveTerm]
) -> None:
    """Appends the terms of an expression, weights multiplied out, lets and sums expanded."""
    first, added = _summands(expr)
    if added:
        _collect(first, weight, env, scope, terms)
        for link in added:
            sign = 1.0 if link.operator == "+" else -1.0
            _collect(link.right, sign * weight, env, scope, terms)
        return
    expr, weight = _factored(expr, weight, env, scope)
    match expr:
        case ast.Arithmetic(operator="+" | "-"):
            _collect(expr, weight, env, scope, terms)
        case ast.Negate(arg=arg):
            _collect(arg, -weight, env, scope, terms)
        case ast.Quantifier(kind="sum"):
            for bound in assignments(expr, env, scope):
                _collect(expr.body, weight, bound_with(env, bound), scope, terms)
        case ast.Name() if _is_let(expr, env, scope):
            let = scope.lookup(expr.text, expr.span)
            assert isinstance(let, ast.Let)
            with scope.expanding(expr.text, expr.span):
                _collect(let.body, weight, EMPTY, scope, terms)
        case _:
            terms.append(_checked(cost_term(expr, weight, env, scope), expr))


def _summands(expr: ast.Expr) -> tuple[ast.Expr, list[ast.Arithmetic]]:
    """The first summand of a flat sum, and what is added to it and subtracted, in order."""
    added: list[ast.Arithmetic] = []
    while isinstance(expr, ast.Arithmetic) and expr.operator in ("+", "-"):
        added.append(expr)
        expr = expr.left
    return expr, added[::-1]


def _factored(expr: ast.Expr, weight: float, env: Env, scope: Scope) -> tuple[ast.Expr, float]:
    """The cost of a flat product, and the weight with its factors."""
    while isinstance(expr, ast.Arithmetic) and expr.operator in ("*", "/"):
        left, right = expr.left, expr.right
        if expr.operator == "*":
            expr, factor = (left, right) if is_cost(left, env, scope) else (right, left)
            weight *= _factor(factor, env, scope)
            continue
        divisor = _factor(right, env, scope)
        if divisor == 0.0:
            raise Mistake(BadObjective(span=right.span, problem="a cost is divided by zero"))
        expr, weight = left, weight / divisor
    return expr, weight


def _is_let(expr: ast.Name, env: Env, scope: Scope) -> bool:
    found = None if expr.text in env.bound else scope.declarations.get(expr.text)
    return isinstance(found, ast.Let) and not found.parameters


def _factor(expr: ast.Expr, env: Env, scope: Scope) -> float:
    """A weight: a plain number."""
    if is_cost(expr, env, scope):
        raise Mistake(BadObjective(span=expr.span, problem="two costs are multiplied"))
    return scope.constant(expr, env).constant


def _checked(term: ObjectiveTerm, expr: ast.Expr) -> ObjectiveTerm:
    what = term.kind.value.replace("_", " ")
    if term.kind is TermKind.ROBUSTNESS and term.weight > 0:
        hint = "write `maximize robustness`, or `- 0.5 * robustness` in a `minimize`"
        raise Mistake(_wrong_way(expr, what, "minimised", term.weight, hint))
    if term.kind not in (TermKind.ROBUSTNESS, TermKind.TOTAL) and term.weight < 0:
        hint = "costs have positive weights in `minimize`, negative ones in `maximize`"
        raise Mistake(_wrong_way(expr, what, "maximised", -term.weight, hint))
    return term


def _wrong_way(
    expr: ast.Expr, what: str, direction: str, weight: float, hint: str
) -> NegativeWeight:
    return NegativeWeight(span=expr.span, what=what, direction=direction, weight=weight, hint=hint)


def finish(
    terms: list[ObjectiveTerm],
    requirements: tuple[Requirement, ...],
    horizon: int,
    scope: Scope,
) -> tuple[ObjectiveTerm, ...]:
    """Check what depends on the requirements and the horizon; totals are written out."""
    report, finished = scope.report, []
    for term in terms:
        if term.window is not None and term.window[1] > horizon:
            start, end = term.window
            report.add(NoTime(span=term.span, start=start, end=end, horizon=horizon))
        if term.kind is TermKind.ROBUSTNESS:
            _check_units(term, requirements, report)
        if term.kind is TermKind.TOTAL:
            with report.guard():
                term = total_over(term, horizon, scope)
        finished.append(term)
    return tuple(finished)


def _check_units(
    term: ObjectiveTerm, requirements: tuple[Requirement, ...], report: Report
) -> None:
    """Robustness in several units (metres, dB) is compared only with a scale for each of them."""
    chosen = [r for r in requirements if term.requirement in (None, r.name)]
    if not chosen:
        hint = "add a `require`, or leave robustness out"
        problem = "there is no requirement whose robustness could be maximised"
        report.add(NotHere(span=term.span, problem=problem, hint=hint))
    for requirement in chosen:
        if any(isinstance(n, Network) and n.composed for n in walk(requirement.formula)):
            report.add(EndToEndRobustness(span=term.span, name=requirement.name))
            return
    found = sorted(units_in([r.formula for r in chosen]))
    lacking = [u for u in found if u not in term.scales]
    if len(found) > 1 and lacking:
        names = [u or "pure numbers" for u in found]
        usage = ", ".join(f"1 {u}".strip() for u in found)
        report.add(MixedRobustness(span=term.span, units=" and ".join(names), usage=usage))


def last_step(terms: list[ObjectiveTerm]) -> int:
    """The furthest step that a window names."""
    return max((t.window[1] for t in terms if t.window is not None), default=0)
