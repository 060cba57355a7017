"""Predicates on disturbed agents, so strict that they hold wherever in its tube each agent is.

    c + sum f_i y_i(t_i) >= 0    becomes    c - sum |f_i| d_i(t_i) + sum f_i y_i(t_i) >= 0

with d_i(t) the half width of the tube of signal i at step t (`stlc.analysis.tubes`; of an input
with the disturbance itself). Predicates stand positively only, so that what holds of them holds of
the formula: every run within the tubes satisfies it.

Needs: unroll. Guarantees: runs that satisfy the new formulas satisfy the old ones, and so do all
runs within the tubes around them. A mission without disturbances stays as it is.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

from stlc.analysis.tubes import spreads
from stlc.arrays import Floats
from stlc.ir.nodes import Linear, Node, Role
from stlc.ir.rewrite import rewrite
from stlc.ir.verify import Stage
from stlc.passes.base import Pass, Program

Widths = Mapping[tuple[str, Role], Floats]


def run(program: Program) -> Program:
    """Tighten every requirement."""
    widths: dict[tuple[str, Role], Floats] = {}
    for name, agent in program.mission.agents.items():
        found = spreads(agent, program.horizon)
        if found is not None and agent.tube is not None:
            widths[name, Role.STATE] = found[0]
            widths[name, Role.INPUT] = found[1] + agent.tube.bound
    if not widths:
        return program
    return program.with_formulas(rewrite(program.formulas, lambda node: _strict(node, widths)))


def _strict(node: Node, widths: Widths) -> Node:
    if not isinstance(node, Linear):
        return node
    off = sum(
        abs(factor) * float(widths[s.owner, s.role][s.shift, s.index])
        for s, factor in node.terms
        if (s.owner, s.role) in widths
    )
    return replace(node, constant=node.constant - off) if off else node


PASS = Pass("tubes", run, after=("unroll",), stage=Stage.STEPS, lowering=True)
