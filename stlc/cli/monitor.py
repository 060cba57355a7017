"""`stlc import` and `stlc monitor`."""

from __future__ import annotations

import sys
from fractions import Fraction
from pathlib import Path
from typing import TYPE_CHECKING

import click

from stlc.cli.answer import answer
from stlc.cli.common import load, mission_options, plain, show_diagnostics
from stlc.errors import StlcError, UsageError
from stlc.inputs import MOST_BYTES, check_input

if TYPE_CHECKING:
    from stlc.mission import Mission
    from stlc.monitor import Monitored, MonitorReport

VIOLATED = 6
UNJUDGED = 1

_UNITS = {
    "": Fraction(1),
    "s": Fraction(1),
    "ms": Fraction(1, 10**3),
    "us": Fraction(1, 10**6),
    "min": Fraction(60),
}


def _seconds(
    context: click.Context, parameter: click.Parameter, value: str | None
) -> Fraction | None:
    """A duration such as `0.1`, `0.1 s` or `100 ms`, as an exact number of seconds."""
    if value is None:
        return None
    number = value.strip().rstrip("abcdefghijklmnopqrstuvwxyz").strip()
    try:
        seconds = Fraction(number) * _UNITS[value.strip()[len(number) :].strip()]
    except (ValueError, KeyError, ZeroDivisionError):
        raise click.BadParameter(f"{value!r} is no time such as 0.1, 0.1s or 100ms") from None
    if not Fraction(1, 10**12) <= seconds <= 10**9:
        raise click.BadParameter(f"{value!r} is no step: it must be positive and not huge")
    return seconds


@click.command("import")
@click.argument("file", type=click.Path(path_type=Path, allow_dash=True))
@click.option(
    "--dialect", type=click.Choice(["breach", "rtamt", "falcaun"]), required=True,
    help="The tool whose language FILE is in.",
)  # fmt: skip
@click.option(
    "--step", metavar="TIME", callback=_seconds,
    help="Sampling step, as 0.1s or 100ms; else found from the times in FILE.",
)  # fmt: skip
@click.option("-o", "--output", type=click.Path(path_type=Path), help="Write here, not to stdout.")
def import_command(file: Path, dialect: str, step: Fraction | None, output: Path | None) -> int:
    """Translate FILE (`-`: standard input) from another tool's language; see docs/import.md.

    Formulas become requirements, those used by others `let`; free names become signals or
    parameters. What has no counterpart is refused with its place and reason.
    """
    from stlc.dialects import import_text
    from stlc.files import write_atomic
    from stlc.syntax.read import decode, read_source

    source = (
        decode("<stdin>", sys.stdin.buffer.read(MOST_BYTES))
        if str(file) == "-"
        else read_source(file)
    )
    imported = import_text(source, dialect, step)
    if imported.warnings:
        show_diagnostics(imported.warnings)
    if output is None:
        click.echo(imported.text, nl=False)
    else:
        write_atomic(output, imported.text)
    return 0


@click.command("monitor")
@mission_options
@click.argument("trace", type=click.Path(path_type=Path))
@click.option("--at", type=float, metavar="TIME", help="Judge at this time, not the first sample.")
@click.option("--by-subformula", is_flag=True, help="Also every part of every formula.")
@click.option("--json", "as_json", is_flag=True, help="Robustness over time, as one JSON object.")
@click.option("-o", "--output", type=click.Path(path_type=Path), help="Robustness over time (CSV).")
def monitor_command(
    file: Path,
    define: tuple[str, ...],
    allow_path: tuple[Path, ...],
    trace: Path,
    at: float | None,
    by_subformula: bool,
    as_json: bool,
    output: Path | None,
) -> int:
    """Judge the requirements of FILE on the signals recorded in TRACE (CSV).

    TRACE has a header, a column `time` in seconds (or `t`, counting steps) and one column for each
    signal; agents' signals are `agent.name`. Exit status 0 if all hold, 6 if one is violated, 1
    for a bad file or a recording too short.
    """
    from stlc.files import write_atomic

    mission = load(file, define, allow_path)
    if not mission.requirements:
        raise StlcError(f"{file}: there is no requirement to judge")
    report = _report(mission, trace)
    row = _row(report, at)
    if output is not None:
        write_atomic(output, report.to_csv())
    if as_json:
        found = {"at": float(report.times[row]), **report.as_dict(parts=by_subformula)}
        found["satisfied"] = _status(report, row) == 0
        answer(found)
    else:
        click.echo(_table(report, row, by_subformula))
    return _status(report, row)


def _report(mission: Mission, trace: Path) -> MonitorReport:
    """The judgement; a recording that doesn't fit is a mistake of the file, not of the call."""
    from stlc.monitor import monitor

    check_input(trace)
    try:
        return monitor(mission, trace)
    except UsageError as error:
        raise StlcError(str(error)) from error


def _row(report: MonitorReport, at: float | None) -> int:
    """Index of the sample to judge at."""
    if at is None:
        return 0
    from stlc.recording import JITTER

    times = report.times
    step = float(times[1] - times[0]) if len(times) > 1 else 1.0
    nearest = round((at - float(times[0])) / step) if at == at else -1
    if 0 <= nearest < len(times) and abs(float(times[nearest]) - at) <= JITTER * step:
        return nearest
    raise UsageError(
        f"--at {at:g}: no sample was recorded then; samples are at "
        f"{times[0]:g}, {times[0] + step:g}, .. {times[-1]:g} s"
    )


def _status(report: MonitorReport, row: int) -> int:
    judged = [f for f in report.formulas if row < len(f.robustness)]
    if not all(f.satisfied[row] for f in judged):
        return VIOLATED
    return 0 if len(judged) == len(report.formulas) else UNJUDGED


def _table(report: MonitorReport, row: int, by_subformula: bool) -> str:
    """A line for each formula, at sample `row`, and for its sub-formulas with their places."""
    width = max((len(f.name) for f in report.formulas), default=0)
    lines: list[str] = []
    for formula in report.formulas:
        lines.append(_line(formula, width, report, row))
        for part in formula.parts if by_subformula else ():
            known = row < len(part.robustness)
            value = plain(float(part.robustness[row])) if known else "-"
            place = f"{part.span.line}:{part.span.column}" if part.span else ""
            lines.append(f"    {value:>12}  {place:>7}  {'  ' * (part.depth - 1)}{part.text}")
    return "\n".join(lines)


def _line(formula: Monitored, width: int, report: MonitorReport, row: int) -> str:
    """Verdict and robustness at sample `row`, and the first time [s] at which it fails."""
    name = f"{formula.name:<{width}}"
    if row >= len(formula.robustness):
        missing = row + 1 - len(formula.robustness)
        if not len(formula.robustness):
            return f"--  {name}  can't be judged: the recording is too short for it"
        return f"--  {name}  can't be judged here: its window ends {missing} samples too late"
    holds = formula.satisfied
    lost = [k for k in range(len(holds)) if not holds[k]]
    tail = f", not at {report.times[lost[0]]:g} s" if lost else ""
    value = plain(float(formula.robustness[row]))
    return (
        f"{'ok ' if holds[row] else 'NO '} {name}  robustness {value}"
        f"; holds at {int(holds.sum())} of {len(holds)} samples{tail}"
    )
