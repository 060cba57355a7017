"""Diagnostics as text, JSON, SARIF and GitHub annotations."""

from __future__ import annotations

import json
from typing import ClassVar

import pytest

from stlc.diagnostics import Diagnostic, Fix, Note
from stlc.render import STYLES, render
from stlc.render.columns import MAX_WIDTH, excerpt
from stlc.source import Source
from stlc.syntax.parse import parse


class Sample(Diagnostic):
    """A diagnostic for these tests.

    It has a second paragraph.
    """

    code: ClassVar[str] = "E9901"
    title: ClassVar[str] = "`{word}` is wrong"
    label: ClassVar[str] = "this, one"
    help: ClassVar[str] = "100% sure:\nwrite another"

    word: str


SOURCE = Source("a dir/t.stl", "step 1 s\nparam v = w\n\tparam 量 = v\n")


def sample(**more: object) -> Diagnostic:
    return Sample(word="w", span=SOURCE.span(19, 20), **more)  # type: ignore[arg-type]


def test_text_has_the_place_the_line_and_the_marks() -> None:
    note = Note("declared here", SOURCE.span(9, 14))
    found = sample(notes=(note, Note("and so on")), fix=Fix(SOURCE.span(19, 20), "2"))
    assert render([found]).split("\n") == [
        "error[E9901]: `w` is wrong",
        " --> a dir/t.stl:2:11",
        "  |",
        "2 | param v = w",
        "  |           ^ this, one",
        " --> a dir/t.stl:2:1",
        "  |",
        "2 | param v = w",
        "  | ----- declared here",
        "  = note: and so on",
        "  = help: 100% sure:\\nwrite another",
        "  = fix: param v = 2",
    ]


def test_colours_are_asked_for() -> None:
    assert "\033[" not in render([sample()])
    assert "\033[1;31m" in render([sample()], color=True)


def test_tabs_and_wide_characters_are_aligned() -> None:
    part = excerpt(SOURCE.span(28, 29))
    assert part.text == "    param 量 = v"
    assert (part.offset, part.width) == (10, 2)
    after = excerpt(SOURCE.span(32, 33))
    assert after.offset == 15


@pytest.mark.parametrize("start", [0, 30, 500, 990, 999])
def test_long_lines_are_cut_around_the_mistake(start: int) -> None:
    text = "".join(chr(97 + k % 26) for k in range(1000))
    part = excerpt(Source("t", text).span(start, start + 1))
    assert len(part.text) <= MAX_WIDTH + 4
    assert part.text[part.offset] == text[start]


def test_a_place_at_the_end_of_the_file_is_shown() -> None:
    end = len(SOURCE.text)
    assert " --> a dir/t.stl:4:1" in render([Sample(word="w", span=SOURCE.span(end, end))])


def test_a_diagnostic_without_a_place() -> None:
    for style in STYLES:
        assert "E9901" in render([Sample(word="w")], style)


def test_json_has_every_field() -> None:
    found = sample(notes=(Note("n"),), fix=Fix(SOURCE.span(19, 20), "2"))
    (shown,) = json.loads(render([found], "json"))["diagnostics"]
    assert shown["code"] == "E9901"
    assert shown["span"]["start"] == {"offset": 19, "line": 2, "column": 11}
    assert shown["span"]["end"] == {"offset": 20, "line": 2, "column": 12}
    assert shown["notes"] == [{"text": "n", "span": None}]
    assert shown["fix"]["replacement"] == "2"


def test_sarif_is_a_log_of_results_with_their_rules() -> None:
    found = sample(notes=(Note("n", SOURCE.span(0, 4)),), fix=Fix(SOURCE.span(19, 20), "2"))
    warning = parse(Source("w.stl", "require: always p and q")).diagnostics[0]
    log = json.loads(render([found, warning], "sarif"))
    (run,) = log["runs"]
    assert log["version"] == "2.1.0"
    rules = run["tool"]["driver"]["rules"]
    assert [rule["id"] for rule in rules] == ["E9901", "W0101"]
    first, second = run["results"]
    assert rules[first["ruleIndex"]]["id"] == first["ruleId"]
    assert (first["level"], second["level"]) == ("error", "warning")
    place = first["locations"][0]["physicalLocation"]
    assert place["artifactLocation"]["uri"] == "a%20dir/t.stl"
    assert (place["region"]["startLine"], place["region"]["startColumn"]) == (2, 11)
    assert first["relatedLocations"][0]["message"]["text"] == "n"
    assert first["fixes"][0]["artifactChanges"][0]["replacements"][0]["insertedContent"] == {
        "text": "2"
    }


def test_github_commands_are_escaped() -> None:
    assert render([sample()], "github") == (
        "::error file=a dir/t.stl,line=2,endLine=2,col=11,endColumn=12,"
        "title=E9901%3A `w` is wrong::this, one%0A100%25 sure:%0Awrite another"
    )


def test_nothing_found_is_no_text() -> None:
    assert render([]) == ""
    assert json.loads(render([], "json"))["diagnostics"] == []
    assert json.loads(render([], "sarif"))["runs"][0]["results"] == []
