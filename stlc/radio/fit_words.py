"""What a fit says of itself: how it was made, and what to doubt about it."""

from __future__ import annotations

from stlc.radio.climb import POLISH_ROWS
from stlc.radio.gp import ChannelModel
from stlc.radio.problem import Problem
from stlc.radio.samples import Samples


def method_of(problem: Problem, model: ChannelModel) -> str:
    """In words: which likelihood was maximised, and how the samples condition the model."""
    count, rows = len(problem.blocks), len(problem.features)
    likelihood = (
        f"exact likelihood of {rows} links"
        if count == 1
        else f"likelihood of {rows} links in {count} independent blocks"
    )
    if rows > POLISH_ROWS:
        likelihood += f" (variances and length from about {POLISH_ROWS} of them)"
    if model.posterior is None or model.posterior.exact:
        return f"{likelihood}, exact conditioning"
    return f"{likelihood}, conditioning through {len(model.posterior.centres)} inducing links"


def notes_of(
    problem: Problem, model: ChannelModel, samples: Samples, copied: bool
) -> tuple[str, ...]:
    """What the user should doubt about the fit, one sentence each."""
    notes = []
    if copied:
        notes.append("all samples of one link are equal: taken for copies, counted once")
    if len(problem.blocks) > 1:
        notes.append("standard errors take neighbouring blocks as independent: rather too small")
    if model.exponent < 0:
        notes.append(f"the path-loss exponent is negative ({model.exponent:.2f}): check the data")
    if model.shadowing < 1e-3 * model.fading:
        notes.append("no shadowing found: the samples look like path loss and fading alone")
    if samples.censored.any():
        share = 100.0 * float(samples.censored.mean())
        notes.append(f"{share:.0f} % of the samples are at or below the noise floor (censored)")
    return tuple(notes)
