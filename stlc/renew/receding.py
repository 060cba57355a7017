"""Closed loops: a plan is carried out step by step and made anew when it has to be."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from time import perf_counter
from typing import Protocol

import numpy as np

from stlc.arrays import Floats
from stlc.channels import TableMemo, needed
from stlc.errors import NoPlanError
from stlc.link_places import receiver
from stlc.milp.compile import CompileOptions
from stlc.mission import Mission
from stlc.plan import Plan, make_plan
from stlc.radio.samples import Samples, make_samples
from stlc.renew.past import Past
from stlc.renew.reestimate import reestimated
from stlc.renew.replanning import Renewed, replan
from stlc.solve.outcome import SolveSettings
from stlc.verify import Report, verify


@dataclass(frozen=True, slots=True, eq=False)
class Heard:
    """One packet: its channel, ends, link (2 D,) [m] and strength [dBm]."""

    channel: str
    pair: tuple[str, str]
    link: Floats
    strength: float


@dataclass(frozen=True, slots=True, eq=False)
class Measured:
    """What is known after a step: every agent's state (n,), and the packets that were heard."""

    states: Mapping[str, Floats]
    heard: tuple[Heard, ...] = ()


class World(Protocol):
    """What a loop runs in: robots, or a simulation of them (`stlc.renew.world`)."""

    def begin(self) -> Measured:
        """What is measured at step 0."""
        ...

    def step(self, states: Mapping[str, Floats], inputs: Mapping[str, Floats]) -> Measured:
        """Carry inputs (m,) out from where agents are; what is measured after it."""
        ...


@dataclass(frozen=True, slots=True)
class Loop:
    """When to plan anew, and how.

    every   plan anew each so many steps; None: only on events
    sigmas  an event: a packet is further from its forecast than so many standard deviations
    drift   an event: a state is further than this from the plan, in its own unit, along any axis
    learn   condition channels on what was heard
    refit   fit their parameters anew where enough was heard (`stlc.radio.likelier`)
    settings  of each solve; its time limit is what a step leaves
    """

    every: int | None = None
    sigmas: float = 3.0
    drift: float = 1e-3
    learn: bool = True
    refit: bool = False
    settings: SolveSettings = field(default_factory=lambda: SolveSettings(time_limit=5.0))


@dataclass(frozen=True, slots=True)
class Event:
    """Why a plan was made anew at a step, how long it took [s], and what came of it."""

    step: int
    why: str
    seconds: float
    renewed: Renewed | None  # None: no plan in time, the old one was followed on


@dataclass(frozen=True, slots=True, eq=False)
class Voyage:
    """A mission that was carried out: the run as measured, the verdict on it by what is known of
    the channels at its end, and each time at which the plan was made anew."""

    run: Plan
    report: Report
    events: tuple[Event, ...]
    mission: Mission
    seconds: tuple[float, ...]  # of all that was done between measuring and acting, each step


def receding(
    mission: Mission,
    world: World,
    loop: Loop | None = None,
    *,
    plan: Plan | None = None,
    tell: Callable[[Event], None] = lambda event: None,
) -> Voyage:
    """Carry a mission out in a world, from a plan or from one made first.

    After each step the plan is kept unless an event says that it has to be made anew. A step
    without a new plan in time follows the old one. Raises as `replan` does for the first plan.
    """
    return _Run(mission, world, loop or Loop(), tell).go(plan)


@dataclass(slots=True)
class _Run:
    """A loop under way; `known` is the mission with its channels as they are known by now."""

    mission: Mission
    world: World
    loop: Loop
    tell: Callable[[Event], None]
    heard: list[Heard] = field(default_factory=list)
    events: list[Event] = field(default_factory=list)
    seconds: list[float] = field(default_factory=list)
    tables: TableMemo = field(default_factory=dict)
    told: int = 0  # packets that the plan knows of

    def go(self, plan: Plan | None) -> Voyage:
        """From the first step to the last."""
        measured = self.world.begin()
        past = Past(
            0,
            {name: np.asarray(x)[None, :] for name, x in measured.states.items()},
            {n: np.empty((0, a.dynamics.B.shape[1])) for n, a in self.mission.agents.items()},
        )
        known = self.mission
        for step in range(self.mission.horizon):
            began = perf_counter()
            why = "the first plan" if plan is None else self._event(step, plan, measured, known)
            self.heard += measured.heard
            if why:
                plan, known = self._renewed(step, why, past, plan, known)
            inputs = {name: run.inputs[step] for name, run in plan.runs.items()} if plan else {}
            self.seconds.append(perf_counter() - began)
            measured = self.world.step({n: x[-1] for n, x in past.states.items()}, inputs)
            past = past.then(inputs, measured.states)
        self.heard += measured.heard
        return self._concluded(past, plan)

    def _event(self, step: int, plan: Plan, measured: Measured, known: Mission) -> str:
        """What makes the plan stale; empty while it is good."""
        if self.loop.every is not None and step and step % self.loop.every == 0:
            return f"every {self.loop.every} steps"
        for name, run in plan.runs.items():
            off = float(np.abs(run.states[step] - measured.states[name]).max())
            if off > self.loop.drift:
                return f"{name} is {off:.3g} off its plan"
        for packet in measured.heard:
            away = deviation(known, packet)
            if away > self.loop.sigmas:
                pair = " - ".join(packet.pair)
                return f"{packet.channel} {pair} is {away:.2g} sigma off its forecast"
        return ""

    def _renewed(
        self, step: int, why: str, past: Past, plan: Plan | None, known: Mission
    ) -> tuple[Plan | None, Mission]:
        """A new plan and what it was made by; the old ones where there is none in time."""
        began = perf_counter()
        heard = collected(self.heard[self.told :]) if self.loop.learn else {}
        renewed = None
        try:
            renewed = replan(
                self.mission, past, self._settings(), old=plan, heard=heard, refit=self.loop.refit
            )
            self.told = len(self.heard)
        except NoPlanError:
            if plan is None:
                raise
        event = Event(step, why, perf_counter() - began, renewed)
        self.events.append(event)
        self.tell(event)
        return (plan, known) if renewed is None else (renewed.plan, renewed.mission)

    def _settings(self) -> SolveSettings:
        """Those of the loop; channels that don't learn keep their tables."""
        given = self.loop.settings
        if self.loop.learn:
            return given
        options = given.compile or CompileOptions()
        if options.tables is not None:
            return given
        return replace(given, compile=replace(options, tables=self.tables))

    def _concluded(self, past: Past, plan: Plan | None) -> Voyage:
        """The run as it was, judged by all that is known at its end."""
        heard = collected(self.heard[self.told :]) if self.loop.learn else {}
        known = reestimated(self.mission, heard, {} if plan is None else plan.learned)
        last = self.mission.horizon
        run = replace(make_plan(known, past.states, past.inputs), executed=last)
        report = verify(known, run)
        return Voyage(report.annotate(run), report, tuple(self.events), known, tuple(self.seconds))


def deviation(mission: Mission, packet: Heard) -> float:
    """How many standard deviations of one packet its strength is from what was forecast."""
    model, _ = needed(mission.channels[packet.channel])
    mean, variance = model.predict(packet.link[None, :], True, receiver(model, packet.pair))
    sigma = max(float(np.sqrt(variance[0])), 1e-9)
    return abs(packet.strength - float(mean[0])) / sigma


def collected(packets: Sequence[Heard]) -> dict[str, Samples]:
    """All packets as samples of their channels."""
    by_channel: dict[str, list[Heard]] = {}
    for packet in packets:
        by_channel.setdefault(packet.channel, []).append(packet)
    return {
        name: make_samples(np.array([p.link for p in those]), np.array([p.strength for p in those]))
        for name, those in by_channel.items()
    }
