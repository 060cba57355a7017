"""Each pass as text in, text out; then the meaning is checked on every run of a small system."""

from __future__ import annotations

from dataclasses import replace

import pytest
from support.worlds import agent, mission, most_robust, runs, value

from stlc.analysis.reach import reach
from stlc.errors import UsageError
from stlc.ir.parser import parse_node, parse_program
from stlc.ir.printer import print_node, print_program
from stlc.ir.requirement import Requirement
from stlc.ir.verify import BrokenProgram, Stage, verify
from stlc.mission import Mission
from stlc.passes import PIPELINE, Program, run_pipeline

P, Q, R = "[1*a.state.0 - 1]", "[-1*a.state.0 + 2]", "[1*a.input.0 + 0]"
PASSES = {p.name: p for p in PIPELINE}


def text(formula: str) -> str:
    """Normal form of a formula's text."""
    return formula.replace("- 1]", "+ -1]")


def world(formula: str, horizon: int = 4) -> Mission:
    requirement = Requirement("r", parse_node(text(formula)))
    return mission((agent("a", "double", 0.0),), horizon, (requirement,), most_robust())


def after(name: str, formula: str, horizon: int = 4) -> str:
    """Print of the formula after the passes that `name` needs, and `name` itself."""
    here = world(formula, horizon)
    program = Program(here.requirements, here, reach(here))
    for earlier in needed(name):
        program = PASSES[earlier].run(program)
    return print_node(PASSES[name].run(program).formulas[0])


def needed(name: str) -> list[str]:
    """Transitive predecessors in pipeline order."""
    todo, found = list(PASSES[name].after), set()
    while todo:
        step = todo.pop()
        found.add(step)
        todo += PASSES[step].after
    return [p.name for p in PIPELINE if p.name in found]


TWICE = f"and(always[0,1]({P}), eventually[0,1](always[0,1]({P})))"
RIGHT = "and([1*a.state.0@3 + -2], [-1*a.state.0@3 + 3])"
LEFT = "and([-1*a.state.0@3 + -2], [1*a.state.0@3 + 3])"
FAR = (
    "or(and([-1*a.state.0@4 + -3], [1*a.state.1@4 + 2]), "
    "and([-1*a.state.0@4 + -4], [-1*a.state.1@4 + -2]))"
)  # out of reach from RIGHT
LATE = "or([-1*a.input.0@1 + 0], [1*a.state.1@2 + -1])"  # its second half is, from LEFT

CASES = [
    ("nnf", f"not(and({P}, {Q}))", "or([-1*a.state.0 + 1], [1*a.state.0 + -2])"),
    ("nnf", f"not(always[0,2]({P}))", "eventually[0,2]([-1*a.state.0 + 1])"),
    ("nnf", f"implies({P}, {Q})", "or([-1*a.state.0 + 1], [-1*a.state.0 + 2])"),
    (
        "nnf",
        f"not(until[0,2]({P}, {Q}))",
        "release[0,2]([-1*a.state.0 + 1], [1*a.state.0 + -2])",
    ),
    ("fold", f"and(true, or({P}, false))", f"{P}"),
    ("fold", f"until[1,2](true, {P})", f"eventually[1,2]({P})"),
    ("fold", f"always[0,3](or({P}, true))", "true"),
    ("flatten", f"and(and({P}, {Q}), {P})", f"and({P}, {Q})"),
    ("horizon", f"always[1,inf]({P})", f"always[1,4]({P})"),
    ("horizon", f"eventually[0,inf]({R})", f"eventually[0,3]({R})"),
    ("merge", f"always[1,2](always[0,2]({P}))", f"always[1,4]({P})"),
    ("merge", f"eventually[0,1](eventually[1,2]({P}))", f"eventually[1,3]({P})"),
    ("merge", f"and(always[0,2]({P}), {Q}, always[3,4]({P}))", f"and(always[0,4]({P}), {Q})"),
    (
        "merge",
        f"and(always[0,1]({P}), always[3,4]({P}))",
        f"and(always[0,1]({P}), always[3,4]({P}))",
    ),
    ("merge", f"or(eventually[0,2]({P}), eventually[1,4]({P}))", f"eventually[0,4]({P})"),
    ("absorb", f"and({P}, or({Q}, {P}))", f"{P}"),
    ("absorb", f"or(and({P}, {Q}), {P})", f"{P}"),
    ("absorb", f"and({P}, [1*a.state.0 + 3], {Q})", f"and({P}, {Q})"),
    ("absorb", f"or({P}, [1*a.state.0 + 3])", "[1*a.state.0 + 3]"),
    ("cse", TWICE, f"%0 = always[0,1]({P})\nand(%0, eventually[0,1](%0))"),
    ("unroll", f"always[1,2]({P})", "and([1*a.state.0@1 + -1], [1*a.state.0@2 + -1])"),
    (
        "unroll",
        f"until[0,1]({R}, {P})",
        "or(and([1*a.input.0 + 0], [1*a.state.0 - 1]), "
        "and(and([1*a.input.0 + 0], [1*a.input.0@1 + 0]), "
        "[1*a.state.0@1 + -1]))",
    ),
    (
        "tubes",
        f"always[1,1]({P})",
        "and([1*a.state.0@1 + -1])",
    ),  # nothing disturbs it: test_tubes.py
    ("decide", f"eventually[0,3]({P})", "or([1*a.state.0@2 + -1], [1*a.state.0@3 + -1])"),
    ("decide", "eventually[0,3]([1*a.state.0 + -2])", "[1*a.state.0@3 + -2]"),
    (
        "distribute",
        "and(or([1*a.state.0@2 + -1], [-1*a.state.0@2 + -1]), "
        "or([1*a.state.0@2 + 0], [1*a.state.1@2 + -1]))",
        "or([1*a.state.0@2 + -1], and([-1*a.state.0@2 + -1], [1*a.state.1@2 + -1]))",
    ),
    ("stages", f"and(or({RIGHT}, {LEFT}), {FAR})", f"and({LEFT}, {FAR})"),
    ("stages", f"and(or({RIGHT}, {LEFT}), {FAR}, {LATE})", f"and({LEFT}, {FAR}, {LATE})"),
    (
        "decide-again",
        f"and(or({RIGHT}, {LEFT}), {FAR}, {LATE})",
        f"and({LEFT}, {FAR}, [-1*a.input.0@1 + 0])",
    ),
]


@pytest.mark.parametrize(("name", "before", "expected"), CASES)
def test_rewrite(name: str, before: str, expected: str) -> None:
    assert after(name, before) == text(expected)


@pytest.mark.parametrize(("name", "before", "expected"), CASES)
def test_robustness_is_kept(name: str, before: str, expected: str) -> None:
    here = world(before)
    original, rewritten = here.requirements[0].formula, parse_node(after(name, before))
    for run in runs(here):
        if PASSES[name].preserves == "robustness" or value(original, run) >= 0:
            assert value(rewritten, run) == pytest.approx(value(original, run))


@pytest.mark.parametrize(("name", "before", "expected"), CASES)
def test_best_run_and_verdicts_are_kept(name: str, before: str, expected: str) -> None:
    here = world(before)
    original, rewritten = here.requirements[0].formula, parse_node(after(name, before))
    pairs = [(value(original, run), value(rewritten, run)) for run in runs(here)]
    assert [b >= 0 for _, b in pairs] == [a >= 0 for a, _ in pairs]
    best = max(a for a, _ in pairs)
    if best >= 0:
        assert max(b for _, b in pairs) == pytest.approx(best)


def test_cse_makes_equal_parts_one_object() -> None:
    here = world(f"and(next({P}), or(next({P}), {Q}))".replace("next", "always[1,1]"))
    program = PASSES["cse"].run(Program(here.requirements, here, reach(here)))
    root = program.formulas[0]
    assert root.children[0] is root.children[1].children[0]


def test_every_pass_has_a_case() -> None:
    tested = {name for name, _, _ in CASES}
    repeated = {p.name for p in PIPELINE if p.name.endswith("-steps")}  # by the pass they repeat
    assert tested | repeated == {p.name for p in PIPELINE}


def test_predecessors_come_first() -> None:
    names = [p.name for p in PIPELINE]
    assert len(set(names)) == len(names)
    for k, step in enumerate(PIPELINE):
        assert set(step.after) <= set(names[:k])


def test_every_state_prints_and_parses_back() -> None:
    here = world(f"and(always[0,inf](eventually[0,2](or({P}, {R}))), until[0,3]({Q}, {P}))")
    seen: list[tuple[str, str]] = []
    program = Program(here.requirements, here, reach(here))
    run_pipeline(program, print_after={"all"}, show=lambda n, t: seen.append((n, t)))
    assert [n for n, _ in seen] == [p.name for p in PIPELINE]
    for _, printed in seen:
        requirements, horizon = parse_program(printed)
        assert print_program(requirements, horizon) == printed


def test_unknown_passes_and_lowerings_are_refused() -> None:
    here = world(P)
    program = Program(here.requirements, here, reach(here))
    with pytest.raises(UsageError, match="no pass 'nothing'"):
        run_pipeline(program, disabled={"nothing"})
    with pytest.raises(UsageError, match="lowering"):
        run_pipeline(program, disabled={"unroll"})


@pytest.mark.parametrize(
    ("broken", "stage", "message"),
    [
        (f"not({P})", Stage.NNF, "negation"),
        (f"always[0,inf]({P})", Stage.BOUNDED, "open interval"),
        (f"always[0,2]({P})", Stage.STEPS, "after unrolling"),
        ("[1*a.state.0@9 + 0]", Stage.ANY, "outside the horizon"),
        ("[1*b.state.0 + 1*a.state.0 + 0]", Stage.ANY, "not sorted"),
        ("[0*a.state.0 + 0]", Stage.ANY, "zero coefficient"),
    ],
)
def test_verifier_names_the_pass(broken: str, stage: Stage, message: str) -> None:
    requirement = replace(world(P).requirements[0], formula=parse_node(text(broken)))
    with pytest.raises(BrokenProgram, match=f"after some-pass: .*{message}"):
        verify((requirement,), 4, stage, "some-pass")
