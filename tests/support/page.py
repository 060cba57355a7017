"""A report in V8, with a stand-in for the document of a browser (`dom.js`)."""

from __future__ import annotations

import json
from html.parser import HTMLParser
from pathlib import Path
from typing import Any

from py_mini_racer import MiniRacer

VOID = {"meta", "link", "input"}


class Page(HTMLParser):
    """A page's elements and scripts; AssertionError for elements that don't nest."""

    def __init__(self, html: str) -> None:
        super().__init__()
        self.elements: list[tuple[str, dict[str, str]]] = []
        self.texts: list[tuple[dict[str, str], str]] = []
        self._open: list[str] = []
        self.feed(html)
        self.close()
        assert not self._open

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.elements.append((tag, {k: v or "" for k, v in attrs}))
        if tag not in VOID:
            self._open.append(tag)

    def handle_endtag(self, tag: str) -> None:
        assert self._open.pop() == tag

    def handle_data(self, data: str) -> None:
        if self._open and self._open[-1] == "script":
            self.texts.append((self.elements[-1][1], data))

    @property
    def data(self) -> Any:
        """What the page knows of mission and plan."""
        return json.loads(next(text for attributes, text in self.texts if attributes))

    def run(self) -> MiniRacer:
        """The page after its script has run; an exception for what a console would show."""
        engine = MiniRacer()
        engine.eval((Path(__file__).parent / "dom.js").read_text(encoding="utf-8"))
        engine.eval(f"build({json.dumps(self.elements)});")
        raw = next(text for attributes, text in self.texts if attributes)
        engine.eval(f"ids.data.textContent = {json.dumps(raw)}")
        engine.eval(next(text for attributes, text in self.texts if not attributes))
        return engine
