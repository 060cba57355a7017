"""Whether all requirements of a mission can hold together, or what is known of it in the end."""

from __future__ import annotations

from stlc.explain import shrink
from stlc.explain.oracle import Oracle, Verdict
from stlc.ir.requirement import Requirement

_WHILE = (0.3, 10.0)  # part of the time, and s, for the whole before its parts
_LOCAL, _AGAIN = 0.4, 0.6  # parts of what is left then, for a few agents, and the whole once more
_NAMES = 6  # that a sentence lists


def begin(oracle: Oracle, proven: bool = False) -> Verdict | None:
    """Ask about the whole mission; None where it is proven to have no plan."""
    whole = oracle.mission.requirements
    if proven:
        oracle.note(whole, Verdict.INFEASIBLE)
    verdict = _asked(oracle, whole)
    unseen = proven or verdict is not Verdict.INFEASIBLE  # agents that nothing is required of
    if unseen and oracle.everybody() is Verdict.INFEASIBLE:
        oracle.note((), Verdict.INFEASIBLE)
        return None
    return None if verdict is Verdict.INFEASIBLE else verdict


def _asked(oracle: Oracle, whole: tuple[Requirement, ...]) -> Verdict:
    """What is known of all requirements: at first by a solver for a while, then a few agents at a
    time, then by the solver again, at last by adding one requirement to another."""
    with oracle.within(*_WHILE):
        verdict = oracle(whole)
    if verdict is not Verdict.UNKNOWN or oracle.deadline.over():
        return verdict
    with oracle.within(_LOCAL):
        local = shrink.is_local(oracle, whole)
    if local:
        oracle.note(whole, Verdict.INFEASIBLE)
        return Verdict.INFEASIBLE
    with oracle.within(_AGAIN):
        verdict = oracle(whole)
    return verdict if verdict is not Verdict.UNKNOWN else _grown(oracle, whole)


def _grown(oracle: Oracle, whole: tuple[Requirement, ...]) -> Verdict:
    """Requirements beside each other as long as they can hold together; `oracle.together` are
    those that can. Where one cannot, neither can the whole."""
    order = sorted(whole, key=shrink.length_of)
    for number, piece in enumerate(order):
        with oracle.within(1.0 / (len(order) - number)):
            verdict = oracle((*oracle.together, piece))
        if verdict is Verdict.INFEASIBLE:
            oracle.note(whole, verdict)
            return verdict
        if verdict is Verdict.FEASIBLE:
            oracle.together = (*oracle.together, piece)
    return Verdict.FEASIBLE if len(oracle.together) == len(whole) else Verdict.UNKNOWN


def undecided(oracle: Oracle) -> str:
    """What is known where the whole could not be decided: a sentence with places."""
    known = {r.name for r in oracle.together}
    open_ = [r for r in oracle.mission.requirements if r.name not in known]
    if not known or not open_:
        return ""
    words = [f"`{r.name}`{_where(r, oracle)}" for r in open_]
    together = _listed([f"`{name}`" for name in sorted(known)])
    can, them = ("can hold together", "them") if len(known) > 1 else ("can hold", "it")
    return f"{together} {can}; whether {_listed(words)} can beside {them} is open"


def _where(requirement: Requirement, oracle: Oracle) -> str:
    """` (line 12)`; with the file's name if it is an imported one."""
    span = requirement.span
    if span is None:
        return ""
    return f" (line {span.line})" if span.source is oracle.mission.source else f" ({span})"


def _listed(words: list[str]) -> str:
    if len(words) > _NAMES:
        words = [*words[:_NAMES], f"{len(words) - _NAMES} more"]
    return words[0] if len(words) == 1 else f"{', '.join(words[:-1])} and {words[-1]}"
