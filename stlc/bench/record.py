"""A finished run: every figure kept, as one flat, typed row."""

from __future__ import annotations

import json
from collections.abc import Collection, Mapping
from dataclasses import MISSING, asdict, dataclass, fields
from typing import Any

from stlc.bench.job import Figure, Job

SOLVED = ("optimal", "infeasible")


@dataclass(frozen=True, slots=True)
class Record:
    """Times in seconds, `peak_memory` in bytes; None where a run ended before it was known.

    `status`: optimal, infeasible (both proven), feasible (a plan at the limit), no_plan (none at
    the limit), out_of_time, out_of_memory, refused (a check failed), failed.
    `first_plan` and `proof` count from the first line of the mission read to a plan certified and
    verified; `compile_*` are parts of it. `solver_seconds` is the solver (and strategy) alone,
    `cpu_seconds` the processor time of the same, all threads and child processes together.
    `gap_60` is the relative gap after 60 s of the solver, or at its end if that came before.
    `objective`, `bound`, `lp_bound` and the trace go the way of `sense`, the mission's own.
    `trace` is (seconds of the solver, objective, bound, nodes) over time.
    """

    key: str
    suite: str
    problem: str
    label: str
    encoding: str
    backend: str
    disabled: str
    strategy: str
    repeat: int
    time_limit: float
    gap_limit: float
    threads: int
    memory_limit: int | None
    status: str
    message: str = ""
    objective: float | None = None
    bound: float | None = None
    gap: float | None = None
    nodes: int | None = None
    certified: bool = False
    columns: int | None = None
    binaries: int | None = None
    rows: int | None = None
    nonzeros: int | None = None
    lp_bound: float | None = None
    read_seconds: float | None = None
    passes_seconds: float | None = None
    encode_seconds: float | None = None
    compile_seconds: float | None = None
    solver_seconds: float | None = None
    cpu_seconds: float | None = None
    gap_60: float | None = None
    verify_seconds: float | None = None
    first_plan: float | None = None
    proof: float | None = None
    wall_seconds: float | None = None
    peak_memory: int | None = None
    axes: str = "{}"  # JSON: sizes on growth curves
    family: str = ""
    pass_seconds: str = ""  # JSON: seconds of each pass
    solver: str = ""
    versions: str = ""
    processor: str = ""
    load: float | None = None  # 1-minute load average when the run began
    command: str = ""
    code: str = ""
    digest: str = ""
    finished: str = ""  # UTC
    sense: str = "minimize"
    trace: tuple[tuple[float | None, ...], ...] = ()

    @property
    def solved(self) -> bool:
        """Proven and, where there is a plan, certified."""
        return self.status in SOLVED

    def to_json(self) -> str:
        """One line."""
        return json.dumps(asdict(self))


def record_of(
    job: Job, known: Mapping[str, Figure], trace: tuple[tuple[float | None, ...], ...] = ()
) -> Record:
    """The record of a job, with what its process told: figures under the record's own names."""
    told: dict[str, Any] = dict(known)
    config, limits = job.config, job.limits
    return Record(
        key=job.key, suite=job.suite, problem=job.problem, label=config.label,
        encoding=config.encoding, backend=config.backend, disabled="+".join(config.disabled),
        strategy=config.strategy, repeat=job.repeat, axes=json.dumps(dict(job.axes)),
        family=job.family,
        time_limit=limits.seconds, gap_limit=limits.gap, threads=limits.threads,
        memory_limit=limits.memory, code=job.code, digest=job.digest, trace=trace, **told,
    )  # fmt: skip


def lacking(names: Collection[str]) -> tuple[str, ...]:
    """Figures that every run has and that are not among `names`."""
    needed = (f.name for f in fields(Record) if f.default is MISSING)
    return tuple(name for name in needed if name not in names)


def from_json(text: str) -> Record:
    """What `to_json` wrote; fields of other versions of this package are left out.

    Raises ValueError for anything else.
    """
    known, row = {f.name for f in fields(Record)}, json.loads(text)
    if not isinstance(row, dict):
        raise ValueError("a run is no object of JSON")
    if lost := lacking(row):
        raise ValueError(f"a run lacks {', '.join(lost)}")
    data = {k: v for k, v in row.items() if k in known}
    trace = tuple(tuple(point) for point in data.pop("trace", ()))
    return Record(**data, trace=trace)
