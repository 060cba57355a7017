"""Times: whole steps, or durations that are a whole number of steps."""

from __future__ import annotations

from stlc.sema.report import Mistake
from stlc.sema.scope import EMPTY, Scope
from stlc.sema.time_errors import (
    HugeTime,
    NegativeTime,
    NotSteps,
    NotWholeSteps,
    ReversedInterval,
)
from stlc.sema.units import SECOND
from stlc.sema.values import Env, Scalar
from stlc.source import Span
from stlc.syntax import ast

MOST_STEPS = 1_000_000
FAR = 1e15  # steps that doubles don't tell from their neighbours, or nearly so


def steps(expr: ast.Expr, scope: Scope, env: Env = EMPTY) -> int:
    """A time as a number of steps; without a unit it counts steps. Never rounds."""
    return as_steps(scope.constant(expr, env), expr.span, scope)


def as_steps(scalar: Scalar, span: Span, scope: Scope) -> int:
    """A constant as a number of steps; `span` is where it stands."""
    if scalar.constant < 0:
        raise Mistake(NegativeTime(span=span))
    if scalar.unit is None:
        return _limited(_whole(scalar.constant, span, scope.step, ""), span)
    if scalar.unit != SECOND:
        raise Mistake(NotSteps(span=span, found=f"a value in {scalar.unit}"))
    return _limited(_whole(scalar.constant / scope.step, span, scope.step, "s"), span)


def _limited(count: int, span: Span) -> int:
    if count > MOST_STEPS:
        raise Mistake(HugeTime(span=span, steps=str(count), limit=MOST_STEPS))
    return count


def _whole(ratio: float, span: Span, step: float, unit: str) -> int:
    """A quotient of a time and the step that is a whole number; Mistake for any other."""
    if ratio >= FAR:  # a quotient may overflow where neither number does
        raise Mistake(HugeTime(span=span, steps=f"{ratio:.3g}", limit=MOST_STEPS))
    nearest = round(ratio)
    if abs(ratio - nearest) <= 1e-9 * max(1.0, abs(ratio)):
        return nearest
    below = int(ratio)
    texts = [f"{k * step:g} s ({k} steps)" if unit else str(k) for k in (below, below + 1)]
    raise Mistake(
        NotWholeSteps(span=span, value=span.text.strip(), step=step, below=texts[0], above=texts[1])
    )


def interval(node: ast.Interval | None, scope: Scope, env: Env = EMPTY) -> tuple[int, int | None]:
    """[start, end] in steps; end None is unbounded."""
    if node is None:
        return 0, None
    start = steps(node.start, scope, env)
    if node.end is None or _is_end(node.end, env, scope):
        return start, None
    end = steps(node.end, scope, env)
    if end < start:
        raise Mistake(ReversedInterval(span=node.span, start=start, end=end))
    return start, end


def is_last(node: ast.Interval | None, env: Env, scope: Scope) -> bool:
    """Whether an interval is `[end]`: the last step at which its body can be judged."""
    return node is not None and node.start is node.end and _is_end(node.start, env, scope)


def _is_end(expr: ast.Expr, env: Env, scope: Scope) -> bool:
    names = ("inf", "end", "infinity")
    return (
        isinstance(expr, ast.Name)
        and expr.text in names
        and expr.text not in env.bound
        and expr.text not in scope.declarations
    )


def duration(scalar: Scalar) -> float | None:
    """Seconds of a constant, a bare number counting seconds; None if it is no time."""
    if scalar.unit is None or scalar.unit == SECOND:
        return scalar.constant
    return None
