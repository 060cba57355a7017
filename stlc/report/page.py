"""The page: a template, its style and scripts from beside this file, and the data as JSON."""

from __future__ import annotations

import json
from dataclasses import asdict
from html import escape
from importlib.resources import files
from pathlib import PurePath
from typing import Any

from stlc.explain.tight import LABEL, Explained, explain_plan
from stlc.mission import Mission
from stlc.plan import Plan, as_planned
from stlc.report.charts import charts
from stlc.report.listing import listing
from stlc.report.needs import needs
from stlc.report.scene import scene
from stlc.verify.report import tidy

_SCRIPTS = ("dom.js", "map.js", "charts.js", "needs.js", "player.js")

_TEMPLATE = """<!doctype html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">
<title>{title}</title>
<link rel="icon" href="data:,">
<style>
{css}</style>
</head>
<body>
<header>
<h1>{name}</h1>
<p class="verdict {mood}">{verdict}</p>
<p class="facts">{facts}</p>
{remarks}
</header>
<main>
<section class="stage" aria-label="Map">
<div id="map"></div>
<div class="player">
<button id="play" type="button" aria-label="Play">&#9654;</button>
<input id="time" type="range" min="0" max="{horizon}" step="any" value="0" aria-label="Time">
<output id="clock" for="time"></output>
<select id="speed" aria-label="Speed"></select>
</div>
<div id="key"></div>
</section>
<section class="needs" aria-label="Requirements">
<h2>Requirements</h2>
<div id="needs"></div>
<p class="note">{note}</p>
</section>
<section class="text" aria-label="Mission">
{listing}
</section>
</main>
<section class="charts" aria-label="Signals"><h2>Over time</h2><div id="charts"></div></section>
<script type="application/json" id="data">{data}</script>
<script>
{js}</script>
</body>
</html>
"""


def page(mission: Mission, plan: Plan) -> str:
    """The whole page. Raises UsageError when the plan doesn't fit the mission."""
    mission = as_planned(mission, plan)
    found = explain_plan(mission, plan)
    plan = found.report.annotate(plan)
    cards = needs(mission, plan, found)
    data = {
        "step": mission.step,
        "horizon": mission.horizon,
        "scene": scene(mission, plan),
        "needs": [asdict(card) for card in cards],
        "charts": charts(mission, plan),
    }
    name = PurePath(mission.source.name).name
    return _TEMPLATE.format(
        title=escape(f"{name}: plan"),
        name=escape(name),
        css=_resource("report.css"),
        js="".join(map(_resource, _SCRIPTS)),
        mood="good" if found.report.ok else "bad",
        verdict=_verdict(found),
        facts=" · ".join(_facts(mission, plan)),
        remarks=_remarks(found),
        horizon=mission.horizon,
        note=_NOTE + (f" Cost: {LABEL}." if any(card.price for card in cards) else ""),
        listing=listing(mission, cards),
        data=_embedded(data),
    )


_NOTE = (
    "Each curve is the robustness, less the margin, of the condition that decides a requirement; "
    "the ring is the step that decides, and the shaded steps are those that are asked about."
)


def _resource(name: str) -> str:
    return files("stlc.report").joinpath(name).read_text(encoding="utf-8")


def _embedded(data: dict[str, Any]) -> str:
    """JSON that may stand in a script element."""
    text = json.dumps(data, allow_nan=False, separators=(",", ":"), ensure_ascii=False)
    return text.replace("</", "<\\/").replace("<!--", "<\\!--")


def _verdict(found: Explained) -> str:
    if found.report.ok:
        tail = " on the cell model only" if found.report.approximate else ""
        return f"&#10003; The plan satisfies the mission{tail}"
    count = len(found.report.violations)
    return f"&#10007; The plan violates the mission ({count} violation{'s' * (count > 1)})"


def _facts(mission: Mission, plan: Plan) -> list[str]:
    """What a reader wants to know first, escaped."""
    solve = plan.solve
    facts = [mission.summary()]
    if solve.status != "unknown":
        facts.append(solve.status)
    if solve.objective is not None:
        facts.append(f"objective {tidy(solve.objective)}")
    if solve.gap is not None:
        facts.append(f"gap {100 * solve.gap:.2g} %")
    if solve.solver:
        facts.append(solve.solver)
    if "solve" in solve.seconds:
        facts.append(f"solved in {solve.seconds['solve']:.3g} s")
    return [escape(fact) for fact in facts]


def _remarks(found: Explained) -> str:
    """Violations in full, then what is only worth knowing, folded."""
    report = found.report
    bad = [escape(str(v)) for v in (*report.violations, *report.approximate)]
    told = [*map(str, report.preferences), *report.notes]
    parts = [f'<ul class="violations">{_items(bad)}</ul>'] if bad else []
    if told:
        count = f"{len(told)} note{'s' * (len(told) > 1)}"
        parts.append(
            f"<details><summary>{count}</summary><ul>{_items(map(escape, told))}</ul></details>"
        )
    return "\n".join(parts)


def _items(lines: Any) -> str:
    return "".join(f"<li>{line}</li>" for line in lines)
