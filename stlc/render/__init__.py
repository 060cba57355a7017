"""Shows diagnostics to people and to programs."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Final, Literal, assert_never, get_args

from stlc.diagnostics import Diagnostic

Style = Literal["text", "json", "sarif", "github"]
STYLES: Final[tuple[Style, ...]] = get_args(Style)


def render(diagnostics: Iterable[Diagnostic], style: Style = "text", *, color: bool = False) -> str:
    """All diagnostics in one style; text ends without a newline, and is empty for none.

    `text` is for people (`color` adds ANSI colours), `json` one document, `sarif` a SARIF 2.1.0
    log, `github` workflow commands that annotate a pull request.
    """
    found = tuple(diagnostics)
    match style:
        case "text":
            from stlc.render.text import render_text

            return "\n\n".join(render_text(d, color=color) for d in found)
        case "json":
            from stlc.render.json import render_json

            return render_json(found)
        case "sarif":
            from stlc.render.sarif import render_sarif

            return render_sarif(found)
        case "github":
            from stlc.render.github import render_github

            return "\n".join(render_github(d) for d in found)
        case _:
            assert_never(style)
