"""Programs of the intermediate representation as text; `parser.py` reads it back.

    horizon 8
    %0 = and([1*r1.state.0 - 8 : m], [-1*r1.state.0 + 9 : m])
    require reach1 >= 0: eventually[0,8](%0)

A sub-formula with several parents is named `%k` on a line of its own, so the text grows with the
DAG and not with the tree.
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Sequence

from stlc.ir.networks import Count, Network
from stlc.ir.nodes import (
    Always,
    And,
    Const,
    Eventually,
    Iff,
    Implies,
    Linear,
    Link,
    Node,
    Not,
    Or,
    Release,
    Signal,
    Timed,
    Until,
)
from stlc.ir.requirement import Requirement
from stlc.ir.rewrite import postorder

_PLAIN = re.compile(r"[A-Za-z_]\w*\Z")
_LONGEST = 2000  # characters; longer texts are named too, so that no line grows without end

_WORDS = {
    Not: "not",
    And: "and",
    Or: "or",
    Implies: "implies",
    Iff: "iff",
    Timed: "timed",
    Always: "always",
    Eventually: "eventually",
    Until: "until",
    Release: "release",
}


def print_program(requirements: Sequence[Requirement], horizon: int) -> str:
    """Text of all requirements and the horizon; ends with a newline."""
    lines = [f"horizon {horizon}"]
    texts = _texts([r.formula for r in requirements], lines)
    lines += [
        f"require {_name(r.name)} >= {_number(r.margin)}: {texts[r.formula]}" for r in requirements
    ]
    return "\n".join(lines) + "\n"


def print_node(root: Node) -> str:
    """Text of one formula, its shared parts on lines before it."""
    lines: list[str] = []
    texts = _texts([root], lines)
    return "\n".join([*lines, texts[root]])


def _texts(roots: Sequence[Node], lines: list[str]) -> dict[Node, str]:
    """Text of each node; those used twice, or long ones, get a line `%k = ...` in `lines` and a
    name."""
    order = list(postorder(roots))
    parents = Counter(child for node in order for child in node.children)
    texts: dict[Node, str] = {}
    named = 0
    for node in order:
        text = _text(node, texts)
        composed = bool(node.children)
        if composed and (parents[node] > 1 or (parents[node] and len(text) > _LONGEST)):
            lines.append(f"%{named} = {text}")
            text = f"%{named}"
            named += 1
        texts[node] = text
    return texts


def _text(node: Node, texts: dict[Node, str]) -> str:
    """One node over the texts of its children."""
    match node:
        case Const(value):
            return "true" if value else "false"
        case Linear():
            return _linear(node)
        case Link():
            return _link(node)
    if isinstance(node, Count | Network):
        return _network(node, texts)
    head = _WORDS[type(node)]  # type names are closed: every other node has children
    if isinstance(node, Always | Eventually | Until | Release):
        head += f"[{node.start},{'inf' if node.end is None else node.end}]"
    return f"{head}({', '.join(texts[c] for c in node.children)})"


def _network(node: Count | Network, texts: dict[Node, str]) -> str:
    """`count[2](f, g, h)`, `count[5](3 f, 2 g)` with weights; `joined[3 : a, b](0 1 f, ..)`: hops,
    vertices, edges with their ends."""
    if isinstance(node, Count):
        weights = (f"{w} " for w in node.weights) if node.weights else ("",) * len(node.args)
        parts = (f"{w}{texts[c]}" for w, c in zip(weights, node.args, strict=True))
        return f"count[{node.least}]({', '.join(parts)})"
    word = ("relayed" if node.composed else "joined", "unrelayed" if node.composed else "parted")
    hops = "" if node.hops is None else f"{node.hops} : "
    edges = (f"{a} {b} {texts[c]}" for (a, b), c in zip(node.ends, node.args, strict=True))
    names = ", ".join(map(_name, node.vertices))
    return f"{word[node.cut]}[{hops}{names}]({', '.join(edges)})"


def _linear(node: Linear) -> str:
    terms = [f"{_number(value)}*{_signal(signal)}" for signal, value in node.terms]
    unit = f" : {node.unit}" if node.unit else ""
    return f"[{' + '.join([*terms, _number(node.constant)])}{unit}]"


def _signal(signal: Signal) -> str:
    shift = f"@{signal.shift}" if signal.shift else ""
    return f"{_name(signal.owner)}.{signal.role.value}.{signal.index}{shift}"


def _link(node: Link) -> str:
    chance = "" if node.probability is None else f" p {_number(node.probability)}"
    shift = f" @{node.shift}" if node.shift else ""
    tight = " tight" if node.tight else ""
    factor = "" if node.factor == 1.0 else f" times {_number(node.factor)}"
    ends = f"{_name(node.sender)}, {_name(node.receiver)}"
    return (
        f"link({_name(node.channel)} {node.quantity.value}({ends})"
        f" {node.relation.value} {_number(node.threshold)}{chance}{shift}{factor}{tight})"
    )


def _name(name: str) -> str:
    return name if _PLAIN.match(name) else f'"{name}"'


def _number(value: float) -> str:
    return repr(int(value)) if value == int(value) and abs(value) < 1e15 else repr(float(value))
