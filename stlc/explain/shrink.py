"""From requirements that cannot hold together to as few and as short parts of them as do it.

Deletion filter (Chinneck and Dravnieks, Locating minimal infeasible constraint sets in linear
programs, 1991), many at a time while that works; windows by bisection, since a narrower window
asks for less. A part goes only where what is left is proven infeasible.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Sequence
from dataclasses import replace
from typing import TypeVar

from stlc.explain.givens import Given, Kind, givens_of
from stlc.explain.oracle import Oracle, Verdict, channels_of
from stlc.explain.weaken import conjuncts, drops, narrowed, window
from stlc.ir.nodes import Always, walk
from stlc.ir.requirement import Requirement
from stlc.passes.horizon import last_steps

T = TypeVar("T")
Pieces = tuple[Requirement, ...]


def minimal(items: Sequence[T], holds: Callable[[Sequence[T]], bool]) -> tuple[T, ...]:
    """A subset that still `holds` and none of whose members can go; earlier ones go first.

    `holds` is monotone and true of `items`. Halves are tried first, then smaller runs.
    """
    kept, size = list(items), max(1, len(items) // 2)
    while True:
        at = 0
        while at < len(kept):
            rest = kept[:at] + kept[at + size :]
            if (rest or size == 1) and holds(rest):
                kept = rest
            else:
                at += size
        if size == 1:
            return tuple(kept)
        size //= 2


def length_of(piece: Requirement) -> int:
    """How much there is to read: distinct parts of the formula."""
    return sum(1 for _ in walk(piece.formula))


def core(oracle: Oracle, requirements: Pieces) -> Pieces:
    """Conjuncts of requirements that conflict: of a lone one before those of several.

    What a proof by intervals names is tried first. A lone one is looked for last, when the runs
    found on the way have settled most of them.
    """
    blamed = [r for r in requirements if r.name == oracle.blamed]
    focus = oracle.agents(blamed) | frozenset(filter(None, [oracle.stuck]))
    if len(requirements) == 1 or (blamed and oracle.infeasible(blamed)):
        return _apart(oracle, blamed or requirements, focus)
    found = _apart(oracle, requirements, focus)
    names = {piece.name for piece in found}
    if len(names) == 1:
        return found
    others = sorted((r for r in requirements if r.name not in names), key=length_of)
    oracle.rest()
    lone = next((r for r in others if oracle.infeasible([r])), None)
    return found if lone is None else _apart(oracle, [lone], frozenset())


def _apart(oracle: Oracle, requirements: Sequence[Requirement], focus: frozenset[str]) -> Pieces:
    """A minimal conflict of the conjuncts of infeasible requirements: they say the same."""
    pieces = tuple(dict.fromkeys(p for r in requirements for p in conjuncts(r)))
    oracle.note(pieces, Verdict.INFEASIBLE)
    longest = sorted(_near(oracle, pieces, focus), key=length_of, reverse=True)
    return minimal(longest, oracle.infeasible)


def _near(oracle: Oracle, pieces: Pieces, focus: frozenset[str]) -> Pieces:
    """Those that already conflict of what is asked of the agents in focus, of them and those they
    have to do with, or of agents that have to do with each other."""
    about = {piece: oracle.agents([piece]) for piece in pieces}
    rings = []
    if focus:
        rings += [focus, focus.union(*(a for a in about.values() if focus & a))]
    for agents in (*rings, *sorted(set(about.values()), key=len), *_groups(about.values())):
        near = tuple(p for p in pieces if about[p] <= agents)
        if 0 < len(near) < len(pieces) and oracle.infeasible(near):
            return near
    return pieces


def is_local(oracle: Oracle, requirements: Pieces) -> bool:
    """Whether a few agents that some condition speaks of already cannot do what is asked of them:
    found in moments where a solver takes long over the whole."""
    pieces = tuple(dict.fromkeys(p for r in requirements for p in conjuncts(r)))
    about = {piece: oracle.agents([piece]) for piece in pieces}
    return any(
        oracle.infeasible([p for p in pieces if about[p] <= agents])
        for agents in sorted(set(about.values()), key=len)
    )


def _groups(sets: Iterable[frozenset[str]]) -> list[frozenset[str]]:
    """Unions of sets that overlap."""
    groups: list[frozenset[str]] = []
    for agents in sets:
        touching = [g for g in groups if g & agents]
        groups = [g for g in groups if not g & agents] + [agents.union(*touching)]
    return groups


def inside(oracle: Oracle, pieces: Pieces, free: Collection[Given] = ()) -> Pieces:
    """Down to parts of formulas and steps that conflict with `free` not given."""

    def fails(some: Iterable[Requirement]) -> bool:
        return oracle.infeasible(some, free)

    for piece in sorted(pieces, key=length_of, reverse=True):
        others = tuple(p for p in pieces if p is not piece)
        shorter = _fewer_parts(piece, others, fails)
        shorter = _fewer_steps(oracle, shorter, others, free)
        pieces = tuple(shorter if p is piece else p for p in pieces)
    split = tuple(p for piece in pieces for p in conjuncts(piece))
    if len(split) > len(pieces) and fails(split):
        return minimal(split, fails)
    return pieces


def _fewer_parts(
    piece: Requirement, others: Pieces, fails: Callable[[Iterable[Requirement]], bool]
) -> Requirement:
    """Parts left out, wherever in the formula, as long as the conflict stays."""
    tried = 0
    while True:
        ways = list(drops(piece.formula))
        if tried >= len(ways):
            return piece
        shorter = replace(piece, formula=ways[tried])
        if fails((*others, shorter)):
            piece = shorter
        else:
            tried += 1


def _fewer_steps(
    oracle: Oracle, piece: Requirement, others: Pieces, free: Collection[Given]
) -> Requirement:
    """The window of an `always` from step 0 cut down at its end, then at its start."""
    if not isinstance(piece.formula, Always):
        return piece
    body = piece.formula.arg
    ends = window(piece.formula, last_steps((body,), oracle.mission.horizon)[body])
    if ends is None or ends[0] >= ends[1]:
        return piece

    def fails(first: int, last: int) -> bool:
        return oracle.infeasible((*others, narrowed(piece, first, last)), free)

    first, last = ends
    broken = oracle.broken(piece, others, free)
    if broken is not None and fails(*broken):
        first, last = broken
    last = _least(first, last, lambda t: fails(first, t))
    first = -_least(-last, -first, lambda t: fails(-t, last))
    return narrowed(piece, first, last)


def _least(low: int, high: int, holds: Callable[[int], bool]) -> int:
    """The least number in low..high that holds, where every greater one does and `high` does."""
    while low < high:
        middle = (low + high) // 2
        if holds(middle):
            high = middle
        else:
            low = middle + 1
    return high


def given(oracle: Oracle, pieces: Pieces) -> list[Given]:
    """What agents and channels of the pieces are given."""
    return givens_of(oracle.mission, sorted(oracle.agents(pieces)), sorted(channels_of(pieces)))


def minimal_givens(oracle: Oracle, pieces: Pieces, every: Sequence[Given]) -> tuple[Given, ...]:
    """Those of `every` without which the pieces can hold, each beside the others that are kept."""

    def fails(kept: Iterable[Given]) -> bool:
        return oracle.infeasible(pieces, set(every) - set(kept))

    if fails(()):
        return ()
    return tuple(one_by_one(every, fails))


def one_by_one(every: Sequence[Given], fails: Callable[[Iterable[Given]], bool]) -> list[Given]:
    """A subset that still fails though no member can be left out; `every` itself must fail."""
    kept = list(every)
    for given in every:
        rest = [g for g in kept if g is not given]
        if fails(rest):
            kept = rest
    return kept


def by_cells(givens: Iterable[Given]) -> bool:
    """Whether the grid of a channel takes part."""
    return any(g.kind is Kind.PARTITION for g in givens)
