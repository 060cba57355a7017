"""The site: `make docs`."""

from __future__ import annotations

from typing import Any

from pygments.lexers.special import TextLexer

from stlc.grammar.pygments_lexer import StlLexer
from stlc.version import __version__

project = "stlc"
release = version = __version__
extensions = ["myst_parser", "sphinx.ext.autodoc", "sphinx.ext.mathjax"]
html_theme = "furo"
html_title = f"stlc {version}"
html_copy_source = False
myst_heading_anchors = 3
myst_enable_extensions = ["dollarmath"]
exclude_patterns = ["_build"]

_PLAIN = ("breach", "csv", "rtamt", "falcaun", "pgm", "stl-library")
"""Languages of code blocks that nobody has colours for."""


def setup(app: Any) -> None:
    """Called by Sphinx."""
    app.add_lexer("stl", StlLexer)
    for name in _PLAIN:
        app.add_lexer(name, TextLexer)
