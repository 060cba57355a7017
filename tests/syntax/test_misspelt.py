"""A misspelt word is recognised where the parser stops, and mended by the fix that is offered."""

from __future__ import annotations

import pytest

from stlc.diagnostics import Diagnostic
from stlc.grammar.units import UNITS, nearest_unit
from stlc.source import Source
from stlc.syntax.parse import parse


def only_mistake(text: str) -> Diagnostic:
    (found,) = parse(Source("m.stl", text)).diagnostics
    return found


@pytest.mark.parametrize(
    ("text", "mended"),
    [
        ("require a: evntually[0, 5] x > 0", "require a: eventually[0, 5] x > 0"),
        ("require a: allways x > 0", "require a: always x > 0"),
        ("require a: x > 0 adn y > 0", "require a: x > 0 and y > 0"),
        ("require a: r in g untill[0, 3] y > 0", "require a: r in g until[0, 3] y > 0"),
        ("require a: x >= 0.4 mtr", "require a: x >= 0.4 m"),
        ("require a: always[0, 5 sec] x > 0", "require a: always[0, 5 s] x > 0"),
        ("require a: x > 3 dbm and y > 0", "require a: x > 3 dBm and y > 0"),
    ],
)
def test_the_fix_makes_the_statement_valid(text: str, mended: str) -> None:
    mistake = only_mistake(text)
    assert mistake.fix is not None
    span = mistake.fix.span
    assert text[: span.start] + mistake.fix.replacement + text[span.end :] == mended
    assert not parse(Source("m.stl", mended)).diagnostics


@pytest.mark.parametrize(
    ("text", "title"),
    [
        ("require a: eventually(0, 5) x > 0", "the interval of `eventually` stands in round"),
        ("require a: eventually 5 x > 0", "the interval of `eventually` stands in square"),
        ("require a = always x > 0", "`:` is missing after the requirement's name"),
        ("agent a : cart { start (1, 1; speed <= 2 }", "`(` is never closed"),
        ("workspace box ..", "`..` can't begin a box"),
        ("region g = box (0, 0) (1, 1)", "`(` can't begin a box"),
        ("region g = polygon [0, 1]", "`[` can't begin a polygon"),
        ("region g = box [0, ] x [0, 1]", "a side of a box has two ends"),
        ("minimize effort, link_cost(radio)", "costs are added up"),
        ("region g = circle (1, 2) 3", "there is no shape `circle`"),
        ("require a: x > 3 furlongs", "`3 furlongs` is neither"),
        ("require a: always r avoids p", "`avoids` is no operator"),
        ("require a: r reaches g", "`reaches` is no operator"),
        ("require a: x > 3 y > 4", "two formulas side by side"),
        ("region goal box [0, 1] x [0, 1]", "`=` is missing"),
    ],
)
def test_other_mistakes_are_named(text: str, title: str) -> None:
    assert only_mistake(text).title_text.startswith(title)


def test_every_unit_is_its_own_nearest_but_for_case() -> None:
    assert all((nearest_unit(unit) or "").lower() == unit.lower() for unit in UNITS)
    assert [nearest_unit(word) for word in ("MHz", "mW", "furlongs")] == ["MHz", "mW", None]
