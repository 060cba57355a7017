"""The mission language's grammar: `stl.lark`, its compiled parse table, editor support."""

from __future__ import annotations

import json
from dataclasses import dataclass
from functools import cache
from pathlib import Path

_FOLDER = Path(__file__).resolve().parent


@dataclass(frozen=True, slots=True)
class Rule:
    """One production: `left` has `size` symbols on its right side.

    `callback` names the builder of the node (None: hand the children on); `plan` picks its
    arguments from the right side, -1 standing for an absent optional part.
    """

    left: str
    size: int
    callback: str | None
    plan: tuple[int, ...]
    is_step: bool  # `sum: product`: nothing is built
    splices: bool  # is a repetition, or has one on its right side


@dataclass(frozen=True, slots=True)
class Tables:
    """LALR(1) parse table; an action >= 0 shifts to that state, a < 0 reduces by rule -1 - a."""

    rules: tuple[Rule, ...]
    actions: tuple[dict[str, int], ...]
    gotos: tuple[dict[str, int], ...]
    start: int
    end: int
    spellings: dict[str, tuple[str, ...]]


def grammar_text() -> str:
    """The grammar as lark reads it."""
    return (_FOLDER / "stl.lark").read_text(encoding="utf-8")


def _rule(left: str, size: int, callback: str | None, plan: list[int], splices: bool) -> Rule:
    is_step = callback is None and not splices and size == 1 and plan == [0]
    return Rule(left, size, callback, tuple(plan), is_step, splices)


@cache
def tables() -> Tables:
    """The compiled grammar (`python -m stlc.grammar.build` makes it)."""
    data = json.loads((_FOLDER / "tables.json").read_text(encoding="utf-8"))
    return Tables(
        rules=tuple(_rule(*row) for row in data["rules"]),
        actions=tuple(data["actions"]),
        gotos=tuple(data["gotos"]),
        start=data["start"],
        end=data["end"],
        spellings={name: tuple(words) for name, words in data["spellings"].items()},
    )
