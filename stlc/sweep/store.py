"""Answers that are known already: one SQLite file, one row a solve, written when it is finished."""

from __future__ import annotations

import sqlite3
from contextlib import AbstractContextManager
from dataclasses import dataclass
from pathlib import Path

from stlc.database import create, opened
from stlc.errors import OutputError, UsageError
from stlc.sweep.ask import Answer, Question

_SCHEMA = """
CREATE TABLE IF NOT EXISTS answers (key TEXT PRIMARY KEY, answer TEXT NOT NULL) WITHOUT ROWID
"""
_WHAT = "store of sweeps"


@dataclass(frozen=True, slots=True)
class Store:
    """An answer is in it whole or not at all; None keeps nothing."""

    path: Path | None

    def create(self) -> None:
        """Make the file and its table. OutputError when it can't be written."""
        if self.path is None:
            return
        create(self.path, _SCHEMA, _WHAT)

    def get(self, question: Question) -> Answer | None:
        """The answer, if it is known. UsageError when the file is damaged."""
        if self.path is None:
            return None
        try:
            with self._open() as base:
                found = base.execute(
                    "SELECT answer FROM answers WHERE key = ?", (question.key,)
                ).fetchone()
            return None if found is None else Answer.from_json(found[0])
        except (sqlite3.OperationalError, ValueError, TypeError, KeyError) as error:
            raise UsageError(f"{self.path} is damaged, or no {_WHAT}: {error}") from error

    def add(self, question: Question, answer: Answer) -> None:
        """Keep an answer, unless it was cut short."""
        if self.path is None or answer.status == "interrupted":
            return
        try:
            with self._open() as base:
                row = (question.key, answer.to_json())
                base.execute("INSERT OR REPLACE INTO answers VALUES (?, ?)", row)
        except sqlite3.OperationalError as error:
            raise OutputError(f"cannot write the store {self.path}: {error}") from error

    def _open(self) -> AbstractContextManager[sqlite3.Connection]:
        assert self.path is not None
        return opened(self.path, _WHAT)
