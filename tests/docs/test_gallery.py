"""The gallery and the site: every example is in it, every picture moves."""

from __future__ import annotations

import re
from pathlib import Path

import pytest
from PIL import Image

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
