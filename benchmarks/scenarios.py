"""Reads stlpy's benchmark scenarios (JSON) as missions: maximise the robustness of one formula.

stlpy's `a U[t1,t2] b` wants `a` only before the step at which `b` holds; ours wants it there too.
The restatement is `b or (a until[0,t2-1] next b)`, exact at every run (t1 = 0).
"""

from __future__ import annotations

import json
import re
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np

from stlc.ir.nodes import Always, And, Eventually, Linear, Node, Not, Or, Role, Signal, Until
from stlc.ir.rewrite import rewrite
from stlc.mission import Agent, Dynamics, Mission, ObjectiveTerm, Requirement, TermKind
from stlc.source import Source

_TOKEN = re.compile(r"\s*(?:([GFU])\[(\d+),(\d+)\]|(\w+)|([!&|()]))")


def load(path: Path) -> Mission:
    """The mission of one scenario file."""
    return mission(json.loads(path.read_text()))


def mission(data: Mapping[str, Any]) -> Mission:
    """The mission of one scenario."""
    regions = {name: box_formula(box) for name, box in data["regions"].items()}
    formula = _Formula(data["formula"], regions).conjunction()
    bounds = {k: np.asarray(v, dtype=float) for k, v in data["bounds"].items()}
    dynamics = _dynamics(data["dynamics"])
    agent = Agent(
        "robot", dynamics, bounds["x0"], bounds["x_min"], bounds["x_max"],
        bounds["u_min"], bounds["u_max"], np.zeros(4), np.zeros(2),
    )  # fmt: skip
    parts = formula.args if isinstance(formula, And) else (formula,)
    requirements = tuple(Requirement(f"r{k}", part) for k, part in enumerate(parts))
    goal = ObjectiveTerm(TermKind.ROBUSTNESS, -1.0)
    source = Source(data["name"], data["formula"])
    return Mission(
        source, data["dt"], data["T"], None, {"robot": agent}, {}, {}, {}, {}, requirements, (goal,)
    )


def _dynamics(data: Mapping[str, Any]) -> Dynamics:
    A, B = np.asarray(data["A"], dtype=float), np.asarray(data["B"], dtype=float)
    return Dynamics(
        "double_integrator", A, B, np.zeros(len(A)), tuple(data["state"]), tuple(data["input"]),
        ("m", "m", "m/s", "m/s"), ("m/s^2", "m/s^2"), np.eye(2, 4), (2, 3),
    )  # fmt: skip


def box_formula(box: Mapping[str, float]) -> Node:
    """(x >= xmin) and (x <= xmax) and (y >= ymin) and (y <= ymax)."""
    sides = [(0, 1.0, -box["xmin"]), (0, -1.0, box["xmax"])]
    sides += [(1, 1.0, -box["ymin"]), (1, -1.0, box["ymax"])]
    return And(tuple(Linear(((_position(i), a),), c, "m") for i, a, c in sides))


def _position(index: int) -> Signal:
    return Signal("robot", Role.STATE, index)


def following(node: Node) -> Node:
    """The formula one step later."""

    def visit(part: Node) -> Node:
        if not isinstance(part, Linear):
            return part
        moved = tuple((replace(s, shift=s.shift + 1), a) for s, a in part.terms)
        return replace(part, terms=moved)

    return rewrite([node], visit)[0]


@dataclass(slots=True)
class _Formula:
    text: str
    regions: Mapping[str, Node]
    place: int = field(default=0)

    def _next(self) -> re.Match[str] | None:
        return _TOKEN.match(self.text, self.place)

    def _take(self) -> re.Match[str]:
        found = self._next()
        if found is None:
            raise ValueError(f"cannot read the formula at {self.text[self.place :]!r}")
        self.place = found.end()
        return found

    def _skip(self, mark: str) -> bool:
        found = self._next()
        if found is None or found.group(5) != mark:
            return False
        self.place = found.end()
        return True

    def conjunction(self) -> Node:
        parts = [self.disjunction()]
        while self._skip("&"):
            parts.append(self.disjunction())
        return And(tuple(parts)) if len(parts) > 1 else parts[0]

    def disjunction(self) -> Node:
        parts = [self.until()]
        while self._skip("|"):
            parts.append(self.until())
        return Or(tuple(parts)) if len(parts) > 1 else parts[0]

    def until(self) -> Node:
        left = self.unary()
        found = self._next()
        if found is None or found.group(1) != "U":
            return left
        self._take()
        right, end = self.unary(), int(found.group(3))
        return Or((right, Until(left, following(right), 0, end - 1)))

    def unary(self) -> Node:
        found = self._take()
        operator, start, end, name, mark = found.groups()
        if operator in ("G", "F"):
            build = Always if operator == "G" else Eventually
            return build(self.unary(), int(start), int(end))
        if mark == "!":
            return Not(self.unary())
        if mark == "(":
            inner = self.conjunction()
            self._skip(")")
            return inner
        return self.regions[name]
