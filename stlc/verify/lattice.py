"""A condition as minima and maxima of numbers, negations moved to them.

Predicates and Euclidean lengths are its atoms. Each counts positively or under a negation, where
its number is that of the opposite: what a motion may be off by is taken off either.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from stlc.ir.nodes import And, Const, Iff, Implies, Linear, Node, Not, Or
from stlc.ir.norms import Norms

Array = NDArray[np.float64]
Combine = Callable[[Array], Array]


@dataclass(frozen=True, slots=True)
class Atom:
    """A predicate or lengths, or (not `positive`) their opposite."""

    form: Linear | Norms
    positive: bool


@dataclass(frozen=True, slots=True)
class Join:
    """The least of some parts, or the greatest."""

    least: bool
    parts: tuple[Lattice, ...]


Lattice = Atom | Join | float


def lattice(node: Node, exact: Callable[[Norms], bool], positive: bool = True) -> Lattice:
    """A condition (or its negation), with lengths in place of their faces where these are `exact`.

    Raises TypeError for what isn't a condition on states and inputs.
    """
    if node.norms is not None and exact(node.norms):
        return Atom(node.norms, positive)

    def signed(part: Node, sign: bool = True) -> Lattice:
        return lattice(part, exact, positive is sign)

    match node:
        case Linear():
            return Atom(node, positive)
        case Const(value=value):
            return np.inf if value is positive else -np.inf
        case Not(arg=arg):
            return signed(arg, False)
        case And(args=args) | Or(args=args):
            return Join(isinstance(node, And) is positive, tuple(map(signed, args)))
        case Implies(left=left, right=right):
            return Join(not positive, (signed(left, False), signed(right)))
        case Iff(left=left, right=right):
            ways = ((signed(left, False), signed(right)), (signed(right, False), signed(left)))
            return Join(positive, tuple(Join(not positive, way) for way in ways))
    raise TypeError(f"{type(node).__name__} in a swept condition")


def atoms(found: Lattice) -> Iterator[Atom]:
    """Every atom, as often as it is there."""
    if isinstance(found, Atom):
        yield found
    if isinstance(found, Join):
        for part in found.parts:
            yield from atoms(part)


def combination(found: Lattice, index: Mapping[Atom, int]) -> Combine:
    """The condition as a function of its atoms' numbers (.., atoms), which rises with each."""
    match found:
        case Atom():
            k = index[found]
            return lambda q: np.asarray(q[..., k])
        case Join(least=least, parts=parts):
            parts_of = [combination(part, index) for part in parts]
            join: Callable[[list[Array]], Array] = np.minimum.reduce if least else np.maximum.reduce
            return lambda q: np.asarray(join([part(q) for part in parts_of]))
    level = found
    return lambda q: np.full(q.shape[:-1], level)
