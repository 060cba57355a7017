"""The site: `make docs`."""

from __future__ import annotations

import re
import sys
from pathlib import Path
from typing import Any

from pygments.lexers.special import TextLexer

from stlc.grammar.pygments_lexer import StlLexer
from stlc.version import __version__

sys.path.insert(0, str(Path(__file__).parent))
(Path(__file__).parent / "_gallery").mkdir(exist_ok=True)

project = "stlc"
release = version = __version__
extensions = ["myst_parser", "sphinx.ext.autodoc", "extras"]
html_theme = "furo"
html_title = f"stlc {version}"
html_copy_source = False
myst_heading_anchors = 3
myst_enable_extensions = ["dollarmath"]
exclude_patterns = ["_build", "_gallery"]
html_extra_path = ["_gallery"]
autodoc_member_order = "bysource"
autodoc_typehints_format = "short"

_PLAIN = ("breach", "csv", "rtamt", "falcaun", "pgm", "stl-library")
"""Languages of code blocks that nobody has colours for."""


def _as_text(app: Any, what: str, name: str, thing: Any, options: Any, lines: list[str]) -> None:
    """Docstrings are plain text with code in single backticks: so says reStructuredText too."""
    for number, line in enumerate(lines):
        parts = line.split("`")
        parts[::2] = [re.sub(r"([*|_\\])", r"\\\1", part) for part in parts[::2]]
        lines[number] = "``".join(parts)


def setup(app: Any) -> None:
    """Called by Sphinx."""
    app.connect("autodoc-process-docstring", _as_text)
    app.add_lexer("stl", StlLexer)
    for name in _PLAIN:
        app.add_lexer(name, TextLexer)
