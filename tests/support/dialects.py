"""Random formulas with their definition, written in the languages that can be imported.

`robustness` and `holds` are direct recursive definitions on sampled signals; they know neither the
importers nor the monitor. `Style` says how a dialect's until ends and how it writes things.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from hypothesis import strategies as st

Formula = tuple[Any, ...]
Signals = Mapping[str, Sequence[float]]

NAMES = ("p", "q", "r")


@dataclass(frozen=True, slots=True)
class Style:
    """A language: `open_until` leaves out the step at which the right side holds."""

    open_until: bool
    words: Mapping[str, str]
    signal: str  # of `name` and, for shifted samples, `shift`
    shifted: str | None
    interval: str
    step: float = 1.0


BREACH = Style(
    False,
    {"and": "and", "or": "or", "implies": "=>", "not": "not", "always": "alw",
     "eventually": "ev", "until": "until", "==": "=="},
    "{name}[t]", "{name}[t+{shift:g}]", "_[{a:g}, {b:g}]", step=0.5,
)  # fmt: skip
FALCAUN = Style(
    True,
    {"and": "&&", "or": "||", "implies": "->", "not": "!", "always": "[]", "eventually": "<>",
     "until": "U", "release": "R", "next": "X", "==": "==", "!=": "!="},
    "signal({index})", None, "_[{a:g}, {b:g}]",
)  # fmt: skip
RTAMT = Style(
    True,
    {"and": "and", "or": "or", "implies": "->", "not": "not", "always": "always",
     "eventually": "eventually", "until": "until", "next": "next", "==": "==", "!=": "!=="},
    "{name}", None, "[{a:g},{b:g}]",
)  # fmt: skip


def formulas(style: Style, *, discrete: bool = False) -> st.SearchStrategy[Formula]:
    """Bounded formulas over the signals NAMES that `style` can write."""
    operators = [">=", "<="] if style is not FALCAUN else [">", "<"]
    if discrete:
        operators = [w for w in ("==", "!=") if w in style.words]
    levels = st.integers(0, 3) if discrete else st.integers(-3, 3).map(lambda k: k + 0.5)
    shifts = st.integers(0, 2) if style.shifted else st.just(0)
    atoms = st.tuples(
        st.just("compare"), st.sampled_from(NAMES), st.sampled_from(operators), levels, shifts
    )
    return st.recursive(atoms, lambda inner: _larger(inner, style), max_leaves=6)


def _larger(inner: st.SearchStrategy[Formula], style: Style) -> st.SearchStrategy[Formula]:
    windows = st.tuples(st.integers(0, 3), st.integers(0, 3)).map(lambda w: (w[0], w[0] + w[1]))
    unary = [w for w in ("not", "next") if w in style.words]
    pairs = [w for w in ("until", "release") if w in style.words]
    return st.one_of(
        st.tuples(st.sampled_from(["and", "or", "implies"]), inner, inner),
        st.tuples(st.sampled_from(unary), inner),
        st.tuples(st.sampled_from(["always", "eventually"]), windows, inner),
        st.tuples(st.sampled_from(pairs), windows, inner, inner),
    )


def horizon(formula: Formula) -> int:
    """Steps after the present one that a formula looks at."""
    match formula:
        case ("compare", _, _, _, shift):
            return int(shift)
        case ("next", arg):
            return 1 + horizon(arg)
        case ("always" | "eventually", (_, end), arg):
            return int(end) + horizon(arg)
        case ("until" | "release", (_, end), left, right):
            return int(end) + max(horizon(left), horizon(right))
        case (_, *args):
            return max(map(horizon, args))
    raise AssertionError(formula)


def robustness(formula: Formula, signals: Signals, t: int, open_until: bool) -> float:
    """The quantitative semantics at step t, as the definition says it."""

    def rho(f: Formula, at: int) -> float:
        return robustness(f, signals, at, open_until)

    match formula:
        case ("compare", name, operator, level, shift):
            difference = signals[name][t + shift] - level
            values = {">=": difference, ">": difference, "<=": -difference, "<": -difference,
                      "==": -abs(difference), "!=": abs(difference)}  # fmt: skip
            return float(values[operator])
        case ("not", arg):
            return -rho(arg, t)
        case ("and", left, right):
            return min(rho(left, t), rho(right, t))
        case ("or", left, right):
            return max(rho(left, t), rho(right, t))
        case ("implies", left, right):
            return max(-rho(left, t), rho(right, t))
        case ("next", arg):
            return rho(arg, t + 1)
        case ("always", (a, b), arg):
            return min(rho(arg, k) for k in range(t + a, t + b + 1))
        case ("eventually", (a, b), arg):
            return max(rho(arg, k) for k in range(t + a, t + b + 1))
        case ("until", (a, b), left, right):
            last = 0 if open_until else 1
            return max(
                min([rho(right, k), *(rho(left, j) for j in range(t, k + last))])
                for k in range(t + a, t + b + 1)
            )
        case ("release", window, left, right):
            return -rho(("until", window, ("not", left), ("not", right)), t)
    raise AssertionError(formula)


def holds(formula: Formula, signals: Signals, t: int, open_until: bool) -> bool:
    """The Boolean semantics at step t; equality of values is exact."""

    def true(f: Formula, at: int) -> bool:
        return holds(f, signals, at, open_until)

    match formula:
        case ("compare", name, operator, level, shift):
            value = signals[name][t + shift]
            return bool(value == level) if operator == "==" else bool(value != level)
        case ("not", arg):
            return not true(arg, t)
        case ("and", left, right):
            return true(left, t) and true(right, t)
        case ("or", left, right):
            return true(left, t) or true(right, t)
        case ("implies", left, right):
            return not true(left, t) or true(right, t)
        case ("next", arg):
            return true(arg, t + 1)
        case ("always", (a, b), arg):
            return all(true(arg, k) for k in range(t + a, t + b + 1))
        case ("eventually", (a, b), arg):
            return any(true(arg, k) for k in range(t + a, t + b + 1))
        case ("until", (a, b), left, right):
            last = 0 if open_until else 1
            return any(
                true(right, k) and all(true(left, j) for j in range(t, k + last))
                for k in range(t + a, t + b + 1)
            )
        case ("release", window, left, right):
            return not true(("until", window, ("not", left), ("not", right)), t)
    raise AssertionError(formula)


def write(formula: Formula, style: Style) -> str:
    """The formula in a dialect, fully parenthesised."""
    words = style.words
    match formula:
        case ("compare", name, operator, level, shift):
            return f"({_signal(name, shift, style)} {words.get(operator, operator)} {level})"
        case ("not" | "next" as word, arg):
            return f"({words[word]} {write(arg, style)})"
        case ("always" | "eventually" as word, window, arg):
            return f"({words[word]}{_interval(window, style)} {write(arg, style)})"
        case ("until" | "release" as word, window, left, right):
            operator = f"{words[word]}{_interval(window, style)}"
            return f"({write(left, style)} {operator} {write(right, style)})"
        case (word, left, right):
            return f"({write(left, style)} {words[word]} {write(right, style)})"
    raise AssertionError(formula)


def _interval(window: tuple[int, int], style: Style) -> str:
    return style.interval.format(a=window[0] * style.step, b=window[1] * style.step)


def _signal(name: str, shift: int, style: Style) -> str:
    if shift and style.shifted is not None:
        return style.shifted.format(name=name, shift=shift * style.step)
    return style.signal.format(name=name, index=NAMES.index(name))
