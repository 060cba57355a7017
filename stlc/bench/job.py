"""One run to be made, and what is known after it."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Callable, Mapping
from dataclasses import asdict, dataclass, field

Figure = str | int | float | bool | None
"""What is known of a run: a plain JSON value."""

Tell = Callable[[object], None]
"""Sends a message to whoever asked for the run."""


@dataclass(frozen=True, slots=True)
class Config:
    """How to solve. `disabled` passes are left out; `label` is the row of every table.

    `encoding` is what `stlc solve --encoding` takes; for a peer's model it is "peer NAME", and
    strategy and passes do not apply.
    """

    encoding: str = "auto"
    backend: str = "highs"
    disabled: tuple[str, ...] = ()
    strategy: str = "auto"

    @property
    def label(self) -> str:
        """Such as 'auto', 'literal, scip' or 'auto without stages'."""
        without = f" without {'+'.join(self.disabled)}" if self.disabled else ""
        strategy = f", {self.strategy}" if self.strategy != "auto" else ""
        backend = f", {self.backend}" if self.backend != "highs" else ""
        return f"{self.encoding}{without}{strategy}{backend}"


@dataclass(frozen=True, slots=True)
class Limits:
    """Solver seconds, relative gap, threads, memory of the process [bytes]."""

    seconds: float = 60.0
    gap: float = 1e-4
    threads: int = 1
    memory: int | None = None


@dataclass(frozen=True, slots=True)
class Job:
    """One run. `files` go with it, so that a cluster's workers need no common folder.

    `files[main]` is a mission, or a peer's model as MPS (`.mps`, `.mps.xz`, `.mps.gz`). `code` is
    the fingerprint of the package that the run is made with.
    """

    suite: str
    problem: str
    main: str
    files: Mapping[str, bytes]
    config: Config
    limits: Limits
    repeat: int
    code: str
    axes: Mapping[str, float] = field(default_factory=dict)
    family: str = ""

    @property
    def digest(self) -> str:
        """SHA-256 of the files."""
        total = hashlib.sha256()
        for name in sorted(self.files):
            total.update(f"{name}\0{len(self.files[name])}\0".encode() + self.files[name])
        return total.hexdigest()

    @property
    def key(self) -> str:
        """The same for the same run only: problem and its text, configuration, limits, code."""
        words = [
            self.suite, self.problem, self.digest, asdict(self.config), asdict(self.limits),
            self.repeat, self.code,
        ]  # fmt: skip
        return hashlib.sha256(json.dumps(words, sort_keys=True).encode()).hexdigest()

    @property
    def series(self) -> tuple[str, str, str]:
        """What its repeats have in common."""
        return self.suite, self.problem, self.config.label

    @property
    def title(self) -> str:
        """For a person."""
        return f"{self.suite}/{self.problem}  {self.config.label}  #{self.repeat + 1}"


@dataclass(frozen=True, slots=True)
class Update:
    """What a run has found out so far: plain JSON values, see `record.py`."""

    fields: Mapping[str, Figure] = field(default_factory=dict)


@dataclass(frozen=True, slots=True)
class Point:
    """Where the solver stood: seconds since its start, incumbent, bound, nodes."""

    seconds: float
    objective: float | None
    bound: float | None
    nodes: int | None


@dataclass(frozen=True, slots=True)
class Done:
    """The last message of a run."""
