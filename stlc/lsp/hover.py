"""What an editor tells of the word under the pointer."""

from __future__ import annotations

import re

import numpy as np

from stlc.lsp.document import Document
from stlc.lsp.index import Occurrence
from stlc.lsp.words import SIGNALS, STATEMENTS, WORDS
from stlc.mission import Agent, Mission
from stlc.source import Span

_WORD = re.compile(r"[^\W\d]\w*")


def word_at(text: str, offset: int) -> tuple[str, int, int] | None:
    """The word at an offset (its end included): itself, start, end."""
    line = text.rfind("\n", 0, offset) + 1
    end = text.find("\n", offset)
    for match in _WORD.finditer(text, line, len(text) if end < 0 else end):
        if match.start() <= offset <= match.end():
            return match[0], match.start(), match.end()
    return None


def hover(document: Document, offset: int) -> tuple[str, Span] | None:
    """Markdown, and the place that it is about; None where nothing is known."""
    found = word_at(document.text, offset)
    if found is None:
        return None
    word, start, end = found
    span = document.source.span(start, end)
    said = _member(document, word, start)
    if said is None:
        one = document.index.at(offset)
        said = _declared(document, one) if one is not None else None
    if said is None:
        said = WORDS.get(word) or STATEMENTS.get(word)
    return None if said is None else (said, span)


def _declared(document: Document, one: Occurrence) -> str | None:
    """The statement that declares a name, and what is known of it."""
    if one.owner is not None:
        first = document.index.same(one)[0]
        return f"`{one.name}`, bound in line {first.span.line}"
    span = declaration(document, one.name)
    if span is None:
        return None
    facts = "" if document.mission is None else _facts(document.mission, one.name)
    return f"```stl\n{span.text}\n```" + (f"\n\n{facts}" if facts else "")


def declaration(document: Document, name: str) -> Span | None:
    """The statement that declares a name, here or in an imported file."""
    for index in (document.index, *(i.index for i in document.imports)):
        if name in index.declarations:
            return index.declarations[name].span
    return None


def _facts(mission: Mission, name: str) -> str:
    """What checking found of a name."""
    if name in mission.agents:
        return _agent(mission.agents[name])
    if name in mission.channels:
        channel = mission.channels[name]
        return f"{len(channel.partition.boxes)} cells, cost `{channel.cost}`"
    if name in mission.obstacles:
        obstacle = mission.obstacles[name]
        moves = ", moving" if len(obstacle.frames) > 1 else ""
        return f"{len(obstacle.bodies[0])} convex pieces{moves}"
    if name in mission.regions:
        return f"{len(mission.regions[name].pieces)} convex pieces"
    if any(r.name == name for r in mission.requirements):
        return f"judged over steps 0 to {mission.horizon} of {mission.step:g} s"
    return ""


def _agent(agent: Agent) -> str:
    """States and inputs with their units and bounds; of a robot its tube."""
    model = agent.dynamics
    rows = [
        *zip(model.states, model.state_units, agent.state_lower, agent.state_upper, strict=True),
        *zip(model.inputs, model.input_units, agent.input_lower, agent.input_upper, strict=True),
    ]
    said = [f"- `{name}`{_measure(unit, low, high)}" for name, unit, low, high in rows]
    if agent.robot is not None:
        robot = agent.robot
        said.append(
            f"- a {robot.kind.value} within {robot.radius:.4g} m of its plan, which is that of a "
            f"point {robot.lookahead:.4g} m ahead, at most {robot.planned_speed:.4g} m/s fast"
        )
    return "\n".join(said)


def _measure(unit: str, low: float, high: float) -> str:
    text = f" [{unit}]" if unit else ""
    if np.isfinite(low) or np.isfinite(high):
        text += f" from {low:g} to {high:g}"
    return text


def _member(document: Document, word: str, start: int) -> str | None:
    """What `word` is behind the dot of an agent or a family's member."""
    owner = re.search(r"([^\W\d]\w*(?:\[[^\]\n]*\])?)\.$", document.text[:start])
    if owner is None:
        return None
    base = owner[1].partition("[")[0]
    if document.mission is not None:
        for agent in agents_named(document.mission, base):
            model = agent.dynamics
            if word in model.states:
                k = model.states.index(word)
                bounds = _measure(model.state_units[k], agent.state_lower[k], agent.state_upper[k])
                return f"state `{word}` of `{base}`{bounds}"
            if word in model.inputs:
                k = model.inputs.index(word)
                bounds = _measure(model.input_units[k], agent.input_lower[k], agent.input_upper[k])
                return f"input `{word}` of `{base}`{bounds}"
            if word in model.outputs:
                return f"output `{word}` of `{base}`"
    return SIGNALS.get(word)


def agents_named(mission: Mission, base: str) -> list[Agent]:
    """The agent of a name, the members of a family; of any other name (a variable) all agents."""
    if base in mission.agents:
        return [mission.agents[base]]
    family = [a for name, a in mission.agents.items() if name.startswith(f"{base}[")]
    return family or list(mission.agents.values())
