"""Which runs are left to make: none that is in the store, and no repeat that would tell nothing."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import replace

from stlc.bench.job import Job
from stlc.bench.record import Record


def rounds(jobs: Sequence[Job]) -> list[list[Job]]:
    """The runs of each repeat, in their order."""
    return [[j for j in jobs if j.repeat == k] for k in sorted({j.repeat for j in jobs})]


def pending(jobs: Iterable[Job], made: Iterable[Record]) -> list[Job]:
    """Runs of `jobs` that are still to be made, once all of the first repeat are in `made`.

    What was not solved in its first repeat is not repeated: it would count with its time limit
    again.
    """
    found = {record.key: record for record in made}
    return [job for job in jobs if job.key not in found and _tells(job, found)]


def _tells(job: Job, found: dict[str, Record]) -> bool:
    first = found.get(replace(job, repeat=0).key) if job.repeat else None
    return first is None or first.solved
