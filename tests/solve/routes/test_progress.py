"""Formulas are rewritten to what is left of them, step by step."""

from __future__ import annotations

from hypothesis import given
from hypothesis import strategies as st

from stlc.ir.nodes import And, Const, Linear, Node, Or, Role, Signal
from stlc.solve.routes.progress import FALSE, TRUE, Open, Progress, span_of

STEPS = 5
Word = tuple[tuple[bool, ...], ...]
"""Truth of each signal at each step."""


def atom(signal: int, step: int, role: Role = Role.STATE) -> Linear:
    return Linear(((Signal("r", role, signal, step), 1.0),), 0.0)


atoms = st.builds(atom, st.integers(0, 2), st.integers(0, STEPS))
formulas = st.recursive(
    atoms,
    lambda inner: (
        st.builds(And, st.lists(inner, max_size=3).map(tuple))
        | st.builds(Or, st.lists(inner, max_size=3).map(tuple))
    ),
    max_leaves=12,
)
words = st.tuples(*[st.tuples(*[st.booleans()] * 3)] * (STEPS + 1))


def truth(node: Node, word: Word) -> bool:
    match node:
        case And(args=args):
            return all(truth(a, word) for a in args)
        case Or(args=args):
            return any(truth(a, word) for a in args)
        case Linear(terms=((signal, _),)):
            return word[signal.shift][signal.index]
    raise TypeError


def follow(progress: Progress, word: Word) -> Open | None:
    """What is open after all steps; None as soon as it can't be fulfilled."""
    open_: Open | None = frozenset()
    for step in range(STEPS + 1):
        if any(not truth(progress.atoms[k].node, word) for k in progress.asserted.get(step, ())):
            return None
        holds = {k: truth(progress.atoms[k].node, word) for k in progress.atoms_at.get(step, ())}
        assert open_ is not None
        open_ = progress.after(open_, step, holds, {})
        if open_ is None:
            return None
    return open_


@given(st.lists(formulas, min_size=1, max_size=3), words)
def test_fulfilled_is_true(roots: list[Node], word: Word) -> None:
    progress = Progress.of((root, k) for k, root in enumerate(roots))
    wanted = all(truth(root, word) for root in roots)
    assert (follow(progress, word) == frozenset()) is wanted


def test_windows_are_one_deadline() -> None:
    """always eventually: of the windows that are open only the first to close is kept."""
    windows = [Or(tuple(atom(0, t) for t in range(k, k + 3))) for k in range(3)]
    progress = Progress.of((window, 0) for window in windows)
    open_: Open | None = frozenset()
    for step in range(3):
        assert open_ is not None
        holds = dict.fromkeys(progress.atoms_at[step], step == 0)
        open_ = progress.after(open_, step, holds, {})
    assert open_ is not None
    assert len(open_) == 1
    (left,) = open_
    assert progress.atoms[left].step == 3


def test_until_is_one_bit() -> None:
    """(not 0) until 1, from any step on: what is left does not tell when it was asked."""
    until = Or(tuple(
        And((atom(1, k), *(atom(0, t) for t in range(k + 1)))) for k in range(STEPS + 1)
    ))  # fmt: skip
    progress = Progress.of([(until, 0)])
    none: Open = frozenset()
    for step in range(3):
        holds = {k: progress.atoms[k].node == atom(0, step) for k in progress.atoms_at[step]}
        after = progress.after(none, step, holds, {})
        assert after is not None
        assert len(after) == 1
        none = after
    holds = dict.fromkeys(progress.atoms_at[3], True)
    assert progress.after(none, 3, holds, {}) == frozenset()
    assert progress.after(none, 3, dict.fromkeys(progress.atoms_at[3], False), {}) is None


def test_motion_is_judged_at_its_end() -> None:
    moving = Or((atom(0, 1), atom(0, 2)))
    assert span_of(moving) == (1, 2)
    assert span_of(atom(0, 3, Role.INPUT)) == (3, 4)
    progress = Progress.of([(moving, 0)])
    assert list(progress.asserted) == [2]
    assert progress.atoms[progress.asserted[2][0]].moving


def test_constants() -> None:
    progress = Progress.of([(And(()), 0)])
    assert not progress.starting
    assert TRUE != FALSE
    assert Progress.of([(Or(()), 0)]).starting == {0: [FALSE]}


def test_constants_are_what_they_say() -> None:
    """A requirement that was settled by its ranges leaves nothing to do, or nothing that can be."""
    assert Progress.of([(Const(True), 0)]).starting == {}
    assert Progress.of([(Const(False), 0)]).starting == {0: [FALSE]}
    both = Progress.of([(Or((Const(True), atom(0, 1))), 0), (And((Const(True), atom(0, 1))), 1)])
    assert both.starting == {}
    level = Linear((), -1.0)
    alone = Progress.of([(level, 0)])
    assert [one.node for one in alone.atoms.values()] == [level]
    assert alone.asserted == {0: list(alone.atoms)}
