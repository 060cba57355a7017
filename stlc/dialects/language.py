"""What the parser needs to know of a language: its operators, their powers, their spelling."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Literal

from stlc.dialects.tree import (
    Operator,
)


@dataclass(frozen=True, slots=True)
class Prefix:
    """A prefix operator; its operand binds at least as tight as `operand`.

    `timed` is the power of the operand after an interval, if that differs.
    """

    operator: Literal["not", "-", "+", "always", "eventually", "next"]
    operand: int
    timed: int | None = None


@dataclass(frozen=True, slots=True)
class Infix:
    """A binary operator; `timed` is its power with an interval, if that differs."""

    operator: Operator | Literal["until", "release", "unless"]
    power: int
    right: bool = False  # groups from the right
    timed: int | None = None


@dataclass(frozen=True, slots=True)
class Language:
    """What the parser needs to know of a language."""

    scanner: re.Pattern[str]
    prefix: Mapping[str, Prefix]
    infix: Mapping[str, Infix]
    past: Mapping[str, str]  # spelling -> key of PAST_ADVICE
    functions: frozenset[str]
    separators: tuple[str, ...] = (",",)
    units: frozenset[str] = frozenset()
    constants: Mapping[str, bool] = field(default_factory=dict)


ARITHMETIC_POWER = 40
"""Languages give arithmetic operators this power or more, and all others less."""


SIGNS: Mapping[str, Prefix] = {"-": Prefix("-", 44), "+": Prefix("+", 44)}


ARITHMETIC: Mapping[str, Infix] = {
    "+": Infix("+", 41),
    "-": Infix("-", 41),
    "*": Infix("*", 42),
    "/": Infix("/", 42),
    "^": Infix("^", 46),
}


def compared(power: int, spellings: Mapping[str, Operator]) -> dict[str, Infix]:
    """Comparison operators, all of one power."""
    return {text: Infix(operator, power) for text, operator in spellings.items()}
