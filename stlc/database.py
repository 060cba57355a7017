"""SQLite files that keep what is finished: one connection an access, closed whatever happens."""

from __future__ import annotations

import sqlite3
from collections.abc import Iterator
from contextlib import closing, contextmanager
from pathlib import Path

from stlc.errors import OutputError, UsageError

_WAIT = 60.0  # s for another process that writes


@contextmanager
def opened(path: Path, what: str) -> Iterator[sqlite3.Connection]:
    """A connection that commits at the end; UsageError where the file is none of `what`."""
    try:
        with closing(sqlite3.connect(path, timeout=_WAIT)) as base, base:
            yield base
    except sqlite3.OperationalError:
        raise
    except sqlite3.DatabaseError as error:
        raise UsageError(f"{path} is no {what}: {error}") from error


def make_folder(path: Path) -> None:
    """Make the folder of a store that nobody named a place for. OutputError where it can't be."""
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise OutputError(f"cannot make the folder {path.parent}: {error.strerror}") from error


def create(path: Path, schema: str, what: str) -> None:
    """Make the file and its table, in a folder that is there. OutputError when it can't be
    written."""
    try:
        if not path.parent.is_dir():
            raise FileNotFoundError(f"there is no folder {path.parent}")
        with opened(path, what) as base:
            base.execute(schema)
    except (OSError, sqlite3.OperationalError) as error:
        raise OutputError(f"cannot write the store {path}: {error}") from error
