"""Comparisons of piecewise-linear scalars, as formulas over linear and link predicates.

With r + c max_i e_i >= 0 and c > 0 some piece holds, with c < 0 every piece: so each fold becomes
a disjunction or a conjunction, and robustness is exact because a sum commutes with max and min.
Numbers are compared like signals: the robustness of `5 >= 3` is 2. Only a comparison of indices
(what a quantifier's variable stands for) is true or false: it says which instance is meant.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from operator import eq, ge, gt, le, lt, ne
from typing import Final, Literal

from stlc.ir.nodes import (
    And,
    Const,
    Linear,
    Link,
    Node,
    Or,
    Quantity,
    Relation,
    Role,
    Signal,
)
from stlc.ir.norms import Norms, Sum
from stlc.sema import units
from stlc.sema.channel_errors import BadLink
from stlc.sema.report import Mistake
from stlc.sema.scalars import add, few, mismatch, scale
from stlc.sema.unit_errors import LevelAgainstRatio
from stlc.sema.values import Fold, FoldKind, LinkAtom, Scalar
from stlc.source import Span

Operator = Literal["<", "<=", ">", ">=", "==", "!="]

MIRRORED: Final[dict[Operator, Operator]] = {
    "<": ">", "<=": ">=", ">": "<", ">=": "<=", "==": "==", "!=": "!=",
}  # fmt: skip
"""The operator between the same two sides the other way round."""


_RELATIONS: dict[Operator, Callable[[float, float], bool]] = {
    "<": lt, "<=": le, ">": gt, ">=": ge, "==": eq, "!=": ne,
}  # fmt: skip


def is_condition(left: Scalar, right: Scalar) -> bool:
    """Whether comparing them tells instances of a quantifier apart, not runs."""
    return left.is_constant and right.is_constant and (left.index or right.index)


def compare(left: Scalar, operator: Operator, right: Scalar, span: Span, positive: bool) -> Node:
    """`left operator right`; strict and non-strict are one. Raises Mistake."""
    left, right = _level_units(left, right, span)
    if is_condition(left, right):
        return Const(_RELATIONS[operator](left.constant, right.constant), span=span)
    match operator:
        case ">" | ">=":
            return at_least_zero(_difference(left, right, span), span, positive)
        case "<" | "<=":
            return at_least_zero(_difference(right, left, span), span, positive)
        case "==" | "!=":
            both = (_difference(left, right, span), _difference(right, left, span))
            parts = tuple(at_least_zero(d, span, positive) for d in both)
            return And(parts, span=span) if operator == "==" else Or(parts, span=span)


def _difference(left: Scalar, right: Scalar, span: Span) -> Scalar:
    return add(left, right, span, sign=-1.0)


def _level_units(left: Scalar, right: Scalar, span: Span) -> tuple[Scalar, Scalar]:
    """Both in one unit; a bare number takes the other's."""
    if left.unit is None or right.unit is None:
        unit = right.unit if left.unit is None else left.unit
        return replace(left, unit=unit), replace(right, unit=unit)
    if left.unit == right.unit:
        return left, right
    if left.unit.dims == right.unit.dims:
        raise Mistake(LevelAgainstRatio(span=span, left=str(left.unit), right=str(right.unit)))
    raise Mistake(mismatch(left.unit, right.unit, "compared", span))


def at_least_zero(scalar: Scalar, span: Span, positive: bool) -> Node:
    """`scalar >= 0` as a formula."""
    return _unfold(few(scalar, span), span, positive)


def _unfold(scalar: Scalar, span: Span, positive: bool) -> Node:
    """`scalar >= 0` without min, max, abs and lengths, one of them after the other.

    Each becomes a conjunction or disjunction over its arguments, by its kind and its coefficient's
    sign.
    """
    if not scalar.folds:
        return _leaf(scalar, span)
    # Lengths last: what stands behind them is then linear but for them.
    ordered = sorted(scalar.folds, key=lambda part: part[0].kind is FoldKind.DISTANCE)
    (fold, coefficient), *others = ordered
    norms = _norms(scalar) if fold.kind is FoldKind.DISTANCE else None
    rest = replace(scalar, folds=tuple(others))
    coefficient = _sound(fold, coefficient, positive)
    alternatives = tuple(
        _unfold(_plus(rest, scale(arg, coefficient, scalar.unit)), span, positive)
        for arg in fold.args
    )
    some = (fold.kind is FoldKind.MIN) == (coefficient < 0)
    return _join(Or if some else And, alternatives, span, norms)


def _norms(scalar: Scalar) -> Norms | None:
    """The lengths that a scalar is made of, None when they are of anything but linear numbers."""
    lengths = []
    for fold, coefficient in scalar.folds:
        if any(face.folds for face in fold.args):
            return None
        lengths.append((coefficient, tuple(_sum(part) for part in fold.components)))
    return Norms(_sum(scalar), tuple(lengths), unit_name(scalar))


def _sum(scalar: Scalar) -> Sum:
    return Sum(tuple((a, c) for a, c in scalar.terms if isinstance(a, Signal)), scalar.constant)


def _sound(fold: Fold, coefficient: float, positive: bool) -> float:
    """A max over faces is within [least d, d] of the distance d it stands for.

    A requirement must imply the true one, and under a negation be implied by it: so `distance
    large` is judged by the inner value when it stands positively, `distance small` by the outer.
    """
    if fold.kind is not FoldKind.DISTANCE or (coefficient > 0) == positive:
        return coefficient
    return coefficient / fold.least


def _plus(a: Scalar, b: Scalar) -> Scalar:
    terms = dict(a.terms)
    for atom, coefficient in b.terms:
        terms[atom] = terms.get(atom, 0.0) + coefficient
    kept = tuple((k, v) for k, v in terms.items() if v != 0.0)
    return Scalar(a.constant + b.constant, kept, a.folds + b.folds, a.unit)


def _join(
    kind: type[And] | type[Or], parts: tuple[Node, ...], span: Span, norms: Norms | None
) -> Node:
    """One connective over `parts`, without repetitions; those of the same kind are taken in."""
    flat: list[Node] = []
    for part in parts:
        # Within lengths of their own the parts are no more than faces.
        alike = isinstance(part, And | Or) and type(part) is kind and (norms or not part.norms)
        flat.extend(part.children if alike else (part,))
    unique = tuple(dict.fromkeys(flat))
    if len(unique) == 1 and norms is None:
        return unique[0]
    return kind(unique, span=span, norms=norms)


def _leaf(scalar: Scalar, span: Span) -> Node:
    links = [(a, c) for a, c in scalar.terms if isinstance(a, LinkAtom)]
    if links:
        return _link(scalar, links, span)
    signals = [(a, c) for a, c in scalar.terms if isinstance(a, Signal)]
    signals.sort(key=lambda term: term[0].key)
    return Linear(tuple(signals), scalar.constant, unit_name(scalar), span=span)


def unit_name(scalar: Scalar) -> str:
    """The unit as the IR spells it."""
    return "" if scalar.unit is None else str(scalar.unit)


def _link(scalar: Scalar, links: list[tuple[LinkAtom, float]], span: Span) -> Link:
    """`a quality + b >= 0` as a threshold in the quality's unit; `factor` keeps the scale."""
    if len(links) > 1:
        raise Mistake(BadLink(span=span, problem="two link qualities stand in one comparison"))
    if len(scalar.terms) > 1:
        raise Mistake(BadLink(span=span, problem="a link quality is mixed with a signal"))
    atom, coefficient = links[0]
    relation = Relation.AT_LEAST if coefficient > 0 else Relation.AT_MOST
    return Link(
        atom.channel,
        atom.quantity,
        atom.sender,
        atom.receiver,
        relation,
        -scalar.constant / coefficient,
        shift=atom.shift,
        factor=abs(coefficient),
        span=span,
    )


def is_integer(scalar: Scalar, integer_owners: frozenset[str]) -> bool:
    """True when the scalar takes whole values only."""
    if scalar.folds or scalar.constant != int(scalar.constant):
        return False
    return all(
        isinstance(a, Signal) and a.role is Role.INPUT and a.owner in integer_owners and c == int(c)
        for a, c in scalar.terms
    )


QUANTITY_UNITS = {
    Quantity.RSSI: units.DBM,
    Quantity.SNR: units.DB,
    Quantity.BER: units.PURE,
    Quantity.BER_AT_MEAN: units.PURE,
    Quantity.PRR: units.PURE,
    Quantity.COST: None,
}
