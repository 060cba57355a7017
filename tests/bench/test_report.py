"""The page stands alone; the command says what it finds."""

from __future__ import annotations

import json
import re
from html.parser import HTMLParser
from pathlib import Path

from click.testing import CliRunner, Result
from support.tiny import record, registry

from stlc.bench.page import page
from stlc.bench.store import Store
from stlc.bench.summary import summary_text
from stlc.cli.bench import bench_command
from stlc.errors import UsageError

_TRACE = ((0.1, 2.0, 0.5, 0), (0.2, 1.0, 1.0, 3))


def _runs() -> list[object]:
    runs: list[object] = []
    for size in (1.0, 2.0, 4.0):
        place = {"axes": json.dumps({"walk steps": size}), "trace": _TRACE}
        runs += [record(f"p{size:g}", "auto", 0.1 * size, rows=int(10 * size), **place)]
        runs += [record(f"p{size:g}", "<b>odd", size, **place)]
    return runs


class _Checker(HTMLParser):
    """Balanced tags; addresses that something would be fetched from."""

    def __init__(self) -> None:
        super().__init__()
        self.open: list[str] = []
        self.fetched: list[str] = []

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        if tag not in ("meta", "br", "img", "link"):
            self.open.append(tag)
        wanted = ("src", "href", "xlink:href")
        self.fetched += [v for k, v in attrs if k in wanted and v and not v.startswith("#")]

    def handle_endtag(self, tag: str) -> None:
        assert self.open.pop() == tag


def test_the_page_is_well_formed_and_needs_nothing_else() -> None:
    text = page(_runs())  # type: ignore[arg-type]
    checker = _Checker()
    checker.feed(text)
    assert checker.open == []
    assert checker.fetched == []
    assert not re.search(r"url\(\s*[\"']?(?!#)", text)
    assert "<b>odd" not in text
    assert "exponent 1.00" in text
    for title in ("Performance profile", "Cactus plot", "Gap over time", "walk over steps: rows"):
        assert title in text


def test_the_summary_names_ratios_and_disagreements() -> None:
    runs = [record("p", "auto", 1.0), record("p", "literal", 8.0, objective=2.0)]
    text = summary_text(runs)
    assert text.startswith("2 runs, 2026-01-01T00:00")
    assert "limits: 10 s, gap 0.0001, 1 thread" in text
    assert "8.00 times the reference" in text
    assert "DISAGREEMENT p: auto proves 1, literal proves 2" in text


def test_time_limits_are_read(tmp_path: Path) -> None:
    folder = str(registry(tmp_path))
    for wrong in ("soon", "log=", "log=0", "inf"):
        said = CliRunner().invoke(bench_command, ["--registry", folder, "--time-limit", wrong])
        assert said.exit_code == 2
        assert wrong in said.output


def _call(*words: str) -> Result:
    return CliRunner().invoke(bench_command, list(words), standalone_mode=False)


def test_report_against_an_older_csv(tmp_path: Path) -> None:
    for name, seconds in (("old", 1.0), ("new", 5.0)):
        store = Store(tmp_path / f"{name}.sqlite")
        store.create()
        store.add(record("p", "auto", seconds))
    csv, html = tmp_path / "old.csv", tmp_path / "new.html"
    assert (
        _call("report", "--store", str(tmp_path / "old.sqlite"), "--csv", str(csv)).exit_code == 0
    )
    said = _call("report", "--store", str(tmp_path / "new.sqlite"), "--against", str(csv),
                 "-o", str(html)).output  # fmt: skip
    assert "regression   tiny/p, auto: 1.00 s became 5.00 s (noise 25%)" in said
    assert "1 regression beyond the noise" in html.read_text()


def test_list_and_wrong_words(tmp_path: Path) -> None:
    folder = str(registry(tmp_path))
    assert "tiny: tiny ones" in _call("--registry", folder, "--list").output
    assert isinstance(_call("paper", "--registry", folder).exception, UsageError)
    assert isinstance(_call("report", "--store", str(tmp_path / "none")).exception, UsageError)
