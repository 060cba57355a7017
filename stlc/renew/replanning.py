"""A plan made anew from where a mission stands."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace

import numpy as np

from stlc.channels import ChannelTables, TableMemo
from stlc.errors import DisagreementError, InfeasibleError, UsageError
from stlc.grids import on_grids
from stlc.mission import Mission
from stlc.plan import Plan, make_plan
from stlc.radio.learned import Parameters
from stlc.radio.samples import Samples
from stlc.renew.eased import Eased, Exceeded, eased, softened
from stlc.renew.past import Past, joined
from stlc.renew.reestimate import reestimated
from stlc.renew.remaining import Lost, remaining
from stlc.solve.driver import solve_mission
from stlc.solve.events import Listener, StatusEvent, ignore
from stlc.solve.outcome import Outcome, SolveSettings
from stlc.verify import Report, verify

_EXACT = 1e-7
"""Relative gap of what is given up: by one of 1e-4 a loss of 0.5 m would leave 5e-5 m to
break what can be kept by."""

_TOLERANCE = 1e-6
"""A bound exceeded by less is kept, as the verifier has it."""


@dataclass(frozen=True, slots=True)
class Softened:
    """A bound, or a requirement, that the new plan does not keep.

    `now` is by how much the measured state exceeds a bound, `most` the greatest excess to come and
    `until` the last step with any, None where there is none any more.
    """

    text: str
    now: float
    most: float
    until: int | None
    unit: str = ""

    def __str__(self) -> str:
        unit = f" {self.unit}" if self.unit else ""
        back = "kept again from the next step on"
        if self.until is not None:
            back = f"by at most {self.most:.4g}{unit} from now on, until step {self.until}"
        return f"{self.text}: exceeded by {self.now:.4g}{unit} now, {back}"


@dataclass(frozen=True, slots=True, eq=False)
class Renewed:
    """A new plan of the whole mission, its first `plan.executed` steps as they were.

    `outcome` is that of the mission that was left; `done` requirements hold whatever comes, `lost`
    ones cannot hold any more, `given_up` are those that no plan could keep together.
    """

    plan: Plan
    report: Report
    outcome: Outcome
    done: tuple[str, ...]
    lost: tuple[Lost, ...]
    softened: tuple[Softened, ...]
    given_up: tuple[str, ...]
    mission: Mission  # with its channels as they are known now

    @property
    def kept(self) -> bool:
        """Whether the run keeps all that the mission asks for, what was measured included."""
        return self.report.ok and not self.softened

    def text(self) -> str:
        """What a person sees."""
        info = self.outcome.plan.solve
        value = "-" if info.objective is None else f"{info.objective:.6g}"
        lines = [f"step {self.plan.executed}: {info.status}, what is left costs {value}"]
        lines += [f"  done: {', '.join(self.done)}"] if self.done else []
        lines += [f"  {lost}" for lost in self.lost]
        lines += [f"  {name}: {_fit(p)}" for name, p in self._fitted()]
        lines += [f"  softened: {s}" for s in self.softened]
        lines += [f"  given up: {name}" for name in self.given_up]
        return "\n".join([*lines, *self.report.text().splitlines()[1:]])

    def _fitted(self) -> Iterator[tuple[str, Parameters]]:
        for name, what in self.plan.learned.items():
            if what.parameters is not None:
                yield name, what.parameters


def _fit(p: Parameters) -> str:
    return (
        f"fitted anew: L0 = {p.l0:.4g} dBm, n = {p.exponent:.3g}, fading {p.fading:.3g} dB^2, "
        f"shadowing {p.shadowing:.3g} dB^2, length {p.length:.3g} m, "
        f"deviation {p.deviation:.3g} dB^2"
    )


def replan(
    mission: Mission,
    past: Past,
    settings: SolveSettings | None = None,
    *,
    old: Plan | None = None,
    heard: Mapping[str, Samples] | None = None,
    refit: bool = False,
    listen: Listener = ignore,
) -> Renewed:
    """Plan what is left of a mission after `past`.

    `heard` are samples measured on the way, by channel, beside those that `old` holds: what comes
    is planned by the channels that they give, with `refit` fitted anew where `stlc.radio.likelier`
    says so. `old`, a plan of the whole, is where the search starts, shifted to now. Bounds that the
    measured state breaks are exceeded as little as can be; where the requirements cannot hold any
    more, as little is given up. The new plan, joined to the past, is verified as a whole. Raises
    NoPlanError at a limit, InfeasibleError where even so nothing is left.
    """
    settings = settings or SolveSettings()
    settings = replace(settings, tier_gap=min(settings.gap, _EXACT))
    before = {} if old is None else old.learned
    mission = mission if old is None else on_grids(mission, old.grids)
    mission = reestimated(mission, heard or {}, before, refit=refit)
    left = remaining(mission, past)
    room = eased(left.mission)
    if old is not None and settings.start is None:
        settings = replace(settings, start=_tail(old, past, room.mission))
    asked, memo = _sharing(replace(settings, save_to=None), room)
    outcome, room, given_up = _planned(left.mission, room, asked, listen)
    plan, report = _whole(mission, past, outcome, memo)
    soft = tuple(_softened(e, outcome.plan, past.step) for e in room.exceeded)
    soft = tuple(s for s in soft if s.now > _TOLERANCE or s.until is not None)
    known = on_grids(mission, plan.grids)
    renewed = Renewed(plan, report, outcome, left.done, left.lost, soft, given_up, known)
    _check(renewed)
    if settings.save_to is not None:
        plan.write(settings.save_to)
    return renewed


def _sharing(settings: SolveSettings, room: Eased) -> tuple[SolveSettings, TableMemo]:
    """Settings whose link tables serve the verdict on the whole too: they take longer than it.

    They are others where cells were widened, or may be made finer.
    """
    from stlc.milp.compile import CompileOptions

    options = settings.compile or CompileOptions()
    if room.exceeded or any(c.auto for c in room.mission.channels.values()):
        return _unshared(settings), {}
    memo = {} if options.tables is None else options.tables
    return replace(settings, compile=replace(options, tables=memo)), memo


def _unshared(settings: SolveSettings) -> SolveSettings:
    """Settings for a mission whose cells are others than those of the tables shared so far."""
    if settings.compile is None:
        return settings
    return replace(settings, compile=replace(settings.compile, tables=None))


def _tail(old: Plan, past: Past, left: Mission) -> Plan:
    """What is left of the old plan, from where the mission stands: its inputs, carried out from
    the measured states."""
    if old.horizon - past.step != left.horizon:
        raise UsageError(f"the old plan has {old.horizon} steps, the mission another number")
    states, inputs = {}, {}
    for name, agent in left.agents.items():
        given = old.runs[name].inputs[past.step :]
        inputs[name] = np.clip(given, agent.input_lower, agent.input_upper)
        run = [np.asarray(agent.start, dtype=np.float64)]
        for t, u in enumerate(inputs[name]):
            law = agent.dynamics.law(t)
            run.append(law.A @ run[-1] + law.B @ u + law.drift)
        states[name] = np.array(run)
    return make_plan(left, states, inputs)


def _planned(
    left: Mission, room: Eased, settings: SolveSettings, listen: Listener
) -> tuple[Outcome, Eased, tuple[str, ...]]:
    """A plan that keeps everything, or else all bounds that hold now and what has to hold at all
    times, or else as much as it can. Hands over what had to give way, and what it gives up.

    That nothing keeps everything is believed at once: were it wrong, the mission with everything
    as a wish would find the plan that grants all of them. A second solver is heard at the end.
    """
    try:
        return solve_mission(room.mission, replace(settings, doubted=False), listen), room, ()
    except InfeasibleError as error:
        listen(StatusEvent("soften", str(error)))
    every = eased(left, all_bounds=True)
    for trial, standing in ((room, True), (room, False), (every, True), (every, False)):
        wishes, owner = softened(trial.mission, left, standing=standing)
        try:
            asked = settings if trial is room else _unshared(settings)
            outcome = solve_mission(wishes, asked, listen)
        except (InfeasibleError, UsageError):  # or nothing bounds what is lacking
            continue
        broken = {owner.get(p.name) for p in outcome.report.preferences if not p.kept}
        return outcome, trial, tuple(r.name for r in left.requirements if r.name in broken)
    return solve_mission(room.mission, settings, listen), room, ()


def _whole(mission: Mission, past: Past, outcome: Outcome, memo: TableMemo) -> tuple[Plan, Report]:
    """The whole run and the verdict on it; its objective is that of the whole."""
    plan = joined(past, outcome.plan, mission)
    plan = replace(plan, solve=replace(plan.solve, objective=None, bound=None, gap=None))
    mission = on_grids(mission, plan.grids)
    report = verify(mission, plan, ChannelTables(mission, memo))
    value = None if report.objective is None else report.objective[0]
    info = outcome.plan.solve
    plan = replace(plan, solve=replace(plan.solve, objective=value, gap=info.gap))
    return report.annotate(plan, outcome.plan.certificate), report


def _softened(exceeded: Exceeded, rest: Plan, now: int) -> Softened:
    over = exceeded.excess(rest.runs[exceeded.agent].states[1:])
    late = np.flatnonzero(over > _TOLERANCE)
    until = None if not len(late) else now + 1 + int(late[-1])
    return Softened(
        f"{exceeded.agent}: {exceeded.what}", exceeded.now, float(over.max(initial=0.0)), until,
        exceeded.unit,
    )  # fmt: skip


def _check(renewed: Renewed) -> None:
    """The whole run breaks nothing but what is said to be broken."""
    expected = {x.name for x in renewed.lost} | set(renewed.given_up)
    unexpected = [
        r.name for r in renewed.report.requirements if not r.satisfied and r.name not in expected
    ]
    if unexpected:
        raise DisagreementError(
            "the plan for what is left is good, yet joined to the past it fails "
            f"{', '.join(unexpected)}: please report it"
        )
