"""Properties of blocks as text that reads back as the same words."""

from __future__ import annotations

import re
from typing import Final

from stlc.grammar.units import UNITS
from stlc.syntax import ast
from stlc.syntax.bounded import bounded_name
from stlc.syntax.neighbours import word_terminals
from stlc.syntax.print_expr import compared, show, show_name

_ENDS_IN_NUMBER: Final = re.compile(r"(?:^|[^\w.])(?:\d[\d.]*|\.\d+)(?:[eE][+-]?\d+)?$")


_FIRST_WORD: Final = re.compile(r"^[^\W\d]\w*")


_LAST_WORD: Final = re.compile(r"[^\W\d]\w*$")


def show_property(item: ast.Property) -> str:
    """One property of a block."""
    key = item.key.text
    if not item.args:
        return key
    if item.assigned:
        return f"{key} = {show(item.args[0])}"
    first, *rest = item.args
    if _starts_with(first, key):
        text = key + show(first).removeprefix(show_name(key))
    elif _is_chain(first, key):
        text = show(first)
    else:
        text = f"{key} {_word(first)}"
    before = first
    for arg in rest:
        text = _append(text, before, arg)
        before = arg
    return text


def _starts_with(first: ast.Expr, key: str) -> bool:
    """`speed <= 2`: the comparison begins with the key itself."""
    match first:
        case ast.Comparison(operands=(ast.Name(text=text), *_)):
            return text == key
        case ast.Membership(subject=ast.Name(text=text), relation="in", swept=False):
            return text == key
        case _:
            return False


def _is_chain(first: ast.Expr, key: str) -> bool:
    """`-1 <= vx <= 1`: the comparison holds the key and can't be read as the value of another."""
    if not isinstance(first, ast.Comparison):
        return False
    name = bounded_name(first)
    held = not key.isidentifier() if name is None else name.text == key
    return held and show(first)[0] in "-|(.0123456789"


def _word(arg: ast.Expr) -> str:
    """A value among the words of a property, apart if it begins or ends like an operator."""
    text = compared(arg)
    edges = {*_FIRST_WORD.findall(text), *_LAST_WORD.findall(text)} - {"true", "false"}
    return f"({text})" if text == "x" or edges & word_terminals().keys() else text


def _append(text: str, before: ast.Expr, arg: ast.Expr) -> str:
    word = _word(arg)
    sizes = (ast.Number, ast.List)
    if isinstance(before, sizes) and type(before) is type(arg):
        return f"{text} x {word}"
    unit = isinstance(arg, ast.Name) and arg.text in UNITS and _ENDS_IN_NUMBER.search(text)
    if unit or word.startswith("-"):
        word = f"({word})"
    return f"{text} {word}"
