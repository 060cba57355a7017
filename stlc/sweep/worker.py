"""One task in a process of its own: `python -m stlc.sweep.worker`, a pickled task on its input."""

from __future__ import annotations

import sys

from stlc.solve.racing.child import end_with_input, private_output
from stlc.solve.racing.messages import read_message, write_message
from stlc.sweep.work import Task, run


def main() -> None:
    """Make one task."""
    output = private_output()
    task = read_message(sys.stdin.buffer)
    if isinstance(task, Task):
        end_with_input()
        write_message(output, run(task))


if __name__ == "__main__":
    main()
