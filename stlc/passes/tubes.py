"""Predicates on disturbed agents and robots, so strict that they hold wherever in its tube each is.

    c + sum f_i y_i(t_i) >= 0    becomes    c - sum |f_i| d_i(t_i) + sum f_i y_i(t_i) >= 0

with d_i(t) the half width of the tube of signal i at step t (`stlc.analysis.tubes`; of an input
with the disturbance itself). Where a robot is in a disc of radius r, both coordinates at one step
together take sqrt(f_x^2 + f_y^2) r. Predicates stand positively only, so that what holds of them
holds of the formula: every run within the tubes satisfies it.

Needs: unroll. Guarantees: runs that satisfy the new formulas satisfy the old ones, and so do all
runs within the tubes around them, between the steps too where it is a disc. A mission without
disturbances and robots stays as it is.
"""

from __future__ import annotations

from dataclasses import replace

from stlc.analysis.tubes import Tubes
from stlc.ir.nodes import Linear, Node
from stlc.ir.rewrite import rewrite
from stlc.ir.verify import Stage
from stlc.passes.base import Pass, Program


def run(program: Program) -> Program:
    """Tighten every requirement."""
    tubes = Tubes.of(program.mission.agents, program.horizon)
    if not tubes:
        return program

    def strict(node: Node) -> Node:
        if not isinstance(node, Linear):
            return node
        off = tubes.off(node.terms)
        return replace(node, constant=node.constant - off) if off else node

    return program.with_formulas(rewrite(program.formulas, strict))


PASS = Pass("tubes", run, after=("unroll",), stage=Stage.STEPS, lowering=True)
