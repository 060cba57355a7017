"""`stlc replan`."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from stlc.cli.amount import Amount
from stlc.cli.answer import answer
from stlc.cli.common import check_outputs, mission_options
from stlc.cli.completion import backend_option
from stlc.cli.planned import load_planned
from stlc.cli.progress import listener
from stlc.errors import ViolationError

if TYPE_CHECKING:
    from stlc.renew.replanning import Renewed


@click.command("replan")
@mission_options
@click.argument("plan", type=click.Path(path_type=Path))
@click.option("--at", "step", type=click.IntRange(min=0), required=True, metavar="STEP",
              help="The step that has been reached.")  # fmt: skip
@click.option("--state", type=click.Path(path_type=Path),
              help="States measured there (JSON); else those of the plan.")  # fmt: skip
@click.option("--samples", multiple=True, metavar="[CHANNEL=]CSV",
              help="Signal strengths measured on the way.")  # fmt: skip
@click.option("--refit", is_flag=True,
              help="Fit channels anew where enough samples came and they say so.")  # fmt: skip
@click.option("--time-limit", type=Amount(min=0), default=10.0, show_default=True,
              metavar="S", help="Seconds for the solver.")  # fmt: skip
@click.option("--gap", type=Amount(min=0), default=1e-4, show_default=True,
              help="Relative distance from the optimum that is good enough.")  # fmt: skip
@backend_option
@click.option("-o", "--output", type=click.Path(path_type=Path), help="The new plan (JSON).")
@click.option("--json", "as_json", is_flag=True, help="Print one JSON object.")
@click.option("--progress", "style", default="none", show_default=True,
              type=click.Choice(["auto", "line", "text", "ndjson", "none"]),
              help="`auto`: a live line at a terminal, else lines of text.")  # fmt: skip
def replan_command(
    file: Path, plan: Path, define: tuple[str, ...], allow_path: tuple[Path, ...], step: int,
    state: Path | None, samples: tuple[str, ...], refit: bool, time_limit: float, gap: float,
    backend: str, output: Path | None, as_json: bool, style: str,
) -> int:  # fmt: skip
    """Plan what is left of FILE anew, after PLAN was followed up to a step.

    What was done counts, what is still owed is planned from the measured states; the new plan is
    of the whole mission again. Exit 6 when it cannot keep all that the mission asks for: it says
    what is lost, what is exceeded and by how much.
    """
    from stlc.renew.measured import read_past
    from stlc.renew.past import along
    from stlc.renew.reestimate import channel_of, read_heard
    from stlc.renew.replanning import replan
    from stlc.solve.outcome import SolveSettings

    mission, old = load_planned(file, plan, define, allow_path)
    check_outputs(output)
    _check_plan(mission, old)
    past = along(mission, old, step, {}) if state is None else read_past(state, mission, old, step)
    heard = {name: read_heard(path) for name, path in (channel_of(mission, s) for s in samples)}
    settings = SolveSettings(backend, time_limit=time_limit, gap=gap, save_to=output, grace=0.4)
    renewed = replan(
        mission, past, settings, old=old, heard=heard, refit=refit, listen=listener(style)
    )
    answer(_as_dict(renewed)) if as_json else click.echo(renewed.text())
    return 0 if renewed.kept else ViolationError.exit_status


def _check_plan(mission: Any, old: Any) -> None:
    from stlc.plan import as_planned
    from stlc.verify.subject import check_shape

    check_shape(as_planned(mission, old), old)


def _as_dict(renewed: Renewed) -> dict[str, Any]:
    """What `--json` prints."""
    return {
        "step": renewed.plan.executed,
        "left": renewed.outcome.as_dict(),
        "done": list(renewed.done),
        "lost": [{"name": x.name, "robustness": x.robustness} for x in renewed.lost],
        "softened": [
            {"what": s.text, "now": s.now, "most": s.most, "until": s.until, "unit": s.unit}
            for s in renewed.softened
        ],
        "given_up": list(renewed.given_up),
        "report": renewed.report.as_dict(),
    }
