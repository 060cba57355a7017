"""A plan as an object: what it holds, where everybody is at any time, pictures, tables."""

from __future__ import annotations

import os
from collections.abc import Iterable
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np

from stlc.arrays import Floats
from stlc.errors import UsageError
from stlc.verify.report import tidy

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from stlc.mission import Mission as Checked
    from stlc.plan import Plan as Data
    from stlc.verify import Report
    from stlc.verify.paths import Path


@dataclass(frozen=True, slots=True, eq=False)
class Picture:
    """A figure that notebooks show."""

    figure: Figure

    def __repr__(self) -> str:
        wide, tall = self.figure.get_size_inches()
        return f"<Picture {wide:g} x {tall:g} in>"

    def _repr_png_(self) -> bytes:
        import io

        stream = io.BytesIO()
        self.figure.savefig(stream, format="png", dpi=90)
        return stream.getvalue()


class Plan:
    """A plan beside its mission. `data` is the plain plan, `report` the verifier's word on it."""

    def __init__(self, mission: Checked, data: Data, report: Report) -> None:
        self.mission = mission
        self.data = data
        self.report = report

    @property
    def ok(self) -> bool:
        """Whether it satisfies the mission."""
        return self.report.ok

    @property
    def status(self) -> str:
        """`optimal`, `feasible` or, for a plan from elsewhere, `unknown`."""
        return self.data.solve.status

    @property
    def objective(self) -> float | None:
        """In the mission's own sense."""
        return self.data.solve.objective

    @property
    def bound(self) -> float | None:
        """What no plan can better."""
        return self.data.solve.bound

    @property
    def gap(self) -> float | None:
        """Relative distance of objective and bound."""
        return self.data.solve.gap

    @property
    def times(self) -> Floats:
        """Seconds (T+1,) of the steps."""
        return self.data.times

    @property
    def agents(self) -> tuple[str, ...]:
        """Names."""
        return tuple(self.data.runs)

    @property
    def robustness(self) -> dict[str, float | None]:
        """By requirement; None where it can't be judged."""
        return {r.name: r.robustness for r in self.report.requirements}

    def states(self, agent: Any) -> Floats:
        """States (T+1, n) of an agent at the steps."""
        return np.asarray(self._run(agent).states)

    def inputs(self, agent: Any) -> Floats:
        """Inputs (T, m) of an agent, each held for a step."""
        return np.asarray(self._run(agent).inputs)

    def _run(self, agent: Any) -> Any:
        name = getattr(agent, "name", agent)
        if name not in self.data.runs:
            raise KeyError(f"no agent {name!r}; there are {', '.join(self.agents)}")
        return self.data.runs[name]

    @cached_property
    def _paths(self) -> dict[str, Path]:
        from stlc.verify.paths import state_paths

        return state_paths(self.mission, self.data.runs)

    def at(self, agent: Any, seconds: float | Iterable[float]) -> Floats:
        """States (n,) at a time, or (K, n) at many [s], by the agent's own motion between steps.

        Raises UsageError for times outside the plan.
        """
        self._run(agent)
        times = np.asarray(seconds, dtype=np.float64)
        last = float(self.times[-1])
        if not np.all((times >= 0.0) & (times <= last * (1 + 1e-12))):
            raise UsageError(f"the plan lasts from 0 to {last:g} s")
        path = self._paths[getattr(agent, "name", agent)]
        found = path.at(np.atleast_1d(times) / self.data.step)
        return np.asarray(found[0] if times.ndim == 0 else found)

    def positions(self, agent: Any, seconds: float | Iterable[float]) -> Floats:
        """Places [m] at times, (2,) or (K, 2), with a third coordinate for those that fly.

        Raises UsageError for an agent that is nowhere.
        """
        rows = self.mission.agents[getattr(agent, "name", agent)].dynamics.axes
        if not len(rows):
            raise UsageError("this agent has no position")
        return np.asarray(self.at(agent, seconds) @ rows.T)

    def plot(self, path: str | os.PathLike[str] | None = None) -> Picture:
        """The picture of the plan, which a notebook shows; written too if a path is given."""
        from stlc.plot import plan_figure, plot_plan

        if path is not None:
            plot_plan(self.mission, self.data, path)
        return Picture(plan_figure(self.mission, self.data))

    def page(self, path: str | os.PathLike[str]) -> None:
        """Write the page of `stlc report`."""
        from stlc.report import write_report

        write_report(self.mission, self.data, path)

    def write(self, path: str | os.PathLike[str]) -> None:
        """Write the plan as JSON."""
        self.data.write(path)

    def to_csv(self) -> str:
        """Waypoints, as `stlc solve --csv` writes them."""
        return self.data.to_csv()

    def to_dataframe(self) -> Any:
        """A pandas frame: a row for each step and agent, a column for each state and input.

        Raises UsageError where pandas is missing.
        """
        import csv

        try:
            import pandas
        except ImportError:
            raise UsageError("this needs pandas: pip install pandas") from None
        header, *rows = csv.reader(self.to_csv().splitlines())
        columns = dict(zip(header, zip(*rows, strict=True), strict=True))
        as_it_is = {"t": int, "agent": str}
        return pandas.DataFrame(
            {name: [as_it_is.get(name, _number)(v) for v in column]
             for name, column in columns.items()}
        )  # fmt: skip

    def __repr__(self) -> str:
        value = "" if self.objective is None else f", objective {tidy(self.objective)}"
        gap = "" if not self.gap else f", gap {100 * self.gap:.2g} %"
        word = self.status if self.ok else "violates the mission"
        return f"<Plan {word}{value}{gap}: {', '.join(self.agents)}, {self.data.horizon} steps>"

    def _repr_html_(self) -> str:
        from stlc.front.html import plan_html

        return plan_html(self)


def _number(cell: str) -> float:
    """NaN for an empty cell: the agent has no such signal, or no input at the last step."""
    return float(cell) if cell else float("nan")


def plan_of(mission: Checked, data: Data, report: Report | None = None) -> Plan:
    """A plan with the verifier's word on it. UsageError when it doesn't fit the mission."""
    from stlc.verify import verify

    found = report or verify(mission, data)
    return Plan(mission, found.annotate(data), found)


def read_plan(path: str | os.PathLike[str], mission: Any) -> Plan:
    """A plan from a file, verified against its mission (`stlc.load`)."""
    found: Plan = mission.read_plan(path)
    return found
