"""What a few agents can do against the runs of the others: a small mission of its own.

Others that matter only where runs meet (`couplings`) are left out until they do, so that most of
these missions hold few moving obstacles.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

from stlc.arrays import Floats
from stlc.backends.base import Backend, Capability, SolveOptions, Status
from stlc.errors import InfeasibleError
from stlc.milp.compile import Compiled, CompileOptions, compile_mission
from stlc.solve.alone.effort_rows import bounded
from stlc.solve.alone.pieces import Pieces
from stlc.solve.alone.run import LoneRun, Run
from stlc.solve.crew.ask import Ask
from stlc.solve.crew.crew import Crew, Job
from stlc.solve.deadline import Deadline
from stlc.solve.mip_start import hold
from stlc.solve.routes.tube import tube
from stlc.solve.strategy import Work
from stlc.solve.teams.couplings import Couplings
from stlc.solve.teams.held import against

_LOOSE = 1e-5  # of a run that is held: well above the tolerance of solvers, or they stumble

Runs = Mapping[str, Run]


@dataclass(frozen=True, slots=True, eq=False)
class Answer:
    """Runs of the free agents, None where none were found; who stood in their way; whether that
    is the best there is (or proven to be nothing); by how much it is better than known runs."""

    runs: Runs | None
    met: frozenset[str]
    settled: bool
    gain: float = 0.0


@dataclass(frozen=True, slots=True)
class Effort:
    """How hard to look: until the deadline, to within a gap, or for any runs at all; and where:
    within a radius [m] of known runs, if one is given."""

    deadline: Deadline
    gap: float = 0.0
    any_run: bool = False
    near: Runs | None = None
    radius: float = 0.0


@dataclass(frozen=True, slots=True, eq=False)
class Answers:
    """Answers within one compiled mission."""

    compiled: Compiled
    backend: Backend
    options: SolveOptions
    couplings: Couplings
    pieces: Pieces
    lone: tuple[LoneRun, ...] = ()
    crew: Crew = field(default_factory=Crew)

    @staticmethod
    def of(work: Work) -> Answers:
        """Those of a solve under way."""
        compiled = work.compiled
        couplings, pieces = Couplings.of(compiled), Pieces.of(compiled.mission)
        return Answers(
            compiled, work.backend, work.options, couplings, pieces, work.lone, work.crew
        )

    def find(
        self, free: Sequence[str], runs: Runs, effort: Effort, met: frozenset[str] = frozenset()
    ) -> Answer:
        """What `finding` finds, at once."""
        return self.crew.drive([self.finding(free, runs, effort, met)])[0]

    def finding(
        self, free: Sequence[str], runs: Runs, effort: Effort, met: frozenset[str] = frozenset()
    ) -> Job[Answer]:
        """Runs of `free` that get along with `runs` of others; with runs of `free` among them,
        better ones. `met` are others to look at from the start."""
        others = {name: run for name, run in runs.items() if name not in free}
        bound = frozenset(b for name in free for b in self.couplings.bound[name])
        met = (met | bound) & others.keys()
        while True:
            found = yield from self._once(free, {name: others[name] for name in met}, runs, effort)
            if found.runs is None:
                return replace(found, met=met)
            hit = self._hit(free, {**others, **found.runs}, others.keys() - met)
            if not hit:
                return replace(found, met=met)
            met |= hit

    def _hit(self, free: Sequence[str], runs: Runs, others: set[str]) -> frozenset[str]:
        alike = self.couplings.get_along
        return frozenset(o for o in others if not all(alike(name, o, runs) for name in free))

    def _once(self, free: Sequence[str], held: Runs, runs: Runs, effort: Effort) -> Job[Answer]:
        """The model of the `free` agents against the runs of `held`, started from `runs`.

        An answer without runs is settled only where there is proven to be none.
        """
        nothing = frozenset[str]()
        if effort.deadline.over():
            return Answer(None, nothing, settled=False)
        whole, tables = self.compiled.mission, self.compiled.channels
        mission = against(whole, free, held, tables, pieces=self.pieces)
        try:
            team = compile_mission(mission, CompileOptions(link=self.compiled.link))
        except InfeasibleError:
            return Answer(None, nothing, settled=True)
        team = bounded(team, [one for one in self.lone if one.agent in free])
        if effort.near is not None:
            states = {name: effort.near[name][0] for name in free}
            team = replace(team, model=tube(team, states, effort.radius))
        start = yield from self._start(team, runs, effort)
        options = replace(self.options, gap=effort.gap, start=start)
        found = yield Ask(team.model, self.backend, options, effort.deadline, effort.any_run)
        settled = found.status in (Status.OPTIMAL, Status.INFEASIBLE)
        if found.x is None:
            return Answer(None, nothing, settled)
        made = team.decode(found.x)
        gain = 0.0 if start is None else team.model.objective(start) - team.model.objective(found.x)
        return Answer({n: (made.states[n], made.inputs[n]) for n in free}, nothing, settled, gain)

    def _start(self, team: Compiled, runs: Runs, effort: Effort) -> Job[Floats | None]:
        """A point (n,) with the known runs, if they are of all the team."""
        able = Capability.START in self.backend.capabilities
        if not able or not runs.keys() >= team.states.keys():
            return None
        fixed = hold(team, {name: runs[name] for name in team.states}, _LOOSE)
        if fixed is None:
            return None
        options = replace(self.options, gap=0.0, start=None)
        return (yield Ask(fixed, self.backend, options, effort.deadline)).x
