"""`total(price * t.pump + |t.level - 2 m|)`: what an expression adds up to over the steps.

It is summed over the steps at which it can be judged, 0 to T, or T - 1 where an input stands in it.
Known signals have their values at each step, so that prices times inputs are linear.
"""

from __future__ import annotations

from dataclasses import replace

from stlc.charges import Charge, Form
from stlc.ir.signals import Role, Signal
from stlc.mission import ObjectiveTerm, TermKind
from stlc.sema import scalars
from stlc.sema.objective_errors import BadObjective
from stlc.sema.report import Mistake
from stlc.sema.scope import Scope
from stlc.sema.values import Env, Fold, FoldKind, Scalar
from stlc.source import Span
from stlc.syntax import ast


def total(
    expr: ast.Expr, args: tuple[ast.Expr, ...], weight: float, env: Env, scope: Scope
) -> ObjectiveTerm:
    """The term of a total, its steps not yet known. Raises Mistake."""
    if len(args) != 1:
        hint = "write `minimize total(price * t.pump)`"
        raise Mistake(BadObjective(span=expr.span, problem="a total is of one thing", hint=hint))
    name = f"{expr.span.text.strip()}#{len(scope.totals)}"
    scope.totals[name] = (args[0], env)
    scope.scalar(args[0], replace(env, clock=0))  # for its mistakes
    return ObjectiveTerm(TermKind.TOTAL, weight, requirement=name, span=expr.span)


def total_over(term: ObjectiveTerm, horizon: int, scope: Scope) -> ObjectiveTerm:
    """The term with what each step costs. Raises Mistake where that is no convex cost."""
    assert term.requirement is not None
    expr, env = scope.totals[term.requirement]
    first, last = term.window or (0, horizon)
    charges = []
    for step in range(first, min(last, horizon) + 1):
        value = scope.scalar(expr, replace(env, clock=step))
        if step + _ahead(value) > horizon:
            break
        charges.append(_charge(value, step, term.weight, expr.span))
    if not charges:
        problem = "this can be judged at no step of its window"
        raise Mistake(BadObjective(span=expr.span, problem=problem))
    name = " ".join(term.requirement.rsplit("#", 1)[0].split())
    return replace(term, requirement=name, charges=tuple(charges))


def _ahead(value: Scalar) -> int:
    """Steps after the present one that a value looks at."""
    own = [a.shift + (isinstance(a, Signal) and a.role is Role.INPUT) for a, _ in value.terms]
    return max([0, *own, *(_ahead(arg) for fold, _ in value.folds for arg in fold.args)])


def _charge(value: Scalar, step: int, weight: float, span: Span) -> Charge:
    """A step's cost; raises Mistake where the solver could not take it for a linear one."""
    peaks = tuple(_peak(fold, factor, step, weight, span) for fold, factor in value.folds)
    return Charge(step, _form(value, step, span), peaks)


def _peak(
    fold: Fold, factor: float, step: int, weight: float, span: Span
) -> tuple[float, tuple[Form, ...]]:
    """A factor times the largest of some forms: min(x, y) = -max(-x, -y)."""
    sign = 1.0 if fold.kind is FoldKind.MAX else -1.0
    args = [scalars.scale(arg, sign, arg.unit) for arg in fold.args]
    if any(arg.folds for arg in args):
        problem = "a cost has no `max`, `min` or `abs` within another"
        raise Mistake(BadObjective(span=span, problem=problem, hint="add them up instead"))
    if sign * factor * weight < 0.0:
        what = "minimised" if weight > 0 else "maximised"
        problem = f"this is not convex: `abs` and `max` can't be {what} with this sign"
        hint = "absolute deviations are made small, not large"
        raise Mistake(BadObjective(span=span, problem=problem, hint=hint))
    return sign * factor, tuple(_form(arg, step, span) for arg in args)


def _form(value: Scalar, step: int, span: Span) -> Form:
    """The linear part. Raises Mistake for what a link has."""
    terms = []
    for atom, factor in value.terms:
        if not isinstance(atom, Signal):
            problem = "a total is of states, inputs and known signals"
            hint = "links have costs of their own: `link_cost(radio)`"
            raise Mistake(BadObjective(span=span, problem=problem, hint=hint))
        if atom.role is Role.FREE:
            problem = f"`{atom.owner}` is known to nobody beforehand"
            hint = f'say where its values are: `signal {atom.owner} from "file.csv"`'
            raise Mistake(BadObjective(span=span, problem=problem, hint=hint))
        terms.append((atom._replace(shift=atom.shift + step), factor))
    return Form(tuple(terms), value.constant)
