"""Where in its files a mission declares what it gives: properties of blocks, the workspace."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from functools import lru_cache

from stlc.mission import Mission
from stlc.source import Source, Span
from stlc.syntax import ast
from stlc.syntax.parse import parse


@lru_cache(maxsize=8)
def statements(source: Source) -> tuple[ast.Statement, ...]:
    """The statements of one file."""
    return parse(source).file.statements


def place_of(mission: Mission, owner: str | None, keys: Sequence[str]) -> Span | None:
    """The property of an agent (its dynamics' included) or channel with the first of `keys`.

    Without an owner, the workspace.
    """
    if owner is None:
        spaces = (s for s in statements(mission.source) if isinstance(s, ast.Workspace))
        return next((s.span for s in spaces), None)
    return next(iter(places_of(mission, owner, keys)), None)


def places_of(mission: Mission, owner: str, keys: Sequence[str]) -> tuple[Span, ...]:
    """All properties of an agent or a channel with one of `keys`, in the order of the keys."""
    found = list(_properties(mission, owner))
    return tuple(p.span for key in keys for p in found if p.key.text == key)


def _properties(mission: Mission, owner: str) -> Iterator[ast.Property]:
    """Properties of an agent, then of its dynamics; or those of a channel."""
    channel, agent = mission.channels.get(owner), mission.agents.get(owner)
    if channel is not None:
        yield from _block(channel.span, ast.ChannelDecl)
    if agent is not None:
        yield from _block(agent.span, ast.AgentDecl)
        yield from _block(agent.dynamics.span, ast.DynamicsDecl)


Blocks = ast.ChannelDecl | ast.AgentDecl | ast.DynamicsDecl


def _block(name: Span | None, kind: type[Blocks]) -> tuple[ast.Property, ...]:
    """The properties of the declaration whose name stands at a place."""
    for statement in statements(name.source) if name is not None else ():
        if isinstance(statement, kind) and statement.name.span == name:
            return statement.properties
    return ()
