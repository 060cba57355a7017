"""Atomic writing: all or nothing, and a clear sentence."""

import errno
import os
import stat

import pytest

from stlc.errors import OutputError
from stlc.files import atomic_output, write_atomic


def test_writes_text_and_bytes(tmp_path):
    write_atomic(tmp_path / "a", "naïve\n")
    write_atomic(str(tmp_path / "b"), b"\x00\x01")
    assert (tmp_path / "a").read_bytes() == "naïve\n".encode()
    assert (tmp_path / "b").read_bytes() == b"\x00\x01"
    assert sorted(p.name for p in tmp_path.iterdir()) == ["a", "b"]


def test_a_failure_leaves_the_old_file(tmp_path):
    target = tmp_path / "plan.json"
    target.write_text("old")
    with pytest.raises(ZeroDivisionError), atomic_output(target) as stream:
        stream.write(b"half of it" * (1 // 0))
    assert target.read_text() == "old"
    assert list(tmp_path.iterdir()) == [target]


def test_keeps_mode_and_follows_links(tmp_path):
    target, link = tmp_path / "real", tmp_path / "link"
    target.write_text("old")
    target.chmod(0o640)
    link.symlink_to(target)
    write_atomic(link, "new")
    assert link.is_symlink()
    assert target.read_text() == "new"
    assert stat.S_IMODE(target.stat().st_mode) == 0o640


@pytest.mark.parametrize(
    ("place", "words"),
    [
        ("missing/plan.json", "folder .*missing does not exist"),
        ("folder", "it is a folder"),
        ("file/plan.json", "is a file, not a folder"),
        ("x" * 300, "too long"),
    ],
)
def test_sentences(tmp_path, place, words):
    (tmp_path / "folder").mkdir()
    (tmp_path / "file").write_text("")
    with pytest.raises(OutputError, match=words):
        write_atomic(tmp_path / place, "x")
    assert sorted(p.name for p in tmp_path.iterdir()) == ["file", "folder"]


def test_full_disk():
    with pytest.raises(OutputError, match="disk is full"):
        write_atomic("/dev/full", "x" * 100_000)
    assert stat.S_ISCHR(os.stat("/dev/full").st_mode)


@pytest.mark.parametrize(
    ("number", "words"), [(errno.EACCES, "permission denied"), (errno.EROFS, "read-only")]
)
def test_refused_by_the_system(tmp_path, monkeypatch, number, words):
    def refuse(*args: object) -> None:
        raise OSError(number, "refused")

    monkeypatch.setattr(os, "replace", refuse)
    with pytest.raises(OutputError, match=words):
        write_atomic(tmp_path / "plan.json", "x")
    assert not list(tmp_path.iterdir())
