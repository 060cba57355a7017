"""`stlc simulate`."""

from __future__ import annotations

from pathlib import Path

import click

from stlc.cli.amount import Amount
from stlc.cli.answer import answer
from stlc.cli.common import mission_options
from stlc.cli.planned import load_planned


@click.command("simulate")
@mission_options
@click.argument("plan", type=click.Path(path_type=Path))
@click.option("--draws", type=click.IntRange(1, 10_000_000), default=10_000, show_default=True,
              help="How often the plan is carried out.")  # fmt: skip
@click.option("--seed", type=click.IntRange(min=0), default=0, show_default=True,
              help="The same seed gives the same draws.")  # fmt: skip
@click.option("--confidence", type=Amount(0, 1, min_open=True, max_open=True),
              default=0.95, show_default=True, help="Of the intervals.")  # fmt: skip
@click.option("--no-fading", is_flag=True, help="Links as the mean of many packets has them.")
@click.option("--json", "as_json", is_flag=True, help="Print one JSON object.")
def simulate_command(
    file: Path,
    plan: Path,
    define: tuple[str, ...],
    allow_path: tuple[Path, ...],
    draws: int,
    seed: int,
    confidence: float,
    no_fading: bool,
    as_json: bool,
) -> int:
    """Carry out PLAN many times over: how probable is each requirement of FILE?

    Channels are drawn jointly over pairs and steps, packets fade, and agents are off their plan by
    the noise that FILE declares (`start_noise`, `control_noise`).
    """
    from stlc.simulate import simulate

    mission, run = load_planned(file, plan, define, allow_path)
    found = simulate(
        mission, run, draws=draws, seed=seed, confidence=confidence, fading=not no_fading
    )
    answer(found.as_dict()) if as_json else click.echo(found.text())
    return 0
