"""Parameters, overrides, lets and imports."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from stlc.api import load, loads
from stlc.errors import MissionError
from stlc.ir.nodes import Always, Linear, Node
from stlc.mission import Mission
from stlc.sema.overrides import parse_value
from stlc.sema.units import METRE

BASE = "signal s [m]\nparam v = 2 m\nparam w = 2 * v + 1\n"


def threshold(mission: Mission) -> float:
    node: Node = mission.requirements[0].formula
    assert isinstance(node, Always)
    assert isinstance(node.arg, Linear)
    return -node.arg.constant


def codes(text: str, **params: str | float) -> list[str]:
    with pytest.raises(MissionError) as caught:
        loads(text, params=params)
    return [d.code for d in caught.value.diagnostics]


def test_parameters_may_use_one_another_in_any_order() -> None:
    text = "signal s [m]\nparam w = 2 * v + 1\nparam v = 2 m\nrequire: always[0, 3] s >= w\n"
    assert threshold(loads(text)) == 5.0


@pytest.mark.parametrize(("value", "expected"), [(3, 7), ("3", 7), ("300 cm", 7), ("1e-3 km", 3)])
def test_overrides(value: str | float, expected: float) -> None:
    mission = loads(BASE + "require: always[0, 3] s >= w\n", params={"v": value})
    assert threshold(mission) == pytest.approx(expected)


def test_overrides_that_mean_nothing() -> None:
    text = BASE + "require: always[0, 3] s >= w\n"
    assert codes(text, u=3) == ["E0220"]
    assert codes(text, v="three") == ["E0222"]
    assert codes(text, v="3 s") == ["E0306"]
    assert codes(text, v=float("nan")) == ["E0222"]


def test_values_of_overrides() -> None:
    value = parse_value(" -2.5e1 m ")
    assert value is not None
    assert (value.constant, value.unit) == (-25.0, METRE)
    assert parse_value("") is None
    assert parse_value("1 m m2") is None


def test_lets_are_hygienic() -> None:
    text = BASE + (
        "let above(x) = s >= x\nlet inner(s) = above(3 m)\nrequire: always[0, 3] inner(7)\n"
    )
    assert threshold(loads(text)) == 3.0


def test_imports_are_read_once_and_only_from_the_folder(tmp_path: Path) -> None:
    (tmp_path / "lib").mkdir()
    (tmp_path / "lib" / "one.stl").write_text('import "two.stl"\nlet low(x) = s >= x\n')
    (tmp_path / "lib" / "two.stl").write_text("signal s [m]\n")
    main = tmp_path / "main.stl"
    main.write_text('import "lib/one.stl"\nimport "lib/two.stl"\nrequire: always[0, 3] low(4 m)\n')
    assert threshold(load(main)) == 4.0
    inner = tmp_path / "inner"
    inner.mkdir()
    outside = inner / "outside.stl"
    outside.write_text('import "../lib/one.stl"\nrequire: always[0, 3] low(4 m)\n')
    with pytest.raises(MissionError) as caught:
        load(outside)
    assert [d.code for d in caught.value.diagnostics] == ["E0215", "E0201"]
    assert threshold(load(outside, allow_paths=[tmp_path])) == 4.0


def test_a_link_does_not_lead_out_of_the_folder(tmp_path: Path) -> None:
    secret = tmp_path / "secret.stl"
    secret.write_text("signal s\n")
    folder = tmp_path / "mission"
    folder.mkdir()
    (folder / "way.stl").symlink_to(secret)
    main = folder / "main.stl"
    main.write_text('import "way.stl"\nsignal q\nrequire: always[0, 3] q >= 1\n')
    with pytest.raises(MissionError) as caught:
        load(main)
    assert [d.code for d in caught.value.diagnostics] == ["E0215"]


def test_mistakes_in_a_library_are_shown_there(tmp_path: Path) -> None:
    (tmp_path / "lib.stl").write_text("let low(x) = q >= x\n")
    main = tmp_path / "main.stl"
    main.write_text('import "lib.stl"\nrequire: always[0, 3] low(4)\n')
    with pytest.raises(MissionError) as caught:
        load(main)
    (found,) = caught.value.diagnostics
    assert found.span is not None
    assert found.span.source.name == "lib.stl"
    assert [n.text for n in found.notes] == ["in this use of `low`"]


def test_a_text_alone_reads_no_files() -> None:
    assert codes('import "lib.stl"\nsignal q\nrequire: always[0, 3] q >= 1\n') == ["E0215"]


def test_a_parameter_may_have_the_name_of_what_it_bounds() -> None:
    text = """param speed = 2 m/s
param v = 3
param vx = 0.5
agent a : double_integrator { start (0, 0); control |u| <= v; speed <= speed; vx in [-vx, vx] }
agent b : double_integrator { start (0, 0); control |u| <= 1; speed >= 0, vy <= vx }
require r: eventually[0, 1] a.x >= -1
"""
    found = loads(text.replace("speed >= 0, vy <= vx", "vy <= vx; speed <= v")).agents
    assert [n.limit for n in found["a"].state_norms] == [2.0]
    assert found["a"].input_upper.tolist() == [3.0, 3.0]
    assert found["a"].state_upper[2] == 0.5
    assert found["b"].state_upper.tolist()[2:] == [np.inf, 0.5]
    assert [n.limit for n in found["b"].state_norms] == [3.0]
