"""The store of finished runs: one SQLite file, one row a run, written the moment it is finished."""

from __future__ import annotations

import sqlite3
from collections.abc import Collection
from contextlib import AbstractContextManager
from dataclasses import dataclass
from pathlib import Path

from stlc.bench.record import Record, from_json
from stlc.database import create, opened
from stlc.errors import OutputError, UsageError

_SCHEMA = """
CREATE TABLE IF NOT EXISTS runs (
  key TEXT PRIMARY KEY,
  suite TEXT NOT NULL,
  problem TEXT NOT NULL,
  label TEXT NOT NULL,
  repeat INTEGER NOT NULL,
  finished TEXT NOT NULL,
  record TEXT NOT NULL
) WITHOUT ROWID
"""
_WHAT = "store of benchmark runs"


@dataclass(frozen=True, slots=True)
class Store:
    """A run is in it whole or not at all, and never twice (`key` is Job.key)."""

    path: Path

    def create(self) -> None:
        """Make the file and its table. OutputError when it can't be written."""
        create(self.path, _SCHEMA, _WHAT)

    def add(self, record: Record) -> None:
        """Keep a finished run; one that is there already stays as it is."""
        row = (
            record.key, record.suite, record.problem, record.label, record.repeat,
            record.finished, record.to_json(),
        )  # fmt: skip
        try:
            with self._open() as base:
                base.execute("INSERT OR IGNORE INTO runs VALUES (?, ?, ?, ?, ?, ?, ?)", row)
        except sqlite3.OperationalError as error:
            raise OutputError(f"cannot write the store {self.path}: {error}") from error

    def keys(self) -> frozenset[str]:
        """Of all finished runs."""
        with self._open() as base:
            return frozenset(key for (key,) in base.execute("SELECT key FROM runs"))

    def records(self, suites: Collection[str] = ()) -> tuple[Record, ...]:
        """All runs (of `suites`, if any are named) in the order they were finished.

        UsageError when there is no such file.
        """
        if not self.path.is_file():
            raise UsageError(f"there is no store {self.path}; `stlc bench` makes one")
        try:
            with self._open() as base:
                order = "SELECT suite, record FROM runs ORDER BY finished, key"
                rows = base.execute(order).fetchall()
            return tuple(from_json(text) for suite, text in rows if not suites or suite in suites)
        except (sqlite3.OperationalError, ValueError, TypeError, AttributeError) as error:
            problem = f"{self.path} is damaged, or no {_WHAT}: {error}"
            raise UsageError(problem) from error

    def _open(self) -> AbstractContextManager[sqlite3.Connection]:
        return opened(self.path, _WHAT)
