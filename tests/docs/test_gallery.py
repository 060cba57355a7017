"""The gallery and the site: every example is in it, every picture moves."""

from __future__ import annotations

import re
import runpy
from pathlib import Path

import pytest
from PIL import Image
from support.command import MISSION

import stlc

ROOT = Path(__file__).parents[2]
DOCS = ROOT / "docs"
EXAMPLES = sorted((ROOT / "examples").iterdir())
PICTURES = sorted(DOCS.rglob("*.gif"))


def test_every_example_is_in_the_gallery() -> None:
    text = (DOCS / "gallery.md").read_text(encoding="utf-8")
    for path in EXAMPLES:
        if path.suffix in (".stl", ".ipynb"):
            assert f"examples/{path.name}" in text


def test_every_example_has_a_picture_or_says_where() -> None:
    text = (DOCS / "gallery.md").read_text(encoding="utf-8")
    shown = re.findall(r"^```{mission} (\w+)$", text, re.M)
    gallery = runpy.run_path(str(ROOT / "examples" / "gallery.py"))
    stems = {p.stem for p in EXAMPLES if p.suffix == ".stl"}
    assert sorted(shown) == sorted(stems - gallery["ELSEWHERE"])
    assert {p.stem for p in (DOCS / "gallery").glob("*.json")} <= stems


def test_a_kept_plan_is_drawn_and_shown(tmp_path: Path) -> None:
    gallery = runpy.run_path(str(ROOT / "examples" / "gallery.py"))
    assert gallery["shown"](ROOT / "examples" / "trade_places.stl", tmp_path)
    made = {p.suffix: p.stat().st_size for p in tmp_path.iterdir()}
    assert made.keys() == {".json", ".png", ".html"}
    assert (tmp_path / "trade_places.json").read_text() == (
        DOCS / "gallery" / "trade_places.json"
    ).read_text()


def test_a_plan_of_another_mission_is_made_anew(tmp_path: Path) -> None:
    gallery = runpy.run_path(str(ROOT / "examples" / "gallery.py"))
    (tmp_path / "m.stl").write_text(MISSION)
    other = (DOCS / "gallery" / "trade_places.json").read_text()
    (tmp_path / "out").mkdir()
    (tmp_path / "out" / "m.json").write_text(other)
    assert gallery["shown"](tmp_path / "m.stl", tmp_path / "out")
    assert (tmp_path / "out" / "m.json").read_text() != other


@pytest.mark.parametrize("path", [p for p in EXAMPLES if p.suffix == ".stl"], ids=lambda p: p.stem)
def test_examples_have_no_warning(path: Path) -> None:
    assert stlc.load(path).check() == ()


def test_pictures_are_shown_move_and_are_small() -> None:
    shown = "".join(p.read_text(encoding="utf-8") for p in [*DOCS.glob("*.md"), ROOT / "README.md"])
    for path in PICTURES:
        assert f"{path.relative_to(DOCS)})" in shown
        assert path.stat().st_size < 300_000
        with Image.open(path) as picture:
            assert picture.n_frames > 50


def test_the_site_has_every_page() -> None:
    listed = re.search(r"```{toctree}(.*?)```", (DOCS / "index.md").read_text(), re.DOTALL)
    assert listed is not None
    pages = {line for line in listed[1].split() if not line.startswith(":")} - {"1"}
    assert pages == {p.stem for p in DOCS.glob("*.md")} - {"index"}


def test_links_between_pages_are_whole() -> None:
    for page in [*DOCS.glob("*.md"), ROOT / "README.md"]:
        for target in re.findall(r"\]\(([^)#\s]+)(?:#[^)]*)?\)", page.read_text(encoding="utf-8")):
            if "://" not in target:
                assert (page.parent / target).exists(), f"{page.name}: {target}"
