"""One racer in a process of its own: `python -m stlc.solve.racing.racer`.

Reads a pickled `Task` from standard input, writes framed, pickled messages to standard output:
any number of `Progress`, then a `Certified`, or a `Failure`. When standard input ends, the race
is over (or its process gone) and so is this process with all its children.
"""

from __future__ import annotations

import sys
from dataclasses import replace
from typing import IO

from stlc.backends.base import Solution, SolveOptions
from stlc.milp.model import Model
from stlc.solve.racing.child import end_with_input, limit_memory, private_output
from stlc.solve.racing.messages import Failure, Task, read_message, write_message


def main() -> None:
    """Solve one task."""
    output = private_output()
    task = read_message(sys.stdin.buffer)
    if not isinstance(task, Task):
        return
    end_with_input()
    limit_memory(task.memory)
    write_message(output, _answer(task, output))


def _answer(task: Task, output: IO[bytes]) -> object:
    """The certified answer of a task, or the failure that its user should read."""
    from stlc.errors import StlcError
    from stlc.solve.certify import certify

    def report(progress: object) -> None:
        """Write progress to the parent as it comes."""
        write_message(output, progress)

    options = replace(task.options, on_progress=report)
    try:
        return certify(task.model, _solve(task, options), options=options)
    except StlcError as error:
        return Failure(str(error))
    except MemoryError:
        return Failure("it ran out of memory")


def _solve(task: Task, options: SolveOptions) -> Solution:
    from stlc import backends
    from stlc.solve.strategies import run_strategy

    backend = backends.get(task.backend)
    if isinstance(task.work, Model):
        return backend.solve(task.work, options)
    return run_strategy(task.strategy, task.work, backend, options)


if __name__ == "__main__":
    main()
