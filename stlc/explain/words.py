"""Formulas in a few words of the mission, whatever names stand in between in the file."""

from __future__ import annotations

from stlc.explain.weaken import is_atom
from stlc.ir.nodes import (
    Always,
    And,
    Eventually,
    Linear,
    Link,
    Motion,
    Node,
    Not,
    Or,
    Quantity,
    Until,
    walk,
)
from stlc.ir.nodes import Swept as SweptClaim
from stlc.ir.requirement import Requirement
from stlc.source import Span
from stlc.verify.robustness import unit

_UNITS = {Quantity.RSSI: " dBm", Quantity.SNR: " dB"}


def said(node: Node) -> str:
    """`r1 in goal1`, `rssi(r1, r2) >= -37 dBm`; else the text in the file."""
    if isinstance(node, Link):
        return link_words(node)
    if node.member is not None and isinstance(node.member.subject, str):
        word = "in" if node.member.inside else "outside"
        return f"{node.member.subject} {word} {node.member.place}"
    if node.swept is not None and node.swept.motion is not Motion.CONDITION:
        return _swept(node.swept)
    if isinstance(node, And) and not is_atom(node):  # perhaps fewer than the text has
        return " and ".join(said(part) for part in node.args)
    if isinstance(node, Until):
        return f"({said(node.left)}) until {said(node.right)}"
    return "a part of it" if node.span is None else " ".join(node.span.text.split())


def parts_of(piece: Requirement) -> tuple[Node, ...]:
    """What a piece asks for at one and the same step, where that is more than one thing; both sides
    of an `until`, which meet at its last step."""
    body = body_of(piece.formula)
    if isinstance(body, Until):
        return body.left, body.right
    return body.args if isinstance(body, And) and not is_atom(body) else ()


def link_words(link: Link) -> str:
    """A link predicate with its ends' own names."""
    value = f"{link.quantity.value}({link.sender}, {link.receiver})"
    text = f"{value} {link.relation.value} {link.threshold:g}{_UNITS.get(link.quantity, '')}"
    return text if link.probability is None else f"P({text}) >= {link.probability:g}"


def _swept(claim: SweptClaim) -> str:
    match claim.motion:
        case Motion.SEPARATION:
            return f"the swept separation of {claim.agent} and {claim.other}"
        case _:
            return f"{claim.agent} {claim.motion.value} {claim.place} (swept)"


def body_of(node: Node) -> Node:
    """What a formula asks for in the end, below its temporal operators."""
    while True:
        match node:
            case Always(arg=arg) | Eventually(arg=arg):
                node = arg
            case Not(arg=Always() | Eventually() as arg):
                node = arg
            case _:
                return node


def steps_of(piece: Requirement) -> tuple[int, int | None] | None:
    """The window of the outermost operator."""
    formula = piece.formula
    if isinstance(formula, Always | Eventually | Until):
        return formula.start, formula.end
    return None


def when(piece: Requirement) -> str:
    """` at step 4`, ` at steps 2 to 5`, ` by step 8`; nothing for all steps."""
    steps = steps_of(piece)
    if steps is None:
        return " at step 0" if not piece.formula.children or body_of(piece.formula).member else ""
    first, last = steps
    if isinstance(piece.formula, Always):
        if last is None:
            return "" if first == 0 else f" from step {first} on"
        return f" at step {first}" if first == last else f" at steps {first} to {last}"
    return " at some step" if last is None else f" by step {last}"


def clause(piece: Requirement) -> str:
    """A piece of a conflict: what it says, and when."""
    body = body_of(piece.formula)
    text = " ".join(body.span.text.split()) if isinstance(body, Or) and body.span else said(body)
    return f"`{text}`{when(piece)}"


def unit_of(node: Node) -> str:
    """The unit of the predicates of a formula, where they share one."""
    units = {unit(n) for n in walk(node) if isinstance(n, Linear | Link)}
    return units.pop() if len(units) == 1 else ""


def place(span: Span | None) -> dict[str, object] | None:
    """A place for JSON: file, line, column, text."""
    if span is None:
        return None
    return {
        "file": span.source.name, "line": span.line, "column": span.column, "text": span.text,
    }  # fmt: skip
