"""Monsters: located errors, no traceback, no recursion."""

from __future__ import annotations

from pathlib import Path

import pytest

from stlc.api import loads
from stlc.errors import MissionError, UsageError
from stlc.source import Source
from stlc.syntax.compare import same_syntax
from stlc.syntax.lalr import MAX_DEPTH
from stlc.syntax.parse import MAX_MISTAKES, parse
from stlc.syntax.print_expr import show
from stlc.syntax.printer import format_file
from stlc.syntax.read import decode, read_source
from stlc.syntax.screen import MAX_FILE


def codes(text: str) -> list[str]:
    result = parse(Source("t.stl", text))
    assert all(d.span is not None for d in result.diagnostics)
    return [d.code for d in result.diagnostics]


@pytest.mark.parametrize(
    "text",
    ["(" * 50_000 + "x" + ")" * 50_000, "[" * 50_000, "not " * 50_000 + "x", "-" * 50_000 + "x",
     "p" + " -> p" * 50_000, "{" * 50_000, "f(" * 50_000],
)  # fmt: skip
def test_deep_nesting_is_a_located_error(text: str) -> None:
    assert codes(f"require a: {text}\nrequire b: x > 0") == ["E0106"]


def test_depth_up_to_the_limit_is_fine() -> None:
    depth = MAX_DEPTH - 10
    result = parse(Source("t.stl", "require: " + "(" * depth + "x > 0" + ")" * depth))
    assert result.ok
    nested = parse(Source("t.stl", "let f = " + "-" * depth + "x"))
    assert nested.ok
    (statement,) = nested.file.statements
    assert show(statement.body).count("-") == depth  # type: ignore[attr-defined]


def test_a_long_flat_chain_is_no_nesting() -> None:
    assert codes("require: p" + " and p" * 5_000) == []


def test_a_line_of_ten_megabytes() -> None:
    assert codes("x " * 5_000_000) == ["E0113"]


def test_a_file_beyond_all_measure() -> None:
    assert codes("#" + " " * MAX_FILE) == ["E0113"]


def test_mistakes_are_counted_out() -> None:
    found = codes("require\n" * 200)
    assert len(found) == MAX_MISTAKES + 1
    assert found[-1] == "E0114"


def test_nul_bytes() -> None:
    assert set(codes("require a: x\0 > 0\0\n")) == {"E0102"}


@pytest.mark.parametrize(
    "data",
    [b"step 1 s\n\xff", "step 1 s".encode("utf-16"), b"\x80" + b"\0" * 83 + b"x" * 50,
     b"solid a\nfacet normal 0 0 1\n", b"\0" * 80 + (2).to_bytes(4, "little") + b"\0" * 100],
)  # fmt: skip
def test_what_is_no_mission_file_says_so(data: bytes) -> None:
    with pytest.raises(MissionError) as caught:
        decode("site.stl", data)
    (mistake,) = caught.value.diagnostics
    assert mistake.code == "E0112"
    assert mistake.span is not None


def test_a_byte_order_mark_is_no_text() -> None:
    assert decode("t.stl", b"\xef\xbb\xbfstep 1 s").text == "step 1 s"


def test_a_file_that_is_not_there_is_a_usage_error(tmp_path: Path) -> None:
    with pytest.raises(UsageError, match=r"cannot read .*none\.stl"):
        read_source(tmp_path / "none.stl")
    with pytest.raises(UsageError):
        read_source(tmp_path)
    with pytest.raises(UsageError):
        read_source("a\0b")


@pytest.mark.parametrize("operator", ["+", "-", "*", "/"])
def test_a_flat_chain_of_operations_does_not_nest(operator):
    text = f"horizon 3\nsignal a\nrequire r: always a{f' {operator} 2' * 5000} >= 1\n"
    if operator in "*/":
        text = text.replace(" 2", " 1")
    again = format_file(parse(Source("x", text)).file)
    assert same_syntax(parse(Source("x", text)).file, parse(Source("x", again)).file)
    assert loads(text).requirements


def test_a_flat_objective_does_not_nest():
    head = "horizon 3\nagent r : single_integrator { start (0, 0); control |u| <= 1 }\n"
    mission = loads(head + f"minimize {' + '.join(['effort * 1 * 2 / 2'] * 2000)}\n")
    assert sum(t.weight for t in mission.objective) == 2000
    assert loads(head + f"minimize effort{' * 1' * 2000}\n").objective


def test_brackets_in_a_chain_still_nest():
    text = "require r: " + "(a + " * 300 + "a" + ")" * 300 + " >= 1\n"
    found = parse(Source("x", text)).diagnostics
    assert [d.code for d in found] == ["E0106"]
    left = "require r: " + "(" * 300 + "a" + " + a)" * 300 + " >= 1\n"
    assert [d.code for d in parse(Source("x", left)).diagnostics] == ["E0106"]
