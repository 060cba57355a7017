"""Runs a solver's command: its log, its time limit, its end."""

from __future__ import annotations

import signal
import subprocess
import time
from pathlib import Path

from stlc.backends.base import SolveOptions
from stlc.errors import SolverError

_GRACE = 30.0  # s that a solver may overrun its own time limit before it is terminated


def run(command: list[str], options: SolveOptions, folder: Path) -> str:
    """What the command printed. SolverError when it cannot be run or ends with a failure."""
    limit = None if options.time_limit is None else options.time_limit + _GRACE
    log, began = folder / "log.txt", time.monotonic()
    with log.open("wb") as stream:
        try:
            process = subprocess.Popen(
                command, stdout=stream, stderr=subprocess.STDOUT, stdin=subprocess.DEVNULL,
                cwd=folder,
            )  # fmt: skip
        except OSError as error:
            raise SolverError(f"cannot run {command[0]}: {error.strerror}") from error
        try:
            while process.poll() is None and not _expired(options, began, limit):
                time.sleep(0.02)
            ended_itself = process.returncode is not None
        finally:
            _end(process)
    text = log.read_text(errors="replace")
    if process.returncode > 0:
        raise SolverError(f"{command[0]} ended with status {process.returncode}: {last_line(text)}")
    if process.returncode < 0 and ended_itself:
        raise SolverError(f"{command[0]} was killed by {_signal(-process.returncode)}")
    return text


def _signal(number: int) -> str:
    known = number in {s.value for s in signal.Signals}
    return signal.Signals(number).name if known else f"signal {number}"


def _expired(options: SolveOptions, began: float, limit: float | None) -> bool:
    late = limit is not None and time.monotonic() - began > limit
    return late or (options.should_stop is not None and options.should_stop())


def _end(process: subprocess.Popen[bytes]) -> None:
    if process.poll() is not None:
        return
    process.terminate()
    try:
        process.wait(1.0)
    except subprocess.TimeoutExpired:
        process.kill()
        process.wait()


def last_line(text: str) -> str:
    """The last line that is not empty."""
    return next((line.strip() for line in reversed(text.splitlines()) if line.strip()), "")
