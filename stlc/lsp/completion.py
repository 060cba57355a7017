"""What may stand where somebody types."""

from __future__ import annotations

import re
from collections.abc import Iterable
from dataclasses import dataclass

from stlc.lsp.document import Document
from stlc.lsp.hover import agents_named
from stlc.lsp.words import SIGNALS, STATEMENTS, WORDS
from stlc.sema.agents import PROPERTIES as OF_AGENTS
from stlc.sema.channels import PROPERTIES as OF_CHANNELS
from stlc.sema.dynamics import STRUCTURE as OF_DYNAMICS
from stlc.sema.integrators import KINDS, ROBOTS
from stlc.sema.robots import PROPERTIES as OF_ROBOTS
from stlc.syntax import ast


@dataclass(frozen=True, slots=True)
class Offer:
    """A word, what kind of thing it is, and a line about it."""

    text: str
    kind: str  # keyword, function, agent, place, channel, dynamics, value, signal, property
    detail: str = ""


_KINDS: tuple[tuple[type[ast.Statement], str], ...] = (
    (ast.AgentDecl, "agent"), (ast.StationDecl, "agent"), (ast.RegionDecl, "place"),
    (ast.ObstacleDecl, "place"), (ast.WallDecl, "place"), (ast.ChannelDecl, "channel"),
    (ast.DynamicsDecl, "dynamics"),
    (ast.Param, "value"), (ast.Let, "function"), (ast.Require, "value"), (ast.Prefer, "value"),
)  # fmt: skip


def complete(document: Document, offset: int) -> list[Offer]:
    """Offers at an offset; the editor picks those that begin with what is typed."""
    before = document.text[:offset]
    line = before[before.rfind("\n") + 1 :]
    if "#" in line or "//" in line:
        return []
    owner = re.search(r"([^\W\d]\w*)(?:\[[^\]\n]*\])?\.\w*$", line)
    if owner is not None:
        return _members(document, owner[1])
    block = _block(before)
    if block is not None and re.search(r"(?:^|[{;,])\s*\w*$", line):
        return [Offer(word, "property") for word in _properties(document, block, before)]
    if block is None and re.fullmatch(r"\s*\w*", line):
        return [Offer(w, "keyword", text) for w, text in STATEMENTS.items()]
    if re.match(r"\s*(?:agent\s+\S+\s*:|dynamics\s+\w+\s*=)\s*\w*$", line):
        named = [o for o in _names(document) if o.kind == "dynamics"]
        return [*named, *(Offer(w, "dynamics", WORDS[w]) for w in KINDS)]
    return [*_names(document), *(Offer(w, _kind(t), t) for w, t in WORDS.items())]


def _kind(text: str) -> str:
    return "function" if re.match(r"`\w+\(", text) else "keyword"


def _members(document: Document, base: str) -> list[Offer]:
    """Signals behind a dot."""
    found: dict[str, Offer] = {}
    for agent in agents_named(document.mission, base) if document.mission else ():
        model = agent.dynamics
        for name, unit in zip(model.states, model.state_units, strict=True):
            found.setdefault(name, Offer(name, "signal", f"state [{unit}]"))
        for name, unit in zip(model.inputs, model.input_units, strict=True):
            found.setdefault(name, Offer(name, "signal", f"input [{unit}]"))
        for name in model.outputs:
            found.setdefault(name, Offer(name, "signal", "output"))
    for name, text in SIGNALS.items():
        found.setdefault(name, Offer(name, "signal", text))
    return list(found.values())


def _names(document: Document) -> list[Offer]:
    """Names that the file and those it imports declare."""
    found: dict[str, Offer] = {}
    for index in (document.index, *(i.index for i in document.imports)):
        for name, declared in index.declarations.items():
            kind = next(k for cls, k in _KINDS if isinstance(declared.statement, cls))
            found.setdefault(name, Offer(name, kind, declared.span.text.split("\n")[0]))
    return list(found.values())


def _block(before: str) -> str | None:
    """The first word of the statement whose block is open at the end of a text."""
    opened = before.rfind("{")
    if opened < 0 or before.rfind("}") > opened:
        return None
    head = re.search(r"(?:^|[;\n])[ \t]*(agent|station|channel|dynamics)\b[^\n{]*$",
                     before[:opened])  # fmt: skip
    return head[1] if head else None


def _properties(document: Document, block: str, before: str) -> Iterable[str]:
    """Keys of a block; bounds of states and inputs are keys too."""
    if block == "channel":
        return OF_CHANNELS
    if block == "station":
        return ("height",)
    named = re.search(r"agent\s+([^\W\d]\w*)[^\n{]*\{[^{}]*$", before)
    own: list[str] = []
    if named is not None and document.mission is not None:
        for agent in agents_named(document.mission, named[1])[:1]:
            own = [*agent.dynamics.states, *agent.dynamics.inputs]
    structure = tuple(OF_DYNAMICS) if block == "dynamics" else ()
    robot = OF_ROBOTS if _is_robot(document, before) else ()
    return dict.fromkeys([*structure, *OF_AGENTS, *robot, *own])


def _is_robot(document: Document, before: str) -> bool:
    """Whether the block that is open at the end of a text is of a unicycle or a car."""
    head = re.search(r"[:=]\s*([^\W\d]\w*)\s*\{[^{}]*$", before)
    kind = head[1] if head else ""
    declared = document.index.declarations.get(kind)
    if declared is not None and isinstance(declared.statement, ast.DynamicsDecl):
        kind = "" if declared.statement.kind is None else declared.statement.kind.text
    return kind in ROBOTS
