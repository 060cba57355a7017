"""The report as one HTML page that needs nothing else: no network, no other file."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from html import escape
from importlib.resources import files

from stlc.bench.about import about, commands
from stlc.bench.compare import Change
from stlc.bench.families import Family, Spread, families_of, gap_title, spread_text
from stlc.bench.groups import Group, Table, disagreements, groups_of, tables_of
from stlc.bench.html import Cell, number, table
from stlc.bench.measures import Summary, bound_mark, own_labels, summaries, time_ratio
from stlc.bench.plots import plots
from stlc.bench.record import Record

_GOOD, _FAIR = ("optimal", "infeasible"), ("feasible", "no_plan", "out_of_time", "out_of_memory")


def page(records: Sequence[Record], compared: tuple[str, Sequence[Change]] | None = None) -> str:
    """The whole page; `compared` is the name of older runs and what changed since."""
    groups = groups_of(records)
    tables = tables_of(groups)
    used = [run for group in groups for run in group.runs]
    body = [_header(used), _nav(tables, compared is not None), '<main class="wide">']
    if compared is not None:
        body.append(_changes(*compared))
    body += [_section(one) for one in tables]
    body.append("</main>")
    return _TEMPLATE.format(
        css=_resource("page.css"), js=_resource("page.js"), body="\n".join(body), notes=_NOTES
    )


def _resource(name: str) -> str:
    return files("stlc.bench").joinpath(name).read_text(encoding="utf-8")


_TEMPLATE = """<!doctype html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">
<title>stlc benchmarks</title>
<style>
{css}</style>
</head>
<body>
{body}
<footer class="wide">{notes}</footer>
<script>
{js}</script>
</body>
</html>
"""

_NOTES = (
    "Times are those of the solver and the search around it, without reading and compiling, which "
    "have their own column: processor seconds of runs with one thread, wall seconds of others. A "
    "run without proof counts with its time limit, so its ratio is a bound (≥, or ≤ where the "
    "reference has no proof; ~ where a mean has both). First plan and proof are wall seconds since "
    "the mission was first read. Means are shifted geometric means (shift 1 s); ratios are to the "
    "first configuration, times below 0.01 s counting as 0.01 s. Every plan was certified "
    "against the model and verified against the mission by an independent evaluator; peers' models "
    "have no mission and are certified only."
)


def _header(runs: Sequence[Record]) -> str:
    lines = [f"<p>{escape(line)}</p>" for line in about(runs)]
    lines += [f"<p><code>{escape(command)}</code></p>" for command in commands(runs)[:8]]
    return "\n".join(
        ['<header><div class="wide">', "<h1>stlc benchmarks</h1>", *lines, "</div></header>"]
    )


def _nav(tables: Sequence[Table], compared: bool) -> str:
    names = [("changes", "Changes")] if compared else []
    names += [(t.suite, t.suite) for t in tables]
    links = "".join(f'<a href="#{escape(k)}">{escape(v)}</a>' for k, v in names)
    return f'<nav><div class="wide">{links}</div></nav>'


def _changes(name: str, changes: Sequence[Change]) -> str:
    """The card of what changed since the base `name`; alarming if anything got worse."""
    bad = [c for c in changes if c.kind in ("disagreement", "regression")]
    mood = "alarm" if bad else "calm"
    count = f"{len(bad)} regression{'s' * (len(bad) > 1)}" if bad else "No regression"
    rows = [
        [Cell(c.kind, css="bad" if c in bad else ""), Cell(c.suite), Cell(c.problem),
         Cell(c.label), Cell(c.text), number(c.ratio, ".2f")]
        for c in changes
    ]  # fmt: skip
    heads = ("change", "suite", "problem", "configuration", "what", "ratio")
    body = table(heads, rows, text=5) if rows else ""
    return (
        f'<section id="changes"><h2>Changes against {escape(name)}</h2>'
        f'<div class="card {mood} scroll"><h3>{count} beyond the noise of the runs</h3>{body}</div>'
        "</section>"
    )


def _section(one: Table) -> str:
    """All of one suite: summary, families, agreement of optima, plots and every problem."""
    parts = [f'<section id="{escape(one.suite)}"><h2>Suite {escape(one.suite)}</h2>']
    parts.append(f'<div class="card scroll">{_summary_table(summaries(one))}</div>')
    families = families_of(one)
    if families:
        parts.append(f'<div class="card scroll">{_family_table(families)}</div>')
    parts.append(_agreement(one))
    cards = [f'<div class="card"><h3>{escape(title)}</h3>{svg}</div>' for title, svg in plots(one)]
    parts.append(f'<div class="grid">{"".join(cards)}</div>')
    parts.append(f'<div class="card scroll">{_problem_table(one)}</div></section>')
    return "\n".join(parts)


def _agreement(one: Table) -> str:
    """Whether proven optima agree; nothing where no problem was solved in two ways."""
    wrong = disagreements(one)
    if wrong:
        lines = "".join(f"<li>{escape(line)}</li>" for line in wrong)
        return f'<div class="card alarm"><h3>Proven optima disagree</h3><ul>{lines}</ul></div>'
    several = sum(
        sum(group.status == "optimal" for group in row.values()) > 1 for row in one.rows.values()
    )
    count = "1 problem was" if several == 1 else f"{several} problems were"
    text = f"All proven optima agree ({count} solved in several ways)."
    return f'<div class="card calm"><h3>{text}</h3></div>' if several else ""


def _summary_table(lines: Sequence[Summary]) -> str:
    """One row a configuration; ratios are to the reference, the first label."""
    heads = (
        "configuration", "problems", "solved to proof", "with a certified plan",
        "mean time [s]", "mean / reference", "geometric mean of ratios", "least ratio",
        "greatest ratio",
    )  # fmt: skip
    rows = [
        [Cell(s.label), number(s.problems, "d"), number(s.solved, "d"), number(s.plans, "d"),
         number(s.mean, ".3f"), number(s.ratio, ".2f"), number(s.geometric, ".2f", s.mark),
         number(s.least, ".2f"), number(s.greatest, ".2f", s.greatest_mark)]
        for s in lines
    ]  # fmt: skip
    return table(heads, rows, text=1)


def _family_table(families: Sequence[Family]) -> str:
    """One row a family and configuration: median / worst, with the limit where it was hit."""
    heads = (
        "median / worst of each family", "configuration", "problems", "with a plan", "proven",
        "first plan [s]", gap_title(f.limit for f in families), "proof [s]",
        "time of the solver [s]",
    )  # fmt: skip
    rows = [
        [Cell(f.name), Cell(f.label), number(f.problems, "d"), number(f.plans, "d"),
         number(f.proofs, "d"), _spread(f.first, f.limit), _spread(f.gap, None),
         _spread(f.proof, f.limit), _spread(f.cpu, f.limit)]
        for f in families
    ]  # fmt: skip
    return table(heads, rows, text=2)


def _spread(spread: Spread, limit: float | None) -> Cell:
    return Cell(spread_text(spread, limit), repr(min(spread.median, sys.float_info.max)))


_HEADS = (
    "problem", "configuration", "status", "objective", "gap", "gap at 60 s", "LP bound",
    "time [s]", "range [s]", "ratio", "wall [s]", "first plan [s]", "proof [s]", "compile [s]",
    "nodes", "columns", "binaries", "rows",
    "nonzeros", "memory [MB]", "note",
)  # fmt: skip
_MARK = 60.0  # s


def _problem_table(one: Table) -> str:
    rows, firsts = [], []
    for row in one.rows.values():
        reference = row.get(one.labels[0])
        for k, label in enumerate(label for label in own_labels(one) if label in row):
            firsts.append(k == 0)
            rows.append(_row(label, row[label], reference))
    return table(_HEADS, rows, text=3, firsts=firsts)


def _row(label: str, group: Group, reference: Group | None) -> list[Cell]:
    """Cells of one group, in the order of the heads; the note is that of a run that failed."""
    value = group.value
    memory = value("peak_memory")
    later = value("gap_60") if group.first.time_limit > _MARK else None  # else it is the last gap
    note = next((run.message for run in group.runs if run.message and not run.certified), "")
    return [
        Cell(group.first.problem), Cell(label), Cell(_status(group), css=_css(group)),
        number(value("objective"), ".6g"), number(value("gap"), ".2%"),
        number(later, ".2%"), number(value("lp_bound"), ".5g"),
        number(group.seconds, ".2f"), _range(group),
        _ratio(group, reference),
        *(number(value(k), ".2f")
          for k in ("solver_seconds", "first_plan", "proof", "compile_seconds")),
        *(number(value(k), ".0f") for k in ("nodes", "columns", "binaries", "rows", "nonzeros")),
        number(None if memory is None else memory / 2**20, ".0f"), Cell(note[:60]),
    ]  # fmt: skip


def _ratio(group: Group, reference: Group | None) -> Cell:
    """Nothing for the reference itself, and where two time limits would be compared."""
    if reference is None or reference is group or not (group.solved or reference.solved):
        return Cell("")
    return number(time_ratio(group, reference), ".2f", bound_mark([(group, reference)]))


def _range(group: Group) -> Cell:
    low, high = group.spread
    return Cell(f"{low:.2f} to {high:.2f}" if len(group.runs) > 1 else "", repr(high - low))


def _status(group: Group) -> str:
    return group.status.replace("_", " ")


def _css(group: Group) -> str:
    if group.status in _GOOD:
        return "status good"
    return "status fair" if group.status in _FAIR else "status bad"
