"""A race for one mission: racers' points become verified plans, the best of them is kept."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING

from stlc.backends.base import Progress, Solution, SolveOptions, Status
from stlc.errors import (
    InterruptedSolveError,
    NoPlanError,
    SolverError,
)
from stlc.solve.deadline import Stopwatch
from stlc.solve.events import (
    DiagnosticEvent,
    Listener,
    ProgressEvent,
    StatusEvent,
    tell_warnings,
)
from stlc.solve.incumbent import Incumbent
from stlc.solve.judge import Judge
from stlc.solve.racing.race import Finish, Lap, Race, Racer, race

if TYPE_CHECKING:
    from stlc.milp.compile import Compiled
    from stlc.mission import Mission
    from stlc.plan import Plan


@dataclass(frozen=True, slots=True)
class Result:
    """The winner's plan. `refused` says whose claim that there is none was refuted."""

    plan: Plan
    race: Race
    winner: str
    proven: bool
    refused: str | None = None


@dataclass(slots=True)
class MissionRace:
    """One race. `compiled[name]` is what the racer of that name works on.

    While it lasts, `save_to` holds the best verified plan of all racers.
    """

    mission: Mission
    compiled: Mapping[str, Compiled]
    racers: Sequence[Racer]
    listen: Listener
    save_to: Path | None = None
    cluster: str | None = None
    _incumbents: dict[str, Incumbent] = field(default_factory=dict)
    _stopped: bool = False

    def run(self, should_stop: Callable[[], bool]) -> Result:
        """Race to a result.

        Raises InfeasibleError (confirmed by a second solver), NoPlanError, InterruptedSolveError
        when stopped with nothing in hand, and DisagreementError when the verifier refuses a plan.
        """
        tell_warnings((w for c in self.compiled.values() for w in c.warnings), self.listen)
        self.listen(StatusEvent("solve", "racing " + ", ".join(r.name for r in self.racers)))
        self._incumbents = {r.name: self._incumbent(r) for r in self.racers}

        def stop() -> bool:
            """Whether somebody has asked to stop; noted, for the end of the race."""
            self._stopped = self._stopped or should_stop()
            return self._stopped

        result = self._race(stop)
        winner = result.winner
        if winner is None or winner.certified is None:
            return self._stand(result)
        if winner.certified.x is None:
            return self._doubt(result, winner)
        certified = winner.certified
        claim = replace(certified.claim, x=certified.x, objective=certified.objective)
        return self._finish(result, winner.name, claim, winner.finish is Finish.PROOF)

    def _race(self, stop: Callable[[], bool]) -> Race:
        """Race here or on the cluster; an interruption ends it with nothing beyond what is in
        hand."""
        from stlc.solve.racing.cluster import race_on_cluster

        def tell(name: str, progress: Progress) -> None:
            """Hand progress on, and look whether to stop."""
            stop()  # somebody looks: whoever interrupts now need not break in
            self._on_progress(name, progress)

        try:
            if self.cluster is None:
                return race(self.racers, on_progress=tell, should_stop=stop)
            return race_on_cluster(self.cluster, self.racers, on_progress=tell, should_stop=stop)
        except KeyboardInterrupt:
            self._stopped = True
            return Race(None, ())

    def _incumbent(self, racer: Racer) -> Incumbent:
        judge, name = self._judge_of(racer.name).judge, racer.backend
        sense = self.mission.sense
        return Incumbent(judge, self.listen, name, name, self.save_to, Stopwatch(), sense)

    def _judge_of(self, name: str) -> Judge:
        encoding = name.partition(":")[2] or "auto"
        return Judge(self.mission, self.compiled[name], encoding)

    def _on_progress(self, name: str, p: Progress) -> None:
        self.listen(ProgressEvent.of(p, self.mission.sense, p.seconds))
        if p.incumbent is None:
            return
        incumbent = self._incumbents[name]
        incumbent.raise_bound(p.bound)
        value = self.compiled[name].model.objective(p.incumbent)
        if value < min(k.objective for k in self._incumbents.values()):
            incumbent.take(p.incumbent, value)

    def _best(self) -> tuple[str, Incumbent] | None:
        """Who has the best plan so far."""
        kept = [(n, k) for n, k in self._incumbents.items() if k.claim is not None]
        return min(kept, key=lambda pair: pair[1].objective, default=None)

    def _stand(self, result: Race, refused: str | None = None) -> Result:
        """What is in hand although no racer has an answer."""
        best = self._best()
        if best is not None and best[1].claim is not None:
            return self._finish(result, best[0], best[1].claim, False, refused)
        if self._stopped:
            raise InterruptedSolveError(f"interrupted before a plan was found\n{result.text()}")
        failed = all(lap.finish is Finish.FAILED for lap in result.laps)
        kind = SolverError if failed else NoPlanError
        raise kind(f"no racer found a plan\n{result.text()}")

    def _doubt(self, result: Race, winner: Lap) -> Result:
        """Hear a second solver on the winner's claim that there is no plan."""
        from stlc.solve.confirm import contradicted, doubt, opinion

        assert winner.certified is not None
        claim, model = winner.certified.claim, self.compiled[winner.name].model
        if self._best() is not None:
            return self._stand(result, contradicted(claim))
        refuted = doubt(model, claim, opinion(SolveOptions(), winner.seconds))
        self.listen(DiagnosticEvent("warning", str(refuted)))
        found = Solution(
            Status.FEASIBLE, refuted.x, model.objective(refuted.x), solver=refuted.by.name,
            solver_version=refuted.by.version(),
        )  # fmt: skip
        return self._finish(result, winner.name, found, False, str(refuted))

    def _finish(
        self, result: Race, name: str, claim: Solution, proven: bool, refused: str | None = None
    ) -> Result:
        plan, _ = self._judge_of(name).accept(claim)
        if self.save_to is not None:
            plan.write(self.save_to)
        return Result(plan, result, name, proven, refused)
