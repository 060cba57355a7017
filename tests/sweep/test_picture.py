"""Pictures of sweeps: what is written in them."""

from __future__ import annotations

from pathlib import Path

from stlc.sweep import Answer, Axis
from stlc.sweep.picture import draw


def _drawn(tmp_path: Path, axes: list[Axis], found: dict[tuple[str, ...], Answer]) -> str:
    """The texts of a sweep's picture."""
    points_ = [(tuple(zip([a.name for a in axes], k, strict=True)), v) for k, v in found.items()]
    draw(tmp_path / "p.svg", axes, None, points_)
    return (tmp_path / "p.svg").read_text()


def test_two_parameters_make_a_map(tmp_path: Path) -> None:
    axes = [Axis("v", ("1", "2", "3")), Axis("w", ("fast",)), Axis("end", ("4 s", "6 s"))]
    found = {
        ("1", "fast", "4 s"): Answer("infeasible"),
        ("2", "fast", "4 s"): Answer("no_plan"),
        ("3", "fast", "4 s"): Answer("optimal", 12.34, 12.34, plan="{}"),
        ("1", "fast", "6 s"): Answer("feasible", 56.78, 50.0, plan="{}"),
        ("2", "fast", "6 s"): Answer("optimal", 9.0, 9.0, plan="{}"),
    }
    text = _drawn(tmp_path, axes, found)
    for word in (">12.3<", ">~56.8<", ">9<", ">×<", ">?<", ">4 s<", ">v<", ">end<"):
        assert word in text, word
    assert "× no plan exists    ~ not proven best    ? no plan found" in text
    lone = _drawn(tmp_path, axes, {("3", "fast", "4 s"): found["3", "fast", "4 s"]})
    assert "no plan" not in lone


def test_one_parameter_makes_a_line(tmp_path: Path) -> None:
    axes = [Axis("v", ("1", "2")), Axis("w", ("fast",))]
    found = {(v, "fast"): Answer("optimal", 3.0, 3.0, plan="{}") for v in ("1", "2")}
    text = _drawn(tmp_path, axes, found)
    assert ">objective<" in text
    assert ">end<" not in text
