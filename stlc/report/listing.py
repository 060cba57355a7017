"""The text of the mission, each line with the requirements that stand in it."""

from __future__ import annotations

from html import escape
from pathlib import PurePath

from stlc.mission import Mission
from stlc.report.needs import Need
from stlc.source import Source

_CLASSES = {
    "Comment": "c", "Keyword": "k", "Number": "n", "Literal.Number": "n", "String": "s",
    "Literal.String": "s", "Operator.Word": "o", "Name.Function": "f",
}  # fmt: skip


def listing(mission: Mission, needs: list[Need]) -> str:
    """The file, and those it imports where requirements stand in them, as HTML."""
    sources = {mission.source.name: mission.source}
    for r in mission.requirements:
        if r.span is not None:
            sources.setdefault(r.span.source.name, r.span.source)
    return "\n".join(_file(source, needs) for source in sources.values())


def _file(source: Source, needs: list[Need]) -> str:
    """One file: a heading and its lines."""
    name = PurePath(source.name).name
    here = [(k, n, n.lines) for k, n in enumerate(needs) if n.source == source.name and n.lines]
    lines = []
    for number, html in enumerate(coloured(source.text), start=1):
        mine = [(k, n) for k, n, lines in here if lines[0] <= number <= lines[1]]
        lines.append(_line(html, mine))
    return f'<h2>{escape(name)}</h2>\n<ol class="code">{"".join(lines)}</ol>'


def _line(html: str, mine: list[tuple[int, Need]]) -> str:
    """A line; green or red, and open to the pointer, where requirements stand in it."""
    if not mine:
        return f"<li><code>{html}</code></li>"
    mood = "good" if all(n.ok for _, n in mine) else "bad"
    of = " ".join(str(k) for k, _ in mine)
    return f'<li class="{mood}" data-needs="{of}" tabindex="0"><code>{html}</code></li>'


def coloured(text: str) -> list[str]:
    """Lines of HTML, words in spans by what they are."""
    from stlc.grammar.pygments_lexer import StlLexer

    parts = []
    for kind, word in StlLexer(stripnl=False, ensurenl=False).get_tokens(text):
        css = _class(str(kind).removeprefix("Token."))
        for k, piece in enumerate(word.split("\n")):
            if k:
                parts.append("\n")
            if piece:
                html = escape(piece)
                parts.append(f'<span class="{css}">{html}</span>' if css else html)
    return "".join(parts).rstrip("\n").split("\n")


def _class(kind: str) -> str:
    while kind:
        if kind in _CLASSES:
            return _CLASSES[kind]
        kind = kind.rpartition(".")[0]
    return ""
