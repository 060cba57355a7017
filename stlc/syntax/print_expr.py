"""Expressions and shapes as text in the one style of `stlc fmt`.

Parentheses stand where the grammar needs them, and where readers of other tools would group
differently (the places that W0101 warns about), so that printing never hides a meaning.
"""

from __future__ import annotations

from typing import Final

from stlc.syntax import ast
from stlc.syntax.mixes import unclear
from stlc.syntax.neighbours import word_terminals

_IFF, _IMPLIES, _OR, _AND, _UNTIL, _UNARY, _MEMBER, _COMPARE = range(1, 9)
_SUM, _PRODUCT, _SIGNED, _POWER, _POSTFIX = range(9, 14)
_LOGICAL: Final = {"iff": _IFF, "implies": _IMPLIES, "or": _OR, "and": _AND}
_ARITHMETIC: Final = {"+": _SUM, "-": _SUM, "*": _PRODUCT, "/": _PRODUCT, "^": _POWER}


def level(node: ast.Expr) -> int:
    """How tightly the node's outermost operator binds."""
    match node:
        case ast.Logical():
            return _LOGICAL[node.operator]
        case ast.TemporalPair():
            return _UNTIL
        case ast.Quantifier(kind="count"):
            return _POSTFIX
        case ast.Not() | ast.Temporal() | ast.Quantifier():
            return _UNARY
        case ast.Membership() | ast.Swept():
            return _MEMBER
        case ast.Comparison():
            return _COMPARE
        case ast.Arithmetic():
            return _ARITHMETIC[node.operator]
        case ast.Negate():
            return _SIGNED
        case ast.Range():
            return 0
        case _:
            return _POSTFIX


def show(node: ast.Expr) -> str:
    """The expression as text."""
    match node:
        case ast.Number():
            return f"{node.text} {node.unit}" if node.unit else node.text
        case ast.String():
            return quoted(node)
        case ast.Bool():
            return "true" if node.value else "false"
        case ast.Name():
            return show_name(node.text)
        case ast.Attribute():
            return f"{_attribute_base(node.base)}.{node.attr.text}"
        case ast.Index():
            return f"{_base(node.base)}[{show_list(node.indices)}]"
        case ast.Call():
            return f"{node.function.text}({show_list(node.args)})"
        case ast.Tuple():
            return f"({show_list(node.items)})"
        case ast.List():
            return f"[{show_list(node.items)}]"
        case ast.Absolute():
            return f"|{show(node.arg)}|"
        case ast.Range():
            return f"{_at(node.start, _SUM)}..{_at(node.end, _SUM)}"
        case _:
            return _show_operator(node)


def _show_operator(node: ast.Expr) -> str:
    """An operator with operands in no more parentheses than its precedence needs."""
    match node:
        case ast.Negate():
            return f"-{_at(node.arg, _POWER)}"
        case ast.Arithmetic():
            return _arithmetic(node)
        case ast.Comparison():
            return _comparison(node)
        case ast.Membership():
            swept = " swept" if node.swept else ""
            place = _at(node.place, _SUM)
            return f"{_at(node.subject, _SUM)} {node.relation} {place}{swept}"
        case ast.Swept():
            return f"{_at(node.arg, _COMPARE)} swept"
        case ast.Not():
            return f"not {_at(node.arg, _UNARY)}"
        case ast.Temporal():
            operator = node.operator + _interval(node.interval)
            return _beside(operator, _at(node.arg, _UNARY))
        case ast.TemporalPair():
            return _pair(node)
        case ast.Logical():
            return _logical(node)
        case ast.Quantifier():
            return _quantifier(node)
        case _:
            raise AssertionError(node)


def quoted(node: ast.String) -> str:
    """A string with its quotes."""
    inner = node.value.replace("\\", "\\\\").replace('"', '\\"')
    return f'"{inner}"'


def show_name(text: str) -> str:
    """A name; one that is also an operator's word is kept apart by parentheses."""
    return f"({text})" if len(text) > 1 and text in word_terminals() else text


def show_list(items: tuple[ast.Expr, ...]) -> str:
    """Expressions joined by commas, without brackets."""
    return ", ".join(map(show, items))


def _at(node: ast.Expr, least: int) -> str:
    """The node, in parentheses if it binds less tightly than `least`."""
    loose = level(node) < least or (isinstance(node, ast.Quantifier) and node.kind == "sum")
    return f"({show(node)})" if loose else show(node)


def _base(node: ast.Expr) -> str:
    if isinstance(node, ast.Name):
        return f"({node.text})" if node.text in word_terminals() else node.text
    named = isinstance(node, ast.Attribute | ast.Index | ast.Call)
    return show(node) if named else f"({show(node)})"


def _attribute_base(node: ast.Expr) -> str:
    return show(node) if isinstance(node, ast.Name) else _base(node)


def _arithmetic(node: ast.Arithmetic) -> str:
    if node.operator == "^":
        plain = not isinstance(node.left, ast.Number) or node.left.unit is None
        base = _at(node.left, _POSTFIX) if plain else f"({show(node.left)})"
        return f"{base}^{_at(node.right, _SIGNED)}"
    return _chain(node.spine)


def _chain(links: list[ast.Arithmetic]) -> str:
    """Operations from the left; brackets that open before the first operand are counted."""
    powers = [k for k, link in enumerate(links) if link.operator == "^"]
    links = links[powers[-1] + 1 :] if powers else links
    opened, inner = 0, links[0].left
    parts = [_at(inner, level(links[0]))]
    for link in links:
        if link is not links[0] and level(inner) < level(link):
            opened += 1
            parts.append(")")
        parts.append(f" {link.operator} {_at(link.right, level(link) + 1)}")
        inner = link
    return "(" * opened + "".join(parts)


def compared(node: ast.Expr) -> str:
    """The expression as text, in parentheses if it binds less tightly than a comparison."""
    return _at(node, _COMPARE)


def _comparison(node: ast.Comparison) -> str:
    text = _at(node.operands[0], _SUM)
    for operator, operand in zip(node.operators, node.operands[1:], strict=True):
        text += f" {operator} {_at(operand, _SUM)}"
    return text


def _interval(interval: ast.Interval | None) -> str:
    if interval is None:
        return ""
    if interval.start is interval.end and isinstance(interval.start, ast.Name):
        return f"[{interval.start.text}]"  # `[end, end]` would be no step
    end = show(interval.end) if interval.end is not None else "end"
    return f"[{show(interval.start)}, {end}]"


def _beside(operator: str, arg: str) -> str:
    """A temporal operator and what it applies to; a list must not look like its interval."""
    return f"{operator} ({arg})" if arg[0] == "[" and operator[-1] != "]" else f"{operator} {arg}"


def open_right(node: ast.Expr) -> bool:
    """Whether the text ends with a quantifier's body, which would swallow what follows."""
    match node:
        case ast.Quantifier(kind=kind):
            return kind != "count"
        case ast.Not() | ast.Temporal():
            return open_right(node.arg)
        case ast.TemporalPair():
            return open_right(node.right)
        case ast.Logical():
            return open_right(node.args[-1])
        case _:
            return False


def _pair(node: ast.TemporalPair) -> str:
    apart = isinstance(node.left, ast.Not | ast.Temporal) or open_right(node.left)
    left = f"({show(node.left)})" if apart else _at(node.left, _UNARY)
    operator = node.operator + _interval(node.interval)
    return f"{left} {_beside(operator, _at(node.right, _UNARY))}"


def logical_parts(node: ast.Logical) -> list[str]:
    """The operands of a connective, with their parentheses."""
    return [_operand(node, position) for position in range(len(node.args))]


def _operand(node: ast.Logical, position: int) -> str:
    arg = node.args[position]
    last = position == len(node.args) - 1
    least = _LOGICAL[node.operator] + (node.operator != "iff" or position > 0)
    mixed = isinstance(arg, ast.Logical) and {arg.operator, node.operator} == {"and", "or"}
    if mixed or unclear(node, position) or (open_right(arg) and not last):
        return f"({show(arg)})"
    return _at(arg, least)


def _logical(node: ast.Logical) -> str:
    return f" {node.operator} ".join(logical_parts(node))


def _quantifier(node: ast.Quantifier) -> str:
    """`forall`, `exists` and `sum` over a domain; `count(..)` in the brackets of a call."""
    names = ", ".join(variable.text for variable in node.variables)
    variables = f"({names})" if len(node.variables) > 1 else names
    least = _SUM if not isinstance(node.domain, ast.Range) else 0
    domain = _at(node.domain, least)
    body = show(node.body)
    if node.kind == "count":
        return f"count({variables} in {domain}: {body})"
    if node.kind == "sum" and level(node.body) < _SUM:
        body = f"({body})"
    return f"{node.kind} {variables} in {domain}: {body}"
