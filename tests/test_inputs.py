"""Whatever a file is, reading it ends within seconds, with its content or the reason why not."""

from __future__ import annotations

import os
import threading
from pathlib import Path

import pytest

from stlc import inputs
from stlc.inputs import InputError, TooLargeError, read_input


def test_files_and_what_is_none(tmp_path: Path) -> None:
    path = tmp_path / "a"
    path.write_bytes(b"abc")
    assert read_input(path) == b"abc"
    assert read_input(path, 3) == b"abc"
    with pytest.raises(TooLargeError):
        read_input(path, 2)
    with pytest.raises(InputError, match="there is no such file"):
        read_input(tmp_path / "gone")
    with pytest.raises(InputError, match="is a folder"):
        read_input(tmp_path)
    with pytest.raises(InputError, match="null"):
        read_input("a\0b")


def test_files_without_end(tmp_path: Path) -> None:
    sparse = tmp_path / "sparse"
    with sparse.open("wb") as stream:
        stream.truncate(5 * 2**30)
    for path in (sparse, Path("/dev/zero")):
        with pytest.raises(InputError, match="is larger than 1 MiB"):
            read_input(path, 2**20)
    assert read_input("/dev/null") == b""
    with pytest.raises(InputError, match="is a pipe or a device"):
        read_input("/dev/null", regular=True)


def test_a_pipe_that_nobody_writes_to(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(inputs, "_PATIENCE", 0.2)
    pipe = tmp_path / "pipe"
    os.mkfifo(pipe)
    with pytest.raises(InputError, match="nobody writes"):
        read_input(pipe)


def test_a_pipe_that_is_slow(tmp_path: Path) -> None:
    pipe = tmp_path / "pipe"
    os.mkfifo(pipe)

    def write() -> None:
        with pipe.open("wb", buffering=0) as stream:
            for part in (b"one ", b"two ", b"three"):
                pause.wait(0.1)
                stream.write(part)

    pause = threading.Event()
    writer = threading.Thread(target=write)
    writer.start()
    assert read_input(pipe) == b"one two three"
    writer.join()
