"""From a checked mission to one exact MILP, and back from a solver's point to trajectories."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np

from stlc.analysis.goals import Goal, level_of
from stlc.analysis.link_tables import LinkTables
from stlc.analysis.ranges import Ranges
from stlc.analysis.reach import reach
from stlc.analysis.sizes import MOST_PARTS, check_size
from stlc.analysis.stages import find_stages
from stlc.analysis.table_sizes import check_tables
from stlc.arrays import Floats, Ints
from stlc.channels import ChannelTables, TableMemo
from stlc.diagnostics import Diagnostic
from stlc.ir.nodes import Node
from stlc.milp.big_m import leaky_big_ms
from stlc.milp.builder import ModelBuilder
from stlc.milp.context import Context
from stlc.milp.costs import add_caps, add_objective, reserve_link_costs
from stlc.milp.dynamics import add_agents
from stlc.milp.formulas.encoder import FormulaEncoder
from stlc.milp.formulas.link_predicates import LinkEncoder
from stlc.milp.formulas.selectors import selector_named
from stlc.milp.layout import Layout
from stlc.milp.model import Model, Origin
from stlc.milp.preferences import Lowered, lowered
from stlc.milp.stage_rows import add_cuts, add_hulls
from stlc.milp.unsolvable import check_bounded, check_controlled, check_magnitudes
from stlc.mission import Mission
from stlc.passes import PassStats, Program, never, run_pipeline, stop_if
from stlc.trajectories import Trajectories


def _silent(name: str, text: str) -> None:
    """Printed programs go nowhere unless someone asks."""


@dataclass(frozen=True, slots=True)
class CompileOptions:
    """How to compile.

    `stl` and `link` name encodings ("auto" chooses by structure); `print_after` names passes whose
    result goes to `show(name, text)`, "all" for every one. `max_size` bounds the parts of the
    model, as `analysis/sizes.py` counts them. `hopeful` lets a link predicate hold in a cell where
    it may at some point: no plan then means that no finer partition has one. `tables` are shared
    with missions of the same channels and stations. `should_stop` is asked between passes and
    requirements.
    """

    stl: str = "auto"
    link: str = "auto"
    disabled_passes: frozenset[str] = frozenset()
    print_after: frozenset[str] = frozenset()
    show: Callable[[str, str], None] = _silent
    max_size: int = MOST_PARTS
    hopeful: bool = False
    tables: TableMemo | None = None
    should_stop: Callable[[], bool] = never


@dataclass(frozen=True, slots=True)
class CompileStats:
    """Sizes by origin (a requirement or declaration): columns, binaries, rows, nonzeros."""

    by_origin: Mapping[str, tuple[int, int, int, int]]
    passes: tuple[PassStats, ...]
    seconds: float
    notes: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True, eq=False)
class Compiled:
    """The model, and what is needed to read a point of it.

    `mission` is without preferences, which were lowered. `robustness[name]` is the column of a
    robustness objective and its static bounds; name None is the whole mission's. `warnings` are of
    numbers that solvers may trip over. `link` is the link encoding that was asked for.
    """

    model: Model
    mission: Mission
    layout: Layout
    ranges: Mapping[str, Ranges]
    robustness: Mapping[str | None, tuple[int, float, float]]
    stats: CompileStats
    channels: ChannelTables
    warnings: tuple[Diagnostic, ...] = ()
    link: str = "auto"

    @property
    def states(self) -> Mapping[str, Ints]:
        """states[agent] (T+1, n): columns."""
        return self.layout.states

    @property
    def inputs(self) -> Mapping[str, Ints]:
        """inputs[agent] (T, m): columns."""
        return self.layout.inputs

    def decode(self, x: Floats) -> Trajectories:
        """Trajectories of a point x (n,)."""
        return Trajectories(
            {name: np.asarray(x[cols], dtype=float) for name, cols in self.states.items()},
            {name: np.asarray(x[cols], dtype=float) for name, cols in self.inputs.items()},
        )


def compile_mission(mission: Mission, options: CompileOptions | None = None) -> Compiled:
    """Compile.

    Raises InfeasibleError where the analysis proves that no run exists, InterruptedSolveError when
    asked to stop, UsageError for an unknown option, MissionError (located) for recorded signals,
    for numbers that no solver can take and for a model beyond `options.max_size`.
    """
    options = options or CompileOptions()
    began = time.perf_counter()
    check_controlled(mission)
    check_size(mission, options.max_size)
    tables = LinkTables(mission, options.hopeful, options.tables)
    ranges: Mapping[str, Ranges] = reach(mission)
    check_tables(mission, ranges, options.max_size)
    plain = lowered(mission, ranges, tables)
    mission = plain.mission
    program, passes = run_pipeline(
        Program(mission.requirements, mission, plain.ranges, tables), options.disabled_passes,
        options.print_after, options.show, options.should_stop,
    )  # fmt: skip
    ctx = _begun(plain, program)
    goals = program.known_goals()
    check_bounded(goals, program.requirements)
    rho = {goal: _add_goal(ctx, goal) for goal in goals}
    reserve_link_costs(ctx, tables, options.link)
    notes = _add_requirements(ctx, program, goals, rho, tables, options)
    if "stages" not in options.disabled_passes:
        _add_stages(ctx, program)
    notes += add_objective(ctx, tables, options.link) + add_caps(ctx, rho, tables, options.link)
    model = ctx.builder.build()
    check_magnitudes(model)
    stats = CompileStats(sizes(model), passes, time.perf_counter() - began, notes)
    robustness = {g.requirement: (rho[g], g.low, g.high) for g in goals}
    warned = leaky_big_ms(model, {f"require {r.name}": r for r in program.requirements})
    return Compiled(
        model, mission, ctx.layout, ctx.ranges, robustness, stats, tables.channels, warned,
        options.link,
    )  # fmt: skip


def _begun(plain: Lowered, program: Program) -> Context:
    """A model that has agents so far, and what lowering has settled."""
    ctx = Context(plain.mission, ModelBuilder(), program.ranges)
    ctx.layout.stand_ins = plain.stand_ins
    ctx.builder.offset += plain.offset
    add_agents(ctx)
    return ctx


def _add_goal(ctx: Context, goal: Goal) -> int:
    ctx.builder.origin = Origin(f"robustness {goal.requirement or 'of the mission'}")
    column = ctx.builder.add_columns("rho", (1,), goal.low, goal.high, cost=goal.weight)
    return int(column[0])


def _add_requirements(
    ctx: Context,
    program: Program,
    goals: tuple[Goal, ...],
    rho: Mapping[Goal, int],
    tables: LinkTables,
    options: CompileOptions,
) -> tuple[str, ...]:
    """Encode every requirement, note its receipt; how many choices were encoded how, and why."""
    encoder = FormulaEncoder(
        ctx, rho, LinkEncoder(ctx, tables, rho, options.link), selector_named(options.stl)
    )
    found = []
    for requirement in program.requirements:
        stop_if(options.should_stop)
        ctx.builder.origin = Origin(f"require {requirement.name}", requirement.span)
        found.append(encoder.require(requirement, level_of(requirement, goals)))
    ctx.layout.encoded = tuple(found)
    return tuple(f"{n} formula choices: {why}" for why, n in encoder.reasons.items())


def _add_stages(ctx: Context, program: Program) -> None:
    """Cuts and hulls of consecutive choices; see `stages.py`."""
    literals: dict[Node, Ints] = {
        node: columns for one in ctx.layout.encoded for node, columns in one.whole_choices()
    }
    for name, stages in find_stages(ctx.mission, program.requirements, ctx.ranges).items():
        ctx.builder.origin = Origin(f"stages of {name}")
        add_cuts(ctx.builder, stages, literals)
        add_hulls(ctx.builder, ctx.states[name], ctx.ranges[name], stages, literals)


def sizes(model: Model) -> dict[str, tuple[int, int, int, int]]:
    """Columns, binaries, rows and nonzeros by the label of their origin."""
    found: dict[str, np.ndarray] = {}
    for block in model.col_blocks:
        part = slice(block.start, block.start + block.size)
        integers = int(model.integrality[part].sum())
        entry = found.setdefault(block.origin.label, np.zeros(4, np.int64))
        entry += (block.size, integers, 0, 0)
    for block in model.row_blocks:
        nonzeros = int(model.A.indptr[block.start + block.size] - model.A.indptr[block.start])
        entry = found.setdefault(block.origin.label, np.zeros(4, np.int64))
        entry += (0, 0, block.size, nonzeros)
    return {label: (int(e[0]), int(e[1]), int(e[2]), int(e[3])) for label, e in found.items()}
