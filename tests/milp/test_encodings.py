"""Formula encodings: chosen by structure with a reason, by name, or from a package."""

from __future__ import annotations

from importlib.metadata import EntryPoint

import pytest
from support.worlds import agent, mission

from stlc.backends import get
from stlc.backends.base import SolveOptions
from stlc.errors import UsageError
from stlc.ir.nodes import And, Eventually, Linear, Node, Or, Role, Signal
from stlc.ir.requirement import Requirement
from stlc.milp import encodings
from stlc.milp.compile import Compiled, CompileOptions, compile_mission
from stlc.milp.formulas import selectors
from stlc.milp.formulas.auto import choose
from stlc.milp.model import Model
from stlc.mission import Mission, ObjectiveTerm, TermKind
from stlc.solve.statistics import lp_bound

EFFORT = (ObjectiveTerm(TermKind.EFFORT, 1.0),)


def atom(step: int, sign: float, constant: float, index: int = 0) -> Linear:
    return Linear(((Signal("a", Role.STATE, index, step), sign),), constant)


def world(formula: Node) -> Mission:
    return mission((agent("a", "skew", 0.0, 9.0),), 6, (Requirement("r", formula),), EFFORT)


WANDER = And(
    (
        Eventually(And((atom(0, 1.0, -0.5), atom(0, -1.0, 1.5))), 0, 6),
        Eventually(And((atom(0, 1.0, -1.5, 1), atom(0, -1.0, 3.0, 1))), 0, 6),
        Or((atom(2, 1.0, -1.2), And((atom(2, -1.0, -0.4, 1), atom(2, -1.0, -0.2))))),
    )
)


def compiled(name: str) -> Compiled:
    return compile_mission(world(WANDER), CompileOptions(stl=name))


def optimum(model: Model) -> float | None:
    return get("highs").solve(model, SolveOptions(threads=1, gap=0.0)).objective


@pytest.mark.parametrize("name", selectors.SELECTORS)
def test_one_optimum(name: str) -> None:
    assert optimum(compiled(name).model) == pytest.approx(optimum(compiled("auto").model))


def relaxation(formula: Node, name: str) -> float:
    plain = CompileOptions(stl=name, disabled_passes=frozenset({"stages"}))
    bound = lp_bound(compile_mission(world(formula), plain).model)
    assert bound is not None
    return bound


def test_shared_faces_are_tighter_than_big_m() -> None:
    corners = ((2.0, 1.0, -0.5), (2.5, -1.0, -0.5))
    parts = [And((atom(6, 1.0, -x), atom(6, sign, y, 1))) for x, sign, y in corners]
    bounds = [relaxation(Or(tuple(parts)), n) for n in ("bigm", "onehot", "hull")]
    assert bounds[0] < bounds[1] - 1e-3 < bounds[2]


def test_hull_is_tighter_than_faces_with_different_directions() -> None:
    slope = Linear(((Signal("a", Role.STATE, 0, 6), 2.0), (Signal("a", Role.STATE, 1, 6), 0.1)), -5)
    bounds = [relaxation(Or((atom(6, 1.0, -2.0), slope)), n) for n in ("bigm", "onehot", "hull")]
    assert bounds[0] <= bounds[1] + 1e-7
    assert bounds[1] < bounds[2] - 1e-3


def test_auto_gives_its_reasons() -> None:
    few, early = choose([[atom(1, 1.0, 0.0)]] * 3), [[atom(t, 1.0, 0.0)] for t in range(6)]
    assert (few[0].name, few[1]) == ("onehot", "at most 4 alternatives")
    assert choose(early)[0].name == "unary"
    assert choose([[atom(2, 1.0, -k / 2)] for k in range(6)])[0].name == "onehot"
    assert any("ordered in time" in note for note in compiled("auto").stats.notes)


class Mirrored:
    """An encoding of a package: one-hot by another name."""

    name, kind = "mirrored", "stl"
    literals, add_rows = selectors.ONE_HOT.literals, selectors.ONE_HOT.add_rows


MIRRORED = Mirrored()


def test_packages_offer_encodings(monkeypatch: pytest.MonkeyPatch) -> None:
    point = EntryPoint("mirrored", f"{__name__}:MIRRORED", selectors.ENTRY_POINTS)
    monkeypatch.setattr(EntryPoint, "load", lambda self: MIRRORED)
    for module in (selectors, encodings):
        monkeypatch.setattr(module, "entry_points", lambda group: (point,))
    assert encodings.parse_encoding("mirrored") == ("mirrored", "auto")
    assert {"kind": "stl", "name": "mirrored"}.items() <= encodings.describe_encodings()[-1].items()
    assert optimum(compiled("mirrored").model) == pytest.approx(optimum(compiled("onehot").model))
    with pytest.raises(UsageError, match="no formula encoding"):
        selectors.selector_named("mirror")


@pytest.mark.parametrize("name", ["auto", *selectors.SELECTORS])
@pytest.mark.parametrize(("constant", "holds"), [(-0.3, False), (0.3, True)])
def test_constants_are_demands_too(name: str, constant: float, holds: bool) -> None:
    wanted = Eventually(Linear((), constant), 0, 6)
    off = frozenset({"decide", "decide-again"})
    model = compile_mission(world(wanted), CompileOptions(name, disabled_passes=off)).model
    assert (optimum(model) is not None) == holds
