"""One run in a process of its own: `python -m stlc.bench.worker`.

Reads a pickled `Job` from standard input; writes `Update`s (figures as they become known),
`Point`s (where the solver stands) and one `Done`. Every figure is sent the moment it is known, so
that a run that is killed keeps what it had.
"""

from __future__ import annotations

import sys
from collections.abc import Mapping

from stlc.bench.job import Done, Figure, Job, Tell, Update
from stlc.solve.racing.child import end_with_input, limit_memory, private_output
from stlc.solve.racing.messages import read_message, write_message


def main() -> None:
    """Make one run."""
    output = private_output()
    job = read_message(sys.stdin.buffer)
    if not isinstance(job, Job):
        return
    end_with_input()
    limit_memory(job.limits.memory)

    def tell(message: object) -> None:
        write_message(output, message)

    _introduce(tell)
    try:
        _make(job, tell)
    except MemoryError:
        tell(Update({"status": "out_of_memory", "message": "it ran out of memory"}))
    _finish(tell)


def _introduce(tell: Tell) -> None:
    from stlc.bench import machine

    who: Mapping[str, Figure] = {
        "code": machine.fingerprint(),
        "versions": machine.versions(),
        "processor": machine.processor(),
        "load": machine.load(),
    }
    tell(Update(who))


def _make(job: Job, tell: Tell) -> None:
    if ".mps" in job.main:
        from stlc.bench.peer import run_peer

        run_peer(job, tell)
    else:
        from stlc.bench.mission_run import run_mission

        run_mission(job, tell)


def _finish(tell: Tell) -> None:
    from stlc.bench.machine import peak_memory

    tell(Update({"peak_memory": peak_memory()}))
    tell(Done())


if __name__ == "__main__":
    main()
