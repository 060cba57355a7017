"""`stlc fit`: a channel from measured samples."""

from __future__ import annotations

import json
from pathlib import Path

import click

from stlc.errors import StlcError


@click.command("fit")
@click.argument("samples", type=click.Path(path_type=Path))
@click.option("--test", type=click.Path(path_type=Path), help="Held-back samples (CSV).")
@click.option("--share", type=click.FloatRange(0, 1, min_open=True, max_open=True), default=0.2,
              show_default=True, help="Share held back where there is no --test.")  # fmt: skip
@click.option("--d0", type=click.FloatRange(min=0, min_open=True), default=1.0, show_default=True,
              help="Reference distance [m].")  # fmt: skip
@click.option("--offsets", is_flag=True, help="One unknown offset for each receiver.")
@click.option("--floor", type=float, help="Noise floor [dB(m)]: samples at it are censored.")
@click.option("--seed", type=int, default=0, show_default=True)
@click.option("-o", "--output", type=click.Path(path_type=Path), help="Report as a picture (PNG).")
@click.option("--json", "as_json", is_flag=True, help="Print one JSON object.")
def fit_command(
    samples: Path,
    test: Path | None,
    share: float,
    d0: float,
    offsets: bool,
    floor: float | None,
    seed: int,
    output: Path | None,
    as_json: bool,
) -> int:
    """Fit a channel to SAMPLES (CSV of tx_x, tx_y, rx_x, rx_y, rssi_dbm) by maximum likelihood.

    Prints path loss, fading, shadowing and length with standard errors, and how well the fit
    forecasts samples that were held back, against path loss alone.
    """
    from stlc.radio.errors import RadioError
    from stlc.radio.fit import FitOptions
    from stlc.radio.report import fit_csv, format_summary, plot_summary
    from stlc.radio.read import SampleOptions, read_samples

    options = FitOptions(d0=d0, receiver_offsets=offsets, seed=seed)
    reading = SampleOptions(floor=floor)
    try:
        held_back = None if test is None else read_samples(test, reading)
        summary = fit_csv(samples, options, reading, held_back, share)
    except RadioError as error:
        raise StlcError(str(error)) from error
    if output is not None:
        plot_summary(summary, output)
    click.echo(json.dumps(summary.as_dict(), indent=2) if as_json else format_summary(summary))
    return 0
