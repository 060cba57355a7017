"""The store and the CSV keep every figure, once."""

from __future__ import annotations

import sqlite3
from pathlib import Path

import pytest
from support.tiny import record

from stlc.bench.store import Store
from stlc.bench.table import read_csv, read_runs, to_csv
from stlc.errors import OutputError, UsageError


def test_a_run_is_kept_once(tmp_path: Path) -> None:
    store = Store(tmp_path / "runs.sqlite")
    store.create()
    run = record("p", "auto", 1.0, trace=((0.5, 1.0, 0.0, 3), (1.0, 1.0, 1.0, 4)))
    store.add(run)
    store.add(run)
    store.create()
    assert store.records() == (run,)
    assert store.keys() == {run.key}
    assert store.records(["other"]) == ()


def test_no_folder_is_made_for_a_store(tmp_path: Path) -> None:
    with pytest.raises(OutputError, match="there is no folder"):
        Store(tmp_path / "new" / "runs.sqlite").create()
    assert not (tmp_path / "new").exists()


def test_csv_round_trip(tmp_path: Path) -> None:
    runs = (record("p", "auto", 0.1 + 0.2), record("q", "a, b", None, message='say "no"\nmore'))
    path = tmp_path / "runs.csv"
    path.write_text(to_csv(runs))
    assert read_csv(path) == runs
    assert read_runs(path) == runs


def test_other_files_are_told_apart(tmp_path: Path) -> None:
    with pytest.raises(UsageError, match="no store or table"):
        read_runs(tmp_path / "nothing")
    odd = tmp_path / "odd.csv"
    for words in ("a,b\n1,2\n", "", "step 1 s\nhorizon 2\n"):
        odd.write_text(words)
        with pytest.raises(UsageError, match="no table of benchmark runs: its header lacks key, "):
            read_runs(odd)
    odd.write_text(to_csv((record("p", "auto", 1.0),)).replace("key,", "id,"))
    with pytest.raises(UsageError, match=r"lacks key$"):
        read_runs(odd)
    header, row = to_csv((record("p", "auto", 1.0),)).splitlines()
    odd.write_text(f"{header}\n{row.partition(',')[0]}\n")
    with pytest.raises(UsageError, match="line 2: repeat can't be ''"):
        read_runs(odd)
    text = tmp_path / "text"
    text.write_text("not a data base, but long enough to be taken for one" * 10)
    with pytest.raises(UsageError, match="no store of benchmark runs"):
        Store(text).create()
    with pytest.raises(OutputError, match="cannot write"):
        Store(odd / "runs.sqlite").create()


@pytest.mark.parametrize("text", ["{broken", "[1]", '{"key": 1}', "7"])
def test_a_damaged_store_is_told(text: str, tmp_path: Path) -> None:
    path = tmp_path / "runs.db"
    Store(path).create()
    with sqlite3.connect(path) as base:
        base.execute("INSERT INTO runs VALUES ('k', 's', 'p', 'l', 1, 'f', ?)", (text,))
    with pytest.raises(UsageError, match="damaged") as told:
        Store(path).records()
    assert "__init__" not in str(told.value)
    assert "attribute" not in str(told.value)


def test_a_base_of_another_kind(tmp_path: Path) -> None:
    path = tmp_path / "other.db"
    with sqlite3.connect(path) as base:
        base.execute("CREATE TABLE runs (x INTEGER)")
    with pytest.raises(UsageError, match="no store of benchmark runs"):
        Store(path).records()
