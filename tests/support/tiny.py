"""A registry of missions that take no time, and records made by hand."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

from stlc.bench.job import Config, Job, Limits
from stlc.bench.machine import fingerprint
from stlc.bench.record import Record, record_of

MISSION = """step 1 s
horizon 3
workspace box [0, 10] x [0, 10]
dynamics cart = double_integrator
agent r1 : cart {{ start ({x}, 1); control |u| <= 1; speed <= 2 }}
region goal = box [{x}, {x} + 1] x [2, 3]
require reach: eventually r1 in goal
minimize effort
"""

REGISTRY = """from stlc.bench.problem import Problem, Suite

SUITES = (
    Suite("tiny", "tiny ones", (
        Problem("one", "one.stl", axes={"walk place": 1}, quick=True),
        Problem("two", "two.stl", axes={"walk place": 2}, quick=True),
        Problem("three", "three.stl", axes={"walk place": 3}),
    ), ("auto", "log")),
)
"""


def registry(folder: Path) -> Path:
    """Write it; three problems, two of them quick."""
    fingerprint.cache_clear()  # sources may be edited while a long test session runs
    missions = folder / "missions"
    missions.mkdir(parents=True)
    (folder / "registry.py").write_text(REGISTRY)
    for x, name in enumerate(("one", "two", "three"), 1):
        (missions / f"{name}.stl").write_text(MISSION.format(x=x))
    return folder


def job(
    name: str = "one", config: Config | None = None, limits: Limits | None = None,
    code: str | None = None, text: str | None = None,
) -> Job:  # fmt: skip
    """One run of a tiny mission, by the sources as they are now."""
    fingerprint.cache_clear()
    data = (text or MISSION.format(x=1)).encode()
    return Job(
        "tiny", name, f"{name}.stl", {f"{name}.stl": data}, config or Config(),
        limits or Limits(20.0), 0, code or fingerprint(),
    )  # fmt: skip


def record(
    problem: str, label: str, seconds: float | None, repeat: int = 0, **fields: Any
) -> Record:
    """A finished run; None seconds: the limit of 10 s was reached."""
    known: dict[str, object] = {"status": "feasible"}
    if seconds is not None:
        known = {
            "status": "optimal", "solver_seconds": seconds, "proof": seconds + 1,
            "objective": 1.0, "certified": True, "rows": 10,
        }  # fmt: skip
    made = job(problem, Config(label), Limits(10.0), code="0" * 16)
    base = record_of(made, known | {"finished": "2026-01-01T00:00:00+00:00"})
    return replace(base, repeat=repeat, key=f"{problem}{label}{repeat}", **fields)
