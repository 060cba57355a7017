"""Runs a command as a user does: a child process for each, which shares nothing with the last."""

from __future__ import annotations

import os
import re
import resource
import subprocess
import sys
import tempfile
from dataclasses import dataclass
from pathlib import Path

from fuzz.pool import KILLED
from fuzz.worker import CRASH, MEMORY, Ran

_FRAME = re.compile(r'File ".*?([^/"]+/[^/"]+)", line \d+, in (\w+)')
_PROGRAM = "from stlc.cli import main; main()"


@dataclass(frozen=True, slots=True)
class Fresh:
    """Where `Worker` runs many commands in one process, one process for one command."""

    def run(self, folder: Path, words: tuple[str, ...], cpu_limit: float) -> Ran:
        """One command; status KILLED when it needed more than `cpu_limit` CPU seconds."""

        def limited() -> None:
            spent = int(cpu_limit) + 1
            resource.setrlimit(resource.RLIMIT_CPU, (spent, spent))
            resource.setrlimit(resource.RLIMIT_AS, (MEMORY, MEMORY))

        with tempfile.TemporaryDirectory() as kept:
            paths = [Path(kept) / name for name in ("stdout", "stderr")]
            with paths[0].open("wb") as out, paths[1].open("wb") as err:
                process = subprocess.Popen(
                    [sys.executable, "-c", _PROGRAM, *words],
                    cwd=folder, stdin=subprocess.DEVNULL, stdout=out, stderr=err,
                    preexec_fn=limited, env={**os.environ, "STLC_DEBUG": "1"},
                )  # fmt: skip
                _, status, usage = os.wait4(process.pid, 0)
                process.returncode = os.waitstatus_to_exitcode(status)
            texts = [path.read_bytes().decode("utf-8", "replace") for path in paths]
        spent = usage.ru_utime + usage.ru_stime
        return _ran(words, process.returncode, texts, spent, usage.ru_maxrss * 1024)


def _ran(words: tuple[str, ...], status: int, texts: list[str], spent: float, peak: int) -> Ran:
    if status < 0:
        why = f"ended by signal {-status}"
        return Ran(words[0], KILLED, *texts, spent, peak, why, words)
    where = place(texts[1]) if status == CRASH else ""
    return Ran(words[0], status, *texts, spent, peak, where, words)


def place(told: str) -> str:
    """`Type at stlc/file.py:function: message` of the last traceback in a text, or ''."""
    _, sign, trace = told.rpartition("Traceback (most recent call last):\n")
    frames = [found for found in _FRAME.findall(trace) if f"stlc/{found[0]}" in trace]
    error = re.search(r"^(\w[\w.]*)(?:: (.*))?$", trace, re.M)
    if not sign or not frames or error is None:
        return ""
    kind = error[1].rpartition(".")[2]
    return f"{kind} at {frames[-1][0]}:{frames[-1][1]}: {(error[2] or '')[:200]}"
