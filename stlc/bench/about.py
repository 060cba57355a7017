"""Where runs come from: date, load, machine, versions, sources, command."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from stlc.bench.record import Record


def about(runs: Sequence[Record]) -> list[str]:
    """Lines for a reader who wants to repeat them."""
    dates = [run.finished for run in runs]
    loads = [run.load for run in runs if run.load is not None]
    codes = _listed(run.code for run in runs)
    busy = f"; load average {min(loads):.1f} to {max(loads):.1f}" if loads else ""
    mixed = ": several versions, compare with care" if len(codes) > 1 else ""
    return [
        f"{len(runs)} runs, {min(dates)[:16]} to {max(dates)[:16]} UTC{busy}",
        *_listed(run.processor for run in runs),
        *_listed(run.versions for run in runs),
        *_listed(f"limits: {run.time_limit:g} s, gap {run.gap_limit:g}, {_threads(run)}"
                 for run in runs),
        f"sources {', '.join(codes)}{mixed}",
    ]  # fmt: skip


def commands(runs: Sequence[Record]) -> list[str]:
    """The commands that made the runs."""
    return _listed(run.command for run in runs)


def _threads(run: Record) -> str:
    memory = "" if run.memory_limit is None else f", {run.memory_limit / 2**30:g} GB"
    return f"{run.threads} thread{'' if run.threads == 1 else 's'}{memory}"


def _listed(values: Iterable[str]) -> list[str]:
    return sorted({value for value in values if value})
