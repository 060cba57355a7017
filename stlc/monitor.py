"""Monitoring of recorded signals: robustness and satisfaction over time, by sub-formula."""

from __future__ import annotations

import csv
import difflib
import io
import json
import math
import os
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from itertools import islice
from typing import Any

import numpy as np
from numpy.typing import NDArray

from stlc.errors import UsageError
from stlc.ir.nodes import Linear, Link, Node, Role, Signal, walk
from stlc.ir.requirement import Requirement
from stlc.mission import Mission
from stlc.recording import Recording, read_recording
from stlc.source import Span
from stlc.verify.robustness import TOLERANCE, Evaluator
from stlc.verify.trace import Trace

Array = NDArray[np.float64]

MOST_PARTS = 1000
"""Sub-formulas reported for one formula, parents first."""

MOST_TEXT = 160


@dataclass(frozen=True, slots=True, eq=False)
class Part:
    """A sub-formula: its text and place in the file, its depth, its robustness (L,)."""

    text: str
    span: Span | None
    depth: int
    robustness: Array


@dataclass(frozen=True, slots=True, eq=False)
class Monitored:
    """One formula: robustness (L,) at the steps where it can be judged, its parts below it."""

    name: str
    margin: float
    robustness: Array
    parts: tuple[Part, ...]

    @property
    def satisfied(self) -> NDArray[np.bool_]:
        """Whether it holds at each step (L,): robustness >= margin - 1e-6."""
        return self.robustness >= self.margin - TOLERANCE


@dataclass(frozen=True, slots=True, eq=False)
class MonitorReport:
    """What was found on a recording."""

    recording: str
    times: Array
    formulas: tuple[Monitored, ...]

    @property
    def ok(self) -> bool:
        """Every formula can be judged and holds at the first sample."""
        return all(len(f.robustness) and bool(f.satisfied[0]) for f in self.formulas)

    def text(self) -> str:
        """A table for a person: the verdict at the first sample, and how often it holds."""
        width = max([len(f.name) for f in self.formulas], default=0)
        return "\n".join(_line(f, width, self.times) for f in self.formulas)

    def as_dict(self, *, parts: bool = True) -> dict[str, Any]:
        """Plain JSON values; infinite numbers are "inf" and "-inf"."""
        return {
            "recording": self.recording,
            "samples": len(self.times),
            "satisfied": self.ok,
            "formulas": [_as_dict(f, parts) for f in self.formulas],
        }

    def to_json(self, *, parts: bool = True) -> str:
        """`as_dict` as JSON."""
        return json.dumps(self.as_dict(parts=parts), allow_nan=False) + "\n"

    def to_csv(self) -> str:
        """Columns time, then robustness and satisfaction (1 or 0) of each formula.

        Cells are empty where a formula can't be judged.
        """
        out = io.StringIO()
        writer = csv.writer(out, lineterminator="\n")
        names = [f.name for f in self.formulas]
        writer.writerow(["time", *(c for n in names for c in (n, f"{n} satisfied"))])
        for row, time in enumerate(self.times.tolist()):
            writer.writerow([time, *(cell for f in self.formulas for cell in _cells(f, row))])
        return out.getvalue()


def monitor(mission: Mission, trace: str | os.PathLike[str]) -> MonitorReport:
    """Judge every requirement of a file on a recorded CSV at every sample.

    Raises UsageError when the recording can't be read, its steps aren't the file's, or a signal
    is missing.
    """
    return monitor_formulas(mission.requirements, read_recording(trace, mission.step), mission)


def monitor_formulas(
    requirements: Sequence[Requirement], recording: Recording, mission: Mission | None = None
) -> MonitorReport:
    """Judge formulas on a recording; agents' signals (of `mission`) are columns `agent.name`."""
    length = len(recording.times)
    nodes = [node for r in requirements for node in walk(r.formula)]
    signals = _signals(nodes, recording, mission)
    evaluator = Evaluator(Trace(length, signals))
    found = tuple(_monitored(r, evaluator) for r in requirements)
    return MonitorReport(recording.name, recording.times, found)


def _monitored(requirement: Requirement, evaluator: Evaluator) -> Monitored:
    values = evaluator.robustness(requirement.formula)
    parts = []
    for node, depth in islice(_outline(requirement.formula), MOST_PARTS):
        parts.append(Part(_short(node), node.span, depth, evaluator.robustness(node)))
    return Monitored(requirement.name, requirement.margin, values, tuple(parts))


def _outline(root: Node) -> Iterable[tuple[Node, int]]:
    """Distinct sub-formulas below the root, parents first, with their depth."""
    seen: set[int] = set()
    todo = [(child, 1) for child in reversed(root.children)]
    while todo:
        node, depth = todo.pop()
        if id(node) in seen:
            continue
        seen.add(id(node))
        yield node, depth
        todo.extend((child, depth + 1) for child in reversed(node.children))


def _short(node: Node) -> str:
    """A node as the person wrote it, or as the IR prints it, on one line."""
    if node.span is not None:
        text = node.span.source.text[node.span.start : node.span.start + 4 * MOST_TEXT]
        text = text[: node.span.end - node.span.start]
    else:
        from stlc.ir.printer import print_node

        text = print_node(node)
    line = " ".join(text.split())
    return line if len(line) <= MOST_TEXT else line[: MOST_TEXT - 1] + "\N{HORIZONTAL ELLIPSIS}"


def _signals(
    nodes: Iterable[Node], recording: Recording, mission: Mission | None
) -> dict[tuple[str, Role], Array]:
    """The recording's columns as the signals of formulas."""
    used: dict[tuple[str, Role], dict[int, str]] = {}
    for node in nodes:
        if isinstance(node, Link):
            raise UsageError(
                f"{node.quantity.value}({node.sender}, {node.receiver}) can't be monitored: "
                "record it and declare it as a signal"
            )
        for signal, _ in node.terms if isinstance(node, Linear) else ():
            used.setdefault((signal.owner, signal.role), {})[signal.index] = _column(
                signal, mission
            )
    missing = {c for names in used.values() for c in names.values()} - set(recording.columns)
    if missing:
        raise UsageError(_missing(recording, sorted(missing)))
    return {key: _stack(names, recording, key[1]) for key, names in used.items()}


def _stack(names: Mapping[int, str], recording: Recording, role: Role) -> Array:
    """(N, width); inputs without a value at the last step end there, as those of a plan do."""
    table = np.full((len(recording.times), max(names) + 1), np.nan)
    ends = False
    for index, name in names.items():
        table[:, index] = recording.columns[name]
        ends |= bool(np.isnan(table[-1, index]))
        if ends and role is not Role.INPUT:
            raise UsageError(f"{recording.name}: {name} has no value at the last step")
    return table[:-1] if ends else table


def _column(signal: Signal, mission: Mission | None) -> str:
    """Name of a signal's column: its own, or `agent.name`."""
    if signal.role is Role.FREE or mission is None or signal.owner not in mission.agents:
        return signal.owner
    model = mission.agents[signal.owner].dynamics
    names = model.states if signal.role is Role.STATE else model.inputs
    return f"{signal.owner}.{names[signal.index]}"


def _missing(recording: Recording, names: Sequence[str]) -> str:
    hints = [difflib.get_close_matches(n, recording.columns, 1) for n in names]
    listed = ", ".join(
        f"'{n}'" + (f" (is it '{near[0]}'?)" if near else "")
        for n, near in zip(names, hints, strict=True)
    )
    return f"{recording.name} has no column {listed}; it has {', '.join(recording.columns)}"


def _line(formula: Monitored, width: int, times: Array) -> str:
    """One formula's verdict at the first sample, and where it first fails."""
    if not len(formula.robustness):
        return f"--  {formula.name:<{width}}  can't be judged: the recording is too short"
    holds = formula.satisfied
    mark = "ok " if holds[0] else "NO "
    lost = np.flatnonzero(~holds)
    tail = f"; first fails at {times[lost[0]]:g} s" if len(lost) else ""
    return (
        f"{mark} {formula.name:<{width}}  robustness {formula.robustness[0]:.6g}"
        f"  holds at {int(holds.sum())} of {len(holds)} samples{tail}"
    )


def _as_dict(formula: Monitored, parts: bool) -> dict[str, Any]:
    """One formula as `stlc monitor --json` prints it."""
    found: dict[str, Any] = {
        "name": formula.name,
        "margin": formula.margin,
        "robustness": _plain(formula.robustness),
        "satisfied": formula.satisfied.tolist(),
    }
    if parts:
        found["parts"] = [
            {
                "text": p.text,
                "line": p.span.line if p.span else None,
                "column": p.span.column if p.span else None,
                "depth": p.depth,
                "robustness": _plain(p.robustness),
            }
            for p in formula.parts
        ]
    return found


def _plain(values: Array) -> list[Any]:
    return [v if math.isfinite(v) else str(v) for v in values.tolist()]


def _cells(formula: Monitored, row: int) -> tuple[object, object]:
    if row >= len(formula.robustness):
        return "", ""
    return float(formula.robustness[row]), int(formula.satisfied[row])
