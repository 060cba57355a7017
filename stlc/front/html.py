"""Missions and plans as notebooks show them."""

from __future__ import annotations

from html import escape
from pathlib import PurePath
from typing import TYPE_CHECKING

from stlc.report.listing import coloured
from stlc.verify.report import tidy
from stlc.verify.requirement_report import slack_of

if TYPE_CHECKING:
    from stlc.front.plan import Plan

_COLOURS = {"c": "#75808d", "k": "#0b5cab", "n": "#8a3a00", "s": "#00664a", "o": "#0b5cab",
            "f": "#6a3fa0"}  # fmt: skip


def mission_html(name: str, text: str) -> str:
    """The text, its words coloured."""
    body = "\n".join(coloured(text))
    for css, colour in _COLOURS.items():
        body = body.replace(f'<span class="{css}">', f'<span style="color:{colour}">')
    return f"<b>{escape(PurePath(name).name)}</b><pre>{body}</pre>"


def plan_html(plan: Plan) -> str:
    """Verdict, objective, and a row for each requirement."""
    rows = "".join(
        f"<tr><td>{'&#10003;' if r.satisfied else '&#10007;'}</td>"
        f'<td style="text-align:left">{escape(r.name)}</td>'
        f"<td>{_slack(slack_of(r))} {escape(r.critical[1] if r.critical else '')}</td>"
        f"<td>{r.critical[0] if r.critical else ''}</td>"
        f'<td style="text-align:left">{escape(r.says)}</td></tr>'
        for r in plan.report.requirements
    )
    heads = "<tr><th></th><th>requirement</th><th>slack</th><th>step</th><th>decided by</th></tr>"
    return f"<b>{escape(repr(plan)[1:-1])}</b><table>{heads}{rows}</table>"


def _slack(value: float | None) -> str:
    if value is None:
        return "-"
    return "0" if abs(value) <= 1e-6 else tidy(value, 4)
