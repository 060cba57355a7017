"""Every mistake in an imported file has a place and a reason, and nothing raises anything else."""

from __future__ import annotations

from fractions import Fraction

import pytest
from hypothesis import given
from hypothesis import strategies as st

from stlc.diagnostics import Diagnostic
from stlc.dialects import DIALECTS, import_text
from stlc.errors import MissionError
from stlc.source import Source

CASES = [
    ("rtamt", "always (a -> once[0,2] b)", "E0902", "once"),
    ("rtamt", "a since b", "E0902", "since"),
    ("rtamt", "rise(a) and b", "E0902", "rise"),
    ("rtamt", "prev a >= 2", "E0902", "prev"),
    ("rtamt", "H[0,1] a", "E0902", "H"),
    ("breach", "a := hist_[0,1] x[t] > 2", "E0902", "hist_"),
    ("rtamt", "a * b >= 2", "E0903", "a * b"),
    ("rtamt", "sqrt(a) >= 2", "E0903", "sqrt(a)"),
    ("rtamt", "2 / a >= 2", "E0903", "2 / a"),
    ("breach", "a := x[t]^2 < 4", "E0903", "x[t]^2"),
    ("rtamt", "a + eventually[0,2] b >= 1", "E0904", "eventually[0,2] b >= 1"),
    ("rtamt", "(always a) iff b", "E0904", "(always a) iff b"),
    ("breach", "a := x[2*t] > 1", "E0904", "2*t"),
    ("breach", "a := alw (x[t] > mod(c, 2))", "E0904", "mod(c, 2)"),
    ("breach", 'test go: "env", 3, true { }', "E0904", "test"),
    ("breach", "a := x[t-1] > 1", "E0905", "t-1"),
    ("breach", "a := alw_[3, 1] x[t] > 1", "E0905", "[3, 1]"),
    ("breach", "a := alw_[-1, 1] x[t] > 1", "E0905", "-1"),
    ("falcaun", "[]_[0, 1.5] signal(0) > 1", "E0905", "1.5"),
    ("breach", "a := alw_[0, 1e9] x[t] > 1", "E0905", "1e9"),
    ("breach", "a := alw x[t]", "E0901", "x[t]"),
    ("breach", "a := (x[t] > 1", "E0901", ""),
    ("falcaun", "[] signal(0) < ", "E0901", ""),
    ("rtamt", "a >= 2 b", "E0901", "b"),
    ("rtamt", "foo(a) >= 2", "E0901", "("),
    ("rtamt", "abs(a, b) >= 2", "E0901", "abs(a, b)"),
    ("rtamt", "a ? b", "E0901", "?"),
    ("rtamt", "0 - 2", "E0906", "0 - 2"),
]


@pytest.mark.parametrize(("dialect", "text", "code", "place"), CASES)
def test_mistakes_have_a_place(dialect: str, text: str, code: str, place: str) -> None:
    with pytest.raises(MissionError) as caught:
        import_text(Source("spec", text), dialect)
    first = caught.value.diagnostics[0]
    assert first.code == code
    assert first.span is not None
    assert first.span.text == place
    assert first.title_text
    assert first.help_text is not None


def test_a_time_that_is_no_whole_number_of_steps_names_the_nearest() -> None:
    with pytest.raises(MissionError) as caught:
        import_text(Source("spec", "a := ev_[0, 0.25] x[t] > 1"), "breach", Fraction(1, 10))
    assert "0.2 s and 0.3 s" in caught.value.diagnostics[0].help_text


def test_every_bad_statement_is_told() -> None:
    text = "a = once b;\nc = x * y;\nd = prev x;\ne = x >= 2;"
    with pytest.raises(MissionError) as caught:
        import_text(Source("spec", text), "rtamt")
    assert [d.span.line for d in caught.value.diagnostics if d.span] == [1, 3]
    text = "a := x[t]*y[t] > 1\nb := x[t]^2 > 1"
    with pytest.raises(MissionError) as caught:
        import_text(Source("spec", text), "breach")
    assert [d.span.line for d in caught.value.diagnostics if d.span] == [1, 2]


def attempt(text: str, dialect: str) -> tuple[str, tuple[Diagnostic, ...]]:
    """The imported file, or the mistakes in it."""
    try:
        return import_text(Source("spec", text), dialect).text, ()
    except MissionError as error:
        return "", error.diagnostics


FRAGMENTS = st.sampled_from(
    ["always", "alw_[0,2]", "[]", "<>_[1,3]", "(", ")", "x", "x[t]", "x[t+1]", "signal(0)", ">",
     "<=", "==", "2", "0.5", "-", "+", "*", "/", "and", "&&", "or", "->", "=>", "not", "!",
     "until[0,1]",
     "U", "since", "once", "[", "]", ",", ";", ":=", "=", "param", "float", "const", "true", "abs(",
     "min(", "\n", "s", "ms", "$v", "#", "//", "é", "\0", '"', "_", "1e400", "inf"]
)  # fmt: skip


@pytest.mark.parametrize("dialect", DIALECTS)
@given(parts=st.lists(FRAGMENTS, max_size=25))
def test_any_text_gives_a_file_or_located_mistakes(dialect: str, parts: list[str]) -> None:
    text, mistakes = attempt(" ".join(parts), dialect)
    assert all(d.span is not None for d in mistakes)
    assert mistakes or text.startswith("# Imported from spec")


@pytest.mark.parametrize("dialect", DIALECTS)
@pytest.mark.parametrize(
    "text", ["(" * 50_000, "not " * 5_000 + "x", "x + " * 5_000 + "x > 1", "-" * 5_000 + "x"]
)
def test_deep_nesting_is_refused(dialect: str, text: str) -> None:
    with pytest.raises(MissionError) as caught:
        import_text(Source("spec", text), dialect)
    assert caught.value.diagnostics[0].span is not None


@pytest.mark.parametrize("dialect", DIALECTS)
def test_long_conjunctions_are_read(dialect: str) -> None:
    atom = {"breach": "x[t] > 1", "rtamt": "x > 1", "falcaun": "signal(0) > 1"}[dialect]
    word = "&&" if dialect == "falcaun" else "and"
    text = import_text(Source("spec", f" {word} ".join([atom] * 300)), dialect).text
    assert text.count(" > 1") == 300


@pytest.mark.parametrize("dialect", DIALECTS)
def test_endless_lines_are_refused(dialect: str) -> None:
    with pytest.raises(MissionError) as caught:
        import_text(Source("spec", "(" * 2_000_000), dialect)
    assert caught.value.diagnostics[0].code == "E0113"


def test_formulas_as_numbers_do_not_grow_without_bound() -> None:
    lines = ["c0 = x >= 1;", *(f"c{k} = c{k - 1} and c{k - 1};" for k in range(1, 40))]
    with pytest.raises(MissionError) as caught:
        import_text(Source("spec", "\n".join([*lines, "c39 >= 2;"])), "rtamt")
    assert [d.code for d in caught.value.diagnostics] == ["E0904"]
