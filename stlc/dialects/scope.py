"""Which name means what in an imported file, and which times it speaks of."""

from __future__ import annotations

from dataclasses import dataclass, field
from enum import Enum
from fractions import Fraction

from stlc.diagnostics import Diagnostic
from stlc.dialects.names import Names
from stlc.dialects.tree import (
    ARITHMETIC,
    Binary,
    Call,
    Definition,
    Expr,
    Interval,
    Minus,
    Name,
    Num,
    Sample,
)
from stlc.source import Span


class Kind(Enum):
    """What a name stands for."""

    SIGNAL = "signal"
    PARAM = "param"
    FORMULA = "formula"  # a definition of logical form
    NUMBER = "number"  # a definition that is a number at each step


@dataclass(frozen=True, slots=True)
class Dialect:
    """How a language reads its names, times and operators.

    `loose` names in arithmetic are parameters (True), signals (False), or parameters only on the
    right of a comparison (None). `formulas_are_numbers`: every expression has a value, which is
    its robustness. `open_until`: the left side of until may end one step before the right holds.
    `discrete_equality`: exactly one of == and != holds. `unit` is that of a bare time, "" counting
    steps.
    """

    name: str
    loose: bool | None
    formulas_are_numbers: bool
    open_until: bool
    discrete_equality: bool
    unit: str


@dataclass(slots=True)
class ParamUse:
    """A parameter, declared or not, and where it is used."""

    name: str
    span: Span
    value: Fraction | None = None  # None: the file gives none
    emitted: str = ""
    in_times: bool = False
    elsewhere: bool = False
    is_factor: bool = False
    no_value: bool = False

    @property
    def is_time(self) -> bool:
        """Only times are made of it, one in each summand: it is declared in seconds."""
        return self.in_times and not self.elsewhere


@dataclass(slots=True)
class Scope:
    """The names of one file. `survey` fills it in before anything is written."""

    dialect: Dialect
    names: Names = field(default_factory=Names)
    params: dict[str, ParamUse] = field(default_factory=dict)
    signals: dict[str, str] = field(default_factory=dict)  # name -> emitted
    definitions: list[Definition] = field(default_factory=list)
    visible: dict[int, dict[str, int]] = field(default_factory=dict)  # of a definition: by name
    emitted: dict[int, str] = field(default_factory=dict)
    used: set[int] = field(default_factory=set)
    intervals: list[Interval] = field(default_factory=list)
    shifts: list[Expr] = field(default_factory=list)
    warnings: list[Diagnostic] = field(default_factory=list)

    def values(self) -> dict[str, Fraction]:
        """Every parameter's number."""
        return {name: use.value or Fraction(0) for name, use in self.params.items()}

    def kind(self, name: str, at: int) -> Kind | None:
        """What a name means inside of definition `at`; None if it is declared nowhere."""
        if name in self.visible[at]:
            body = self.definitions[self.visible[at][name]].body
            formula = self.is_formula(body, self.visible[at][name])
            return Kind.FORMULA if formula else Kind.NUMBER
        if name in self.params:
            return Kind.PARAM
        return Kind.SIGNAL if name in self.signals else None

    def is_formula(self, expr: Expr, at: int) -> bool:
        """Whether an expression has the form of a formula."""
        match expr:
            case Name(text=name):
                return self.kind(name, at) is Kind.FORMULA
            case Binary(operator=operator):
                return operator not in ARITHMETIC
            case Num() | Sample() | Call() | Minus():
                return False
        return True
