"""Rewrites from a checked mission's formulas to what the encoder takes; PIPELINE is their order."""

from __future__ import annotations

import time
from collections.abc import Callable, Collection, Sequence
from dataclasses import dataclass, replace

from stlc.errors import InterruptedSolveError, UsageError, hinted
from stlc.ir.nodes import Node
from stlc.ir.printer import print_program
from stlc.ir.rewrite import postorder
from stlc.ir.verify import Stage, verify
from stlc.passes import (
    absorb,
    cse,
    decide,
    distribute,
    flatten,
    fold,
    horizon,
    merge,
    nnf,
    stages,
    tubes,
    unroll,
)
from stlc.passes.base import Pass, Program

__all__ = ["PIPELINE", "Pass", "PassStats", "Program", "never", "run_pipeline", "stop_if"]


def _again(earlier: Pass, name: str, *after: str) -> Pass:
    return replace(earlier, name=name, after=after, stage=Stage.STEPS)


PIPELINE: tuple[Pass, ...] = (
    nnf.PASS,
    fold.PASS,
    flatten.PASS,
    horizon.PASS,
    merge.PASS,
    absorb.PASS,
    cse.PASS,
    unroll.PASS,
    tubes.PASS,
    _again(fold.PASS, "fold-steps", "unroll"),
    decide.PASS,
    _again(flatten.PASS, "flatten-steps", "unroll"),
    _again(absorb.PASS, "absorb-steps", "unroll"),
    distribute.PASS,
    stages.PASS,
    replace(decide.PASS, name="decide-again", after=("decide", "stages")),
)


@dataclass(frozen=True, slots=True)
class PassStats:
    """What one pass did: distinct nodes before and after, seconds."""

    name: str
    before: int
    after: int
    seconds: float


def never() -> bool:
    """Nobody asks to stop."""
    return False


def stop_if(should_stop: Callable[[], bool]) -> None:
    """Raise InterruptedSolveError when somebody asks to stop."""
    if should_stop():
        raise InterruptedSolveError("interrupted before the model was made")


def run_pipeline(
    program: Program,
    disabled: Collection[str] = (),
    print_after: Collection[str] = (),
    show: Callable[[str, str], None] = lambda name, text: None,
    should_stop: Callable[[], bool] = never,
) -> tuple[Program, tuple[PassStats, ...]]:
    """Run every enabled pass in order, verifying after each.

    `show(name, text)` receives the program after each pass that `print_after` names ("all" for
    every one). UsageError for an unknown pass, or for a lowering in `disabled`;
    InterruptedSolveError once `should_stop`, asked before each pass, says so.
    """
    _check_names(disabled, print_after)
    stats: list[PassStats] = []
    stage, sound = Stage.ANY, set[Node]()
    size = sum(1 for _ in postorder(program.formulas))
    for step in PIPELINE:
        if step.name in disabled:
            continue
        stop_if(should_stop)
        began, before = time.perf_counter(), size
        result = step.run(program)
        seconds = time.perf_counter() - began
        if step.stage > stage:
            stage, sound = step.stage, set()
        if not sound or not _same(result.formulas, program.formulas):
            size = verify(result.requirements, result.horizon, stage, step.name, sound)
        program = result
        stats.append(PassStats(step.name, before, size, seconds))
        if step.name in print_after or "all" in print_after:
            show(step.name, print_program(program.requirements, program.horizon))
    return program, tuple(stats)


def _same(formulas: Sequence[Node], others: Sequence[Node]) -> bool:
    """Whether a pass left every formula as the very object it was: it is verified then."""
    pairs = zip(formulas, others, strict=True)
    return len(formulas) == len(others) and all(a is b for a, b in pairs)


def _check_names(disabled: Collection[str], print_after: Collection[str]) -> None:
    known = [p.name for p in PIPELINE]
    for name in [*disabled, *(p for p in print_after if p != "all")]:
        if name not in known:
            raise UsageError(f"there is no pass '{name}'; {hinted(name, known)}")
    for step in PIPELINE:
        if step.lowering and step.name in disabled:
            raise UsageError(f"the pass '{step.name}' is a lowering and cannot be switched off")
