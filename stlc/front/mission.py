"""A mission as an object: read from a file or built in code, printed as a mission file."""

from __future__ import annotations

import io
import os
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from stlc import api
from stlc.errors import MissionError, UsageError
from stlc.files import real, scratch_folder, write_atomic
from stlc.front.expressions import Formula, Quantity
from stlc.front.handles import Agent, Channel, Dynamics, Place, Station
from stlc.front.plan import Plan, plan_of
from stlc.front.properties import block
from stlc.front.shapes import Shape
from stlc.front.text import point, written

if TYPE_CHECKING:
    from stlc.diagnostics import Diagnostic
    from stlc.explain.conflict import Conflict, Verdict
    from stlc.mission import Mission as Checked


class Mission:
    """A mission. Every method that declares something appends a statement to its text.

    `print(mission)` is a mission file, `mission.checked` what `stlc.api` works with. Mistakes are
    found when the mission is used: MissionError names their lines in the printed text.
    """

    def __init__(
        self,
        *,
        step: Any = None,
        horizon: Any = None,
        workspace: Shape | None = None,
        margin: Any = None,
        name: str = "mission.stl",
    ) -> None:
        self.name = name
        self._lines: list[str] = []
        self._params: Mapping[str, str | float] = {}
        self._folder: Path | None = None
        self._allow: tuple[Path, ...] = ()
        self._data: dict[str, np.ndarray[Any, Any]] = {}
        self._seen: tuple[str, Checked] | None = None
        for word, value in (("step", step), ("horizon", horizon), ("margin", margin)):
            if value is not None:
                self.add(f"{word} {written(value)}")
        if workspace is not None:
            self.add(f"workspace {workspace.text}")

    # --- declaring -------------------------------------------------------------------------

    def add(self, text: str) -> None:
        """Append statements as the language writes them."""
        self._lines.append(text)

    def param(self, name: str, value: Any) -> Quantity:
        """A number that `solve` and `stlc -D` may set anew."""
        self.add(f"param {name} = {written(value)}")
        return Quantity(name)

    def dynamics(
        self, name: str, kind: str | None = None, *properties: str, **named: Any
    ) -> Dynamics:
        """`kind` is one of the language's, or A and B (arrays), c, states and so on are given."""
        head = f"dynamics {name}" + (f" = {kind}" if kind else "")
        self.add(head + block(properties, named))
        return Dynamics(name)

    def agent(self, name: str, dynamics: Dynamics | str, *properties: str, **named: Any) -> Agent:
        """`agent("r1", "double_integrator", start=(1, 1), control=1, speed="2 m/s")`."""
        self.add(f"agent {name} : {written(dynamics)}{block(properties, named)}")
        return Agent(name)

    def station(self, name: str, at: Any, *properties: str, **named: Any) -> Station:
        """A radio at a point (2,) [m]."""
        self.add(f"station {name} at {point(at)}{block(properties, named)}")
        return Station(name)

    def region(self, name: str, shape: Shape) -> Place:
        """A place to be in, or out of."""
        self.add(f"region {name} = {shape.text}")
        return Place(name)

    def obstacle(
        self, name: str, shape: Shape, *, inflate: Any = None, velocity: Any = None
    ) -> Place:
        """A place to keep out of where a requirement says so; grown by `inflate` [m]."""
        text = f"obstacle {name} = {shape.text}"
        text += "" if velocity is None else f" velocity {point(velocity)}"
        text += "" if inflate is None else f" inflate {written(inflate)}"
        self.add(text)
        return Place(name)

    def wall(self, name: str, shape: Shape, loss: Any = None) -> Place:
        """What takes `loss` [dB] off every link that crosses it; without one a fit tells."""
        text = f"wall {name} = {shape.text}"
        self.add(text if loss is None else f"{text} loss {_decibels(loss)}")
        return Place(name)

    def channel(
        self,
        name: str,
        *properties: str,
        table: np.ndarray[Any, Any] | None = None,
        **named: Any,
    ) -> Channel:
        """`channel("radio", path_loss=(-40, 2), partition=(8, 8))`.

        `table` (n, n) are the link costs between the n cells; `write` puts it beside the mission.
        """
        if table is not None:
            file = f"{Path(self.name).stem}_{name}.csv"
            self._data[file] = np.asarray(table, dtype=np.float64)
            properties = (*properties, f'table "{file}"')
        self.add(f"channel {name}{block(properties, named) or ' { }'}")
        return Channel(name)

    def require(self, name: str, formula: Formula | str, margin: Any = None) -> None:
        """What must hold."""
        extra = "" if margin is None else f" margin {written(margin)}"
        self.add(f"require {name}{extra}: {written(formula)}")

    def prefer(self, name: str, formula: Formula | str, **wishes: Any) -> None:
        """What should hold if it can: `weight=2`, `priority=1`."""
        said = "".join(f" {word} {written(value)}" for word, value in wishes.items())
        self.add(f"prefer {name}{said}: {written(formula)}")

    def minimize(self, cost: Quantity | str) -> None:
        """The objective."""
        self.add(f"minimize {written(cost)}")

    def maximize(self, value: Quantity | str) -> None:
        """The objective."""
        self.add(f"maximize {written(value)}")

    # --- the text --------------------------------------------------------------------------

    @property
    def text(self) -> str:
        """The mission file, in the one style where it can be parsed."""
        from stlc.source import Source
        from stlc.syntax.parse import parse
        from stlc.syntax.printer import format_file

        raw = "\n".join(self._lines) + "\n"
        if self._folder is not None and len(self._lines) == 1:
            return self._lines[0]  # as it stands in its file
        result = parse(Source(self.name, raw))
        wrong = any(d.severity.value == "error" for d in result.diagnostics)
        return raw if wrong else format_file(result.file)

    def __str__(self) -> str:
        return self.text

    def __repr__(self) -> str:
        try:
            return f"<Mission {Path(self.name).name}: {self.checked.summary()}>"
        except MissionError as error:
            count = sum(d.severity.value == "error" for d in error.diagnostics)
            return f"<Mission {Path(self.name).name}: {count} mistake{'s' * (count != 1)}>"

    def _repr_html_(self) -> str:
        from stlc.front.html import mission_html

        return mission_html(self.name, self.text)

    def write(self, path: str | os.PathLike[str]) -> None:
        """Write the mission file, tables beside it. OutputError when that can't be done."""
        for name, table in self._data.items():
            write_atomic(Path(path).parent / name, _csv(table))
        write_atomic(path, self.text)

    # --- using it --------------------------------------------------------------------------

    @property
    def checked(self) -> Checked:
        """The checked mission. Raises MissionError with every mistake of the text."""
        text = self.text
        if self._seen is None or self._seen[0] != text:
            self._seen = text, self._load(text)
        return self._seen[1]

    def _load(self, text: str) -> Checked:
        """With data in memory, from a folder that holds it meanwhile."""
        if not self._data:
            return api.loads(text, name=self.name, params=self._params, folder=self._folder,
                             allow_paths=self._allow)  # fmt: skip
        if self._folder is not None:
            raise UsageError("a mission from a file takes its tables from files: write them there")
        with scratch_folder() as folder:
            for name, table in self._data.items():
                (folder / name).write_text(_csv(table), encoding="ascii")
            return api.loads(text, name=self.name, params=self._params, folder=folder)

    def check(self) -> tuple[Diagnostic, ...]:
        """The warnings. Raises MissionError with every mistake."""
        return self.checked.warnings

    def solve(
        self,
        time_limit: float | None = None,
        *,
        gap: float = 1e-4,
        backend: str = "highs",
        encoding: str = "auto",
        strategy: str = "auto",
        threads: int | None = None,
        seed: int | None = None,
        start: Plan | None = None,
        confirm: bool = False,
        progress: bool = True,
    ) -> Plan:
        """A certified, verified plan, the best within `time_limit` [s] or `gap` (relative).

        A notebook shows how far it is in a line that moves, unless `progress` is False.
        Raises InfeasibleError where there is proven to be none (`explain` says why), NoPlanError
        where none came in time, SolverError where a solver is missing or failed.
        """
        from stlc.front.progress import listener
        from stlc.milp.encodings import compile_options
        from stlc.solve.outcome import SolveSettings

        settings = SolveSettings(
            backend, compile_options(encoding, ()), strategy, time_limit, gap, threads, seed,
            None if start is None else start.data, confirm,
        )  # fmt: skip
        outcome = api.solve(self.checked, settings, listener(progress))
        return plan_of(self.checked, outcome.plan, outcome.report)

    def explain(self, time_limit: float = 60.0) -> Conflict | Verdict:
        """What cannot hold together, and why."""
        return api.explain(self.checked, time_limit=time_limit)

    def read_plan(self, path: str | os.PathLike[str]) -> Plan:
        """A plan of this mission from a file, verified anew."""
        from stlc.plan import read_plan

        return plan_of(self.checked, read_plan(path))


def _decibels(value: Any) -> str:
    return written(value) if isinstance(value, str) else f"{written(value)} dB"


def _csv(table: np.ndarray[Any, Any]) -> str:
    """Every digit."""
    stream = io.StringIO()
    np.savetxt(stream, np.atleast_2d(table), delimiter=",", fmt="%.17g")
    return stream.getvalue()


def load(
    path: str | os.PathLike[str],
    *,
    params: Mapping[str, str | float] | None = None,
    allow_paths: Sequence[str | os.PathLike[str]] = (),
) -> Mission:
    """A mission from a file, checked. UsageError when it isn't there, MissionError for mistakes."""
    from stlc.syntax.read import read_source

    mission = loads(
        read_source(path).text, name=os.fspath(path), params=params,
        folder=real(path).parent, allow_paths=allow_paths,
    )  # fmt: skip
    _ = mission.checked
    return mission


def loads(
    text: str,
    *,
    name: str = "mission.stl",
    params: Mapping[str, str | float] | None = None,
    folder: str | os.PathLike[str] | None = None,
    allow_paths: Sequence[str | os.PathLike[str]] = (),
) -> Mission:
    """A mission from a text; files that it names are read from under `folder`."""
    mission = Mission(name=name)
    mission.add(text)
    mission._params = dict(params or {})
    mission._folder = None if folder is None else Path(folder)
    mission._allow = tuple(Path(p) for p in allow_paths)
    return mission
