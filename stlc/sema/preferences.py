"""`prefer`: soft requirements, their weights and how their violation is measured."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace

from stlc.ir.networks import Network
from stlc.ir.nodes import Always, And, Eventually, Node, Until, walk
from stlc.ir.requirement import Requirement
from stlc.mission import ObjectiveTerm, TermKind
from stlc.preferences import Measure, Preference
from stlc.sema.horizon import Reach
from stlc.sema.joints import joined
from stlc.sema.members import unit_of
from stlc.sema.objective_errors import BadPreference
from stlc.sema.report import Mistake
from stlc.sema.robust_units import units_in
from stlc.sema.scope import Scope
from stlc.sema.units import SECOND, Unit
from stlc.sema.values import Env
from stlc.syntax import ast

MOST_PARTS = 10_000


def preference(statement: ast.Prefer, name: str, margin: float, scope: Scope) -> Preference:
    """One `prefer`, its parts not yet known. Raises Mistake."""
    given: dict[str, ast.Wish] = {}
    for wish in statement.wishes:
        kind = "measure" if wish.value is None else wish.word
        if kind in given:
            raise Mistake(BadPreference(span=wish.span, problem=f"a second `{wish.word}`"))
        given[kind] = wish
    own = _number(given, "margin", margin, scope, 0.0)
    formula = scope.formula(statement.formula, Env({}, margin=own))
    alone = joined([Requirement(name, formula, own, statement.span)], scope)[0]
    measure = Measure(given["measure"].word) if "measure" in given else Measure.ROBUSTNESS
    unit = _unit(statement, measure, formula)
    least = {"weight": 0.0, "scale": 1e-9}
    weight, scale = (
        _number(given, word, 1.0, scope, least[word], unit if word == "scale" else None)
        for word in ("weight", "scale")
    )
    return Preference(
        name, alone.formula, weight, _priority(given, scope), measure, scale, own,
        unit="s" if measure is Measure.LATE else unit, span=statement.span,
    )  # fmt: skip


def _unit(statement: ast.Prefer, measure: Measure, formula: Node) -> str:
    """Of the violation. Raises Mistake where robustness has several."""
    if measure is not Measure.ROBUSTNESS:
        return ""
    if any(isinstance(n, Network) and n.composed for n in walk(formula)):
        problem = "what an end-to-end quality lacks can't be measured"
        hint = "measure it with `share` or `late`, or route by `rssi` or `snr`"
        raise Mistake(BadPreference(span=statement.span, problem=problem, hint=hint))
    units = sorted(units_in([formula]))
    if len(units) > 1:
        mixed = " and ".join(unit or "pure numbers" for unit in units)
        problem = f"the robustness of this mixes {mixed}"
        hint = "measure it with `share` or `late`, or prefer each by itself"
        raise Mistake(BadPreference(span=statement.span, problem=problem, hint=hint))
    return units[0] if units else ""


def _number(
    given: dict[str, ast.Wish],
    word: str,
    default: float,
    scope: Scope,
    least: float,
    unit: str | None = None,
) -> float:
    """A number of the head, in its unit and not below `least`. Raises Mistake."""
    wish = given.get(word)
    if wish is None or wish.value is None:
        return default
    if word == "scale":
        late = "measure" in given and given["measure"].word == "late"
        measured: Unit | None = SECOND if late else unit_of(unit or "")
        value = (
            scope.constant(wish.value).constant
            if measured is None
            else scope.number(wish.value, measured)
        )
    else:
        value = scope.constant(wish.value).constant
    if not least <= value < float("inf"):
        problem = f"the {word} is {value:g}"
        hint = f"give a {word} above 0" if least else f"give a {word} of 0 or more"
        raise Mistake(BadPreference(span=wish.span, problem=problem, hint=hint))
    return value


def _priority(given: dict[str, ast.Wish], scope: Scope) -> int | None:
    wish = given.get("priority")
    if wish is None or wish.value is None:
        return None
    value = scope.whole(wish.value)
    if value < 1:
        hint = "tiers are numbered 1, 2, ..: 1 comes first"
        raise Mistake(BadPreference(span=wish.span, problem=f"priority {value}", hint=hint))
    return value


def parted(wanted: Preference, horizon: int, step: float) -> Preference:
    """With its parts, now that the horizon T is known. Raises Mistake."""
    if wanted.measure is Measure.ROBUSTNESS:
        return wanted
    reach = Reach()
    late = wanted.measure is Measure.LATE
    parts: list[Node] = []
    for part in (_deadlines if late else _pieces)(wanted.formula, horizon, reach):
        parts.append(part)
        if len(parts) > MOST_PARTS:
            problem = f"this has more than {MOST_PARTS} parts"
            raise Mistake(BadPreference(span=wanted.span, problem=problem))
    if not parts:
        problem = f"nothing in this can be `{wanted.measure.value}`"
        hint = "`late` is for `eventually[a, b]` and `until[a, b]`, also several joined by `and`"
        raise Mistake(BadPreference(span=wanted.span, problem=problem, hint=hint))
    return replace(wanted, parts=tuple(parts), worth=step if late else 1.0 / len(parts))


def _deadlines(node: Node, horizon: int, reach: Reach) -> Iterator[Node]:
    """The formula with every deadline from its own to the last that can be judged."""
    match node:
        case And(args=args):
            for arg in args:
                yield from _deadlines(arg, horizon, reach)
        case Eventually(end=int(end)) | Until(end=int(end)):
            last = horizon - max(reach.of(child) for child in node.children)
            for deadline in range(end, last + 1):
                yield replace(node, end=deadline)
        case _:
            problem = "only what has a deadline can be `late`"
            hint = "`late` is for `eventually[a, b]` and `until[a, b]`, also joined by `and`"
            raise Mistake(BadPreference(span=node.span, problem=problem, hint=hint))


def _pieces(node: Node, horizon: int, reach: Reach, start: int = 0) -> Iterator[Node]:
    """Conjuncts and steps: `and`, `forall` and `always` opened, each piece at its step."""
    match node:
        case And(args=args) if args and node.swept is None and node.member is None:
            for arg in args:
                yield from _pieces(arg, horizon, reach, start)
        case Always(arg=arg, start=a, end=b):
            last = horizon - start - reach.of(arg) if b is None else b
            for step in range(a, last + 1):
                yield from _pieces(arg, horizon, reach, start + step)
        case _:
            yield Always(node, start, start, span=node.span) if start else node


def terms(preferences: Sequence[Preference], priority: int | None) -> tuple[ObjectiveTerm, ...]:
    """What a tier adds up; None: what is weighed against the objective."""
    return tuple(
        ObjectiveTerm(TermKind.VIOLATION, p.weight, requirement=p.name, span=p.span)
        for p in preferences
        if p.priority == priority and p.weight
    )
