"""A worker process under a watchdog."""

from __future__ import annotations

import multiprocessing as mp
import os
import time
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from fuzz.worker import Ran, serve

PATIENCE = 400  # inputs that one process sees before it is replaced
KILLED = -9
_TICK = os.sysconf("SC_CLK_TCK")


@dataclass(slots=True)
class Worker:
    """Starts the process when it is needed, kills it when it takes too long."""

    _process: Any = None
    _pipe: Any = None
    _seen: int = 0
    _context: Any = field(default_factory=lambda: mp.get_context("spawn"))

    def run(self, folder: Path, words: tuple[str, ...], cpu_limit: float) -> Ran:
        """One command; status KILLED when its CPU (or ten times as long by the clock) ran out."""
        self._ready()
        began, first = time.monotonic(), self._cpu()
        self._pipe.send((str(folder), words))
        while not self._pipe.poll(0.2):
            spent = self._cpu() - first
            dead = not self._process.is_alive()
            if dead or spent > cpu_limit or time.monotonic() - began > 10 * cpu_limit:
                self.stop()
                why = "the process died" if dead else "killed by the watchdog"
                return Ran(words[0], KILLED, "", why, spent, 0, why, words)
        return self._answer(words)

    def _answer(self, words: tuple[str, ...]) -> Ran:
        try:
            ran, stale = self._pipe.recv()
        except EOFError:
            self.stop()
            return Ran(words[0], KILLED, "", "the process died", 0.0, 0, "died", words)
        if stale:
            self.stop()
        assert isinstance(ran, Ran)
        return ran

    def _ready(self) -> None:
        self._seen += 1
        if self._process is not None and self._seen % (3 * PATIENCE) == 0:
            self.stop()
        if self._process is None:
            self._pipe, theirs = self._context.Pipe()
            self._process = self._context.Process(target=serve, args=(theirs,), daemon=True)
            self._process.start()
            theirs.close()

    def _cpu(self) -> float:
        """CPU seconds of the process so far."""
        try:
            with open(f"/proc/{self._process.pid}/stat") as file:
                fields = file.read().rsplit(")", 1)[1].split()
        except OSError:
            return 0.0
        return (int(fields[11]) + int(fields[12])) / _TICK

    def stop(self) -> None:
        """End the process."""
        if self._process is not None:
            self._process.kill()
            self._process.join()
            self._pipe.close()
        self._process = self._pipe = None
