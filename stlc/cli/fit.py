"""`stlc fit`: a channel from measured samples."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

import click

from stlc.cli.amount import Amount
from stlc.cli.answer import answer
from stlc.errors import UsageError
from stlc.files import check_writable
from stlc.inputs import check_input

if TYPE_CHECKING:
    from stlc.radio.walls import Walls


@click.command("fit")
@click.argument("samples", type=click.Path(path_type=Path))
@click.option("--test", type=click.Path(path_type=Path), help="Held-back samples (CSV).")
@click.option("--share", type=Amount(0, 1, min_open=True, max_open=True), default=0.2,
              show_default=True, help="Share held back where there is no --test.")  # fmt: skip
@click.option("--d0", type=Amount(min=0, min_open=True), default=1.0, show_default=True,
              help="Reference distance [m].")  # fmt: skip
@click.option("--offsets", is_flag=True, help="One unknown offset for each receiver.")
@click.option("--floor", type=float, help="Noise floor [dB(m)]: samples at it are censored.")
@click.option("--not-heard", multiple=True, metavar="MARK",
              help="Cell that stands for a packet below the floor; repeatable.")  # fmt: skip
@click.option(
    "--height",
    type=float,
    default=0.0,
    show_default=True,
    help="Height [m] of an end that has no z column while the other has one.",
)
@click.option("--where", metavar="COLUMN=TEXT", help="Use only rows whose column has this text.")
@click.option(
    "--seed",
    type=click.IntRange(min=0),
    default=0,
    show_default=True,
    help="Draws the samples held back.",
)
@click.option("--walls", type=click.Path(path_type=Path),
              help="A file with `wall` statements: their losses are estimated.")  # fmt: skip
@click.option("-o", "--output", type=click.Path(path_type=Path), help="Report as a picture (PNG).")
@click.option("--json", "as_json", is_flag=True, help="Print one JSON object.")
def fit_command(
    samples: Path,
    test: Path | None,
    share: float,
    d0: float,
    offsets: bool,
    floor: float | None,
    not_heard: tuple[str, ...],
    height: float,
    where: str | None,
    seed: int,
    walls: Path | None,
    output: Path | None,
    as_json: bool,
) -> int:
    """Fit a channel to SAMPLES (CSV of tx_x, tx_y, rx_x, rx_y, rssi_dbm) by maximum likelihood.

    Prints path loss, fading, shadowing and length with standard errors, and how well the fit
    forecasts samples that were held back, against path loss alone. The CSV may be gzipped; with
    tx_z, rx_z it has heights, with a column `receiver` named receivers (see --offsets).
    """
    from stlc.radio.figures import plot_summary
    from stlc.radio.fit import FitOptions
    from stlc.radio.read import SampleOptions, read_samples
    from stlc.radio.report import fit_csv, format_summary

    drawn = None if walls is None else _walls(walls)
    options = FitOptions(d0=d0, receiver_offsets=offsets, seed=seed, walls=drawn)
    reading = SampleOptions(height, floor, None if where is None else _column(where), not_heard)
    for path in (samples, test):
        if path is not None:
            check_input(path)
    if output is not None:
        check_writable(output)
    held_back = None if test is None else read_samples(test, replace(reading, where=None))
    summary = fit_csv(samples, options, reading, held_back, share)
    if output is not None:
        plot_summary(summary, output)
    answer(summary.as_dict()) if as_json else click.echo(format_summary(summary))
    return 0


def _walls(path: Path) -> Walls:
    """The walls of a mission file, or of one that holds nothing else."""
    from stlc.api import load
    from stlc.sema.walls import as_radio

    mission = load(path)
    drawn = as_radio(mission.walls.values())
    if drawn is None:
        raise UsageError(f"{path} has no walls: `wall brick = line (0, 0) (3, 0)`")
    return drawn


def _column(text: str) -> tuple[str, str]:
    name, sign, value = text.partition("=")
    if not sign or not name.strip():
        raise click.UsageError(f"--where takes COLUMN=TEXT, not {text!r}")
    return name.strip(), value.strip()
