"""From a checked mission to a certified, verified plan.

compile -> backend -> certify against the Model -> decode -> verify against the mission -> Plan.
No answer is shown before both checks; a point that the Model accepts and the verifier refuses is
our own disagreement (exit 70), never a plan.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import TYPE_CHECKING

from stlc import backends
from stlc.backends.support import require
from stlc.errors import (
    InfeasibleError,
)
from stlc.grids import shapes, text
from stlc.solve.bounded import by_deadline
from stlc.solve.deadline import Deadline, Stopwatch
from stlc.solve.events import (
    Listener,
    StatusEvent,
    ignore,
    tell_warnings,
)
from stlc.solve.job import Job
from stlc.solve.outcome import Outcome, SolveSettings
from stlc.solve.tiers import priorities, solve_in_tiers

if TYPE_CHECKING:
    from stlc.mission import Mission


def solve_mission(
    mission: Mission,
    settings: SolveSettings | None = None,
    listen: Listener = ignore,
    should_stop: Callable[[], bool] | None = None,
) -> Outcome:
    """Plan a mission.

    `listen` and `should_stop` are called in this thread. When `should_stop` says so, and on
    KeyboardInterrupt, the best plan so far is the outcome. Where a second solver refutes a claim
    that there is none, it goes on from the point that it found. Channels with `partition auto` get
    finer grids where whole cells rule out what points of them may offer. Preferences with
    priorities are solved for in tiers. Raises InfeasibleError (confirmed by a second solver),
    NoPlanError at a limit with nothing in hand,
    InterruptedSolveError when stopped with nothing in hand, SolverError when the solver is
    missing, fails or its answer is refused, and DisagreementError when the verifier refuses
    what the Model accepts.
    """
    settings = settings or SolveSettings()
    deadline = Deadline.after(settings.time_limit, should_stop)
    if not priorities(mission):
        return _on_grids(mission, settings, listen, deadline)
    return solve_in_tiers(
        mission, settings, listen, deadline,
        lambda tier, asked, until: _on_grids(tier, asked, listen, until),
    )  # fmt: skip


def _on_grids(
    mission: Mission, settings: SolveSettings, listen: Listener, deadline: Deadline
) -> Outcome:
    """Plan a mission, on finer grids where its channels choose them and need them."""
    from stlc.solve.refine import refined_if_cells

    while True:
        try:
            return _solve_on(mission, settings, listen, deadline)
        except InfeasibleError:
            refined = refined_if_cells(mission, settings, deadline)
            if refined is None:
                raise
            listen(StatusEvent("refine", f"whole cells rule it out; now {text(shapes(refined))}"))
            mission = refined


def _solve_on(
    mission: Mission, settings: SolveSettings, listen: Listener, deadline: Deadline
) -> Outcome:
    """Plan a mission on the grids that its channels have."""
    from stlc.milp.compile import CompileOptions
    from stlc.milp.encodings import encoding_label
    from stlc.solve.blame import compile_or_blame

    backend = backends.get(settings.backend)
    require(backend)
    compiling, options = Stopwatch(), settings.compile or CompileOptions()
    listen(StatusEvent("compile", mission.source.name))
    compiled = by_deadline(
        lambda stop: compile_or_blame(mission, replace(options, should_stop=stop)),
        deadline, settings.grace,
    )  # fmt: skip
    tell_warnings(compiled.warnings, listen)
    took = compiling.seconds
    label = encoding_label(settings.compile)
    return Job(mission, settings, compiled, backend, listen, deadline, label).run(took)
