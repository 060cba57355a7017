"""One sentence of cause: what is missing, by how much."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from functools import partial

from stlc.backends import get
from stlc.backends.base import SolveOptions
from stlc.errors import InfeasibleError, MissionError, NoPlanError, SolverError, UsageError
from stlc.explain.givens import Given, Kind, givens_of
from stlc.explain.oracle import Oracle, Question, Verdict, channels_of
from stlc.explain.words import body_of, clause, parts_of, said, unit_of, when
from stlc.ir.nodes import Always, Eventually, Link, Node, Until, walk
from stlc.ir.requirement import Requirement
from stlc.mission import ObjectiveTerm, TermKind
from stlc.solve.supervise import Supervisor

_LONGER = 3  # times the horizon, and a little, for the earliest possible step
_LOW = -1e6  # a margin that never binds
_GAP = 0.02  # of the shortfall: a person reads two digits


@dataclass(frozen=True, slots=True)
class Cause:
    """A sentence. `earliest`: the first step at which what comes too late is possible; `short`: how
    far the best value of `of` stays below what is asked, in `unit`."""

    text: str
    earliest: int | None = None
    short: float | None = None
    unit: str = ""


def cause_of(oracle: Oracle, pieces: Sequence[Requirement], givens: Sequence[Given]) -> Cause:
    """Why these cannot hold together."""
    if not givens and pieces:
        return Cause(_contradiction(pieces))
    late = _deadline(oracle, pieces, givens)
    if late is not None:
        return late
    kept = _given(givens)
    if not pieces:
        return Cause(f"no run keeps {kept}")
    short = _shortfall(oracle, pieces, givens)
    if short is not None:
        piece, value = short
        unit = unit_of(piece.formula)
        others = [clause(p) for p in pieces if p is not piece]
        beside = f"beside {_and(others)}, " if others else ""
        text = f"{beside}{clause(piece)} stays {value:.3g}{' ' + unit if unit else ''} short"
        return Cause(f"{text} at best, {kept}", short=value, unit=unit)
    return Cause(f"no run meets {_and([clause(p) for p in pieces])}, {kept}")


def _contradiction(pieces: Sequence[Requirement]) -> str:
    """Pieces that fail whatever is given."""
    words = [clause(p) for p in pieces]
    if len(pieces) == 1:
        words = _together(pieces[0]) or words
    if len(words) == 1:
        return f"{words[0]} holds for no motion at all"
    return f"{_and(words)} contradict each other, however the agents move"


def _together(piece: Requirement) -> list[str]:
    """What a lone piece asks for at once; the left of an `until` up to and at its last step."""
    words = [f"`{said(part)}`" for part in parts_of(piece)]
    if isinstance(body_of(piece.formula), Until):
        plain = isinstance(piece.formula, Until)  # else its window counts from another step
        judged = when(piece) if plain or not when(piece) else f" (judged{when(piece)})"
        words = [f"{words[0]} up to then", words[1] + judged]
    return words


def _and(words: Sequence[str]) -> str:
    return words[0] if len(words) == 1 else f"{', '.join(words[:-1])} and {words[-1]}"


def _given(givens: Sequence[Given]) -> str:
    """`given the speed and start of r1 and r2`: agents with the same kinds together."""
    kinds: dict[str, list[str]] = {}
    for given in givens:
        kinds.setdefault(given.owner, []).append(given.kind.value.replace("_", " "))
    owners: dict[str, list[str]] = {}
    for owner, words in kinds.items():
        owners.setdefault(_and(list(dict.fromkeys(words))), []).append(owner)
    said = [
        f"the {words}" + (f" of {_and(names)}" if any(names) else "")
        for words, names in owners.items()
    ]
    return f"given {_and(said)}" if said else "whatever else is given"


# --- too late ----------------------------------------------------------------------------------


def _deadline(
    oracle: Oracle, pieces: Sequence[Requirement], givens: Sequence[Given]
) -> Cause | None:
    """A lone `eventually` that would be possible later, or never."""
    if len(pieces) != 1 or any(g.kind is Kind.PARTITION for g in givens):
        return None
    piece = pieces[0]
    if not isinstance(piece.formula, Eventually | Until):
        return None
    end, horizon = piece.formula.end, oracle.mission.horizon
    deadline = horizon if end is None else min(end, horizon)
    later = Later(oracle, piece)
    earliest = later.earliest(deadline)
    if not later.sure:
        return None
    who = _and(sorted(oracle.agents(pieces)))
    what, at = _purpose(body_of(piece.formula)), _speed(givens)
    if earliest is None:
        most = _most(oracle)
        text = f"{who} cannot {what} within {most} steps{at}, {_given(givens)}"
        return Cause(text)
    if not later.is_late(earliest - 1, givens):
        at = ""  # what else is given makes it that late
    text = f"{who} needs at least {earliest} steps to {what}{at}; the deadline is {deadline}"
    return Cause(text, earliest)


def _purpose(body: Node) -> str:
    if body.member is not None and isinstance(body.member.subject, str):
        return f"{'reach' if body.member.inside else 'leave'} {body.member.place}"
    return f"make `{said(body)}` hold"


def _speed(givens: Sequence[Given]) -> str:
    speeds = [g for g in givens if g.kind is Kind.SPEED and g.span is not None]
    if not speeds:
        speeds = [g for g in givens if g.kind is Kind.CONTROL and g.span is not None]
    return f" at `{speeds[0].span.text}`" if speeds and speeds[0].span else ""


def _most(oracle: Oracle) -> int:
    """The last step that is looked at for what comes too late."""
    return _LONGER * oracle.mission.horizon + 20


@dataclass(slots=True)
class Later:
    """Whether a piece is possible by another deadline, the horizon moved with it.

    `sure`: every deadline that was asked about is decided.
    """

    oracle: Oracle
    piece: Requirement
    sure: bool = True

    def earliest(self, deadline: int) -> int | None:
        """The first deadline at which an `eventually` or `until` is possible by itself.

        None where there is none within three times the horizon, or it isn't `sure`.
        """
        low, high, most = deadline + 1, deadline + 2, _most(self.oracle)
        while not self._by(min(high, most)):
            if high >= most or not self.sure:
                return None
            low, high = min(high, most) + 1, high + 2 * (high - deadline)
        high = min(high, most)
        while low < high:
            middle = (low + high) // 2
            if self._by(middle):
                high = middle
            else:
                low = middle + 1
        return high if self.sure else None

    def is_late(self, deadline: int, givens: Sequence[Given]) -> bool:
        """Whether nothing is possible by a deadline where these alone are given."""
        return not self._by(deadline, _others(self.oracle, [self.piece], givens)) and self.sure

    def _by(self, end: int, free: Iterable[Given] = ()) -> bool:
        formula, mission = self.piece.formula, self.oracle.mission
        assert isinstance(formula, Eventually | Until)
        piece = replace(self.piece, formula=replace(formula, end=end))
        longer = replace(mission, horizon=max(mission.horizon, end))
        asked = self.oracle
        own = Oracle(longer, asked.backend, asked.deadline, asked.grace, asked.tables)
        verdict = own([piece], free)
        self.sure &= verdict is not Verdict.UNKNOWN
        return verdict is Verdict.FEASIBLE


# --- too little --------------------------------------------------------------------------------


def _shortfall(
    oracle: Oracle, pieces: Sequence[Requirement], givens: Sequence[Given]
) -> tuple[Requirement, float] | None:
    """The piece that a planner would rather give way in, and by how much it fails at best."""
    piece = min(pieces, key=_weight)
    free = _others(oracle, pieces, givens)
    value = shortfall(oracle, Question(frozenset(pieces), free), piece)
    return (piece, value) if value is not None and value > 1e-6 else None


def _others(
    oracle: Oracle, pieces: Sequence[Requirement], givens: Sequence[Given]
) -> frozenset[Given]:
    """What else is given to those that the pieces speak of."""
    agents, channels = sorted(oracle.agents(pieces)), sorted(channels_of(pieces))
    every = givens_of(oracle.mission, agents, channels)
    return frozenset(g for g in every if g.kind is not Kind.PARTITION) - frozenset(givens)


def _weight(piece: Requirement) -> int:
    """Links first, then conditions that hold all the time, then goals."""
    if any(isinstance(n, Link) for n in walk(piece.formula)):
        return 0
    return 1 if isinstance(piece.formula, Always) else 2


def shortfall(oracle: Oracle, question: Question, piece: Requirement) -> float | None:
    """How far the best robustness of a piece beside the others stays below its margin, as bounded.

    None where that isn't found out in a moment, or has no bound.
    """
    part, name = oracle.part(question), oracle.name_in(question, piece)
    freed = tuple(replace(r, margin=_LOW) if r.name == name else r for r in part.requirements)
    goal = ObjectiveTerm(TermKind.ROBUSTNESS, -1.0, requirement=name)
    try:
        mission, brief = replace(part, requirements=freed, objective=(goal,)), oracle.brief()
        model = oracle.made(mission, oracle.options(question), brief).model
        work, asked = partial(get(oracle.backend).solve, model), SolveOptions(gap=_GAP)
        answer = Supervisor(work, brief.bind(asked), oracle.grace).run()
    except (InfeasibleError, MissionError, NoPlanError, SolverError, UsageError):
        return None
    return None if answer is None or answer.bound is None else piece.margin + answer.bound
