"""What the steps of one agent cost: its effort, and links whose other ends are known."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from stlc.arrays import Floats
from stlc.mission import Agent, Mission, ObjectiveTerm, TermKind
from stlc.solve.routes.moves import Judge


@dataclass(frozen=True, slots=True, eq=False)
class StepCosts:
    """Costs of one agent's steps; weights of normalised costs are taken as they are."""

    mission: Mission
    agent: Agent
    judge: Judge

    def of(self, step: int, after: Floats, inputs: Floats) -> Floats:
        """Cost (N,) of states (N, n) at a step and of the inputs (N, m) that led there."""
        total = np.zeros(len(after))
        for term in self.mission.objective:
            first, last = term.window or (0, self.mission.horizon)
            if term.kind is TermKind.EFFORT and self.agent.name in term.agents:
                if first <= step <= last:
                    total += term.weight * (np.abs(after) @ self.agent.effort_state)
                if first <= step - 1 <= last:
                    total += term.weight * (np.abs(inputs) @ self.agent.effort_input)
            elif term.kind is TermKind.LINK_COST and first <= step <= last:
                total += term.weight * self._links(term, step, after)
        return total

    def _links(self, term: ObjectiveTerm, step: int, after: Floats) -> Floats:
        total, name = np.zeros(len(after)), self.agent.name
        for pair in term.pairs:
            if name in pair and term.channel is not None:
                total += self._link(term.channel, pair, step, after)
        return total

    def _link(self, channel: str, pair: tuple[str, str], step: int, after: Floats) -> Floats:
        table, cells = self.judge.tables.cost(channel, pair), []
        for end in pair:
            found = self.judge.cells_of(channel, end, step, self.agent.name, after)
            if found is not None:
                cells.append(found)
        return table[tuple(cells)] if len(cells) == table.ndim else np.zeros(len(after))

    def per_metre(self, fastest: float) -> float:
        """What costs can differ by while the agent goes a metre, at `fastest` metres a step."""
        agent, spread = self.agent, 0.0
        push = np.maximum(np.abs(agent.input_lower), np.abs(agent.input_upper))
        for term in self.mission.objective:
            if term.kind is TermKind.EFFORT and agent.name in term.agents:
                spread += term.weight * float(agent.effort_input @ push)
            elif term.kind is TermKind.LINK_COST and term.channel is not None:
                for pair in term.pairs:
                    if agent.name in pair:
                        table = self.judge.tables.cost(term.channel, pair)
                        spread += term.weight * float(np.ptp(table)) if table.ndim else 0.0
        return spread / max(fastest, 1e-9)
