"""Backends that lie, found as plugins: `plug(monkeypatch)` makes them known by name."""

from __future__ import annotations

from importlib.metadata import EntryPoint
from typing import ClassVar

import pytest

from stlc import backends
from stlc.backends.base import Capability, Progress, Solution, SolveOptions, Status
from stlc.milp.model import Model


class Denier:
    """Says at once that there is no point."""

    name: ClassVar[str] = "denier"
    capabilities: ClassVar[Capability] = Capability.NONE

    def available(self) -> str | None:
        return None

    def version(self) -> str:
        return "Denier 1.0"

    def solve(self, model: Model, options: SolveOptions) -> Solution:
        return Solution(Status.INFEASIBLE, solver=self.name, solver_version=self.version())


class Forgetter(Denier):
    """Hands a point over on the way, and then says that there is none."""

    name: ClassVar[str] = "forgetter"
    capabilities: ClassVar[Capability] = Capability.INCUMBENTS

    def solve(self, model: Model, options: SolveOptions) -> Solution:
        x = backends.get("highs").solve(model, SolveOptions()).x
        assert x is not None
        if options.on_progress is not None:
            options.on_progress(Progress(0.1, model.objective(x), None, 0, x))
        return super().solve(model, options)


def plug(monkeypatch: pytest.MonkeyPatch) -> None:
    """Make them known."""
    points = [
        EntryPoint(kind.name, f"support.liars:{kind.__name__}", "stlc.backends")
        for kind in (Denier, Forgetter)
    ]
    monkeypatch.setattr(backends, "entry_points", lambda group: points)
