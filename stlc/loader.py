"""Reads the files that a mission names, from under its own folder only unless allowed."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Protocol

from stlc.files import real
from stlc.inputs import InputError, TooLargeError, read_input

_CHECK = "check the name; paths are relative to the file that names them"


class LoadError(Exception):
    """A file that can't be read; `reason` and `hint` are for the person."""

    def __init__(self, reason: str, hint: str) -> None:
        self.reason = reason
        self.hint = hint
        super().__init__(reason)


class Loader(Protocol):
    """Where files come from.

    Names are relative to `base`, the resolved name of the file that names them ("" for the
    mission itself).
    """

    def read_bytes(self, name: str, base: str) -> bytes:
        """Content of a file. Raises LoadError."""
        ...

    def resolve(self, name: str, base: str) -> str:
        """One spelling for each file, so that cycles are seen. Raises LoadError."""
        ...

    def path(self, name: str, base: str) -> Path:
        """Where the file is on disk, for readers of data. Raises LoadError."""
        ...

    def shown(self, resolved: str) -> str:
        """How a resolved name is shown to people."""
        ...


@dataclass(frozen=True, slots=True)
class FolderLoader:
    """Files under `root` and under the folders in `allow`; symbolic links don't lead out."""

    root: Path
    allow: Sequence[Path] = ()

    def resolve(self, name: str, base: str) -> str:
        """Absolute path of a file. Raises LoadError when it lies elsewhere."""
        if "\0" in name or not name:
            raise LoadError("not a file name", "give the name of a file")
        path = real(self._folder(base) / name)
        roots = [real(r) for r in (self.root, *self.allow)]
        if not any(path.is_relative_to(r) for r in roots):
            raise LoadError(
                "lies outside the mission's folder",
                "move it beside the mission, or allow its folder: `--allow-path FOLDER`",
            )
        return str(path)

    def path(self, name: str, base: str) -> Path:
        """Where a file is that is there and may be read. Raises LoadError."""
        path = Path(self.resolve(name, base))
        if not path.is_file():
            raise LoadError("there is no such file", _CHECK)
        return path

    def _folder(self, base: str) -> Path:
        return Path(base).parent if base else self.root

    def shown(self, resolved: str) -> str:
        """The path from the mission's folder, for people."""
        path, root = Path(resolved), real(self.root)
        return str(path.relative_to(root)) if path.is_relative_to(root) else resolved

    def read_bytes(self, name: str, base: str) -> bytes:
        """Content of a file. Raises LoadError."""
        path = Path(self.resolve(name, base))
        try:
            return read_input(path, regular=True)
        except TooLargeError as error:
            raise LoadError(str(error), "use a smaller file") from None
        except InputError as error:
            raise LoadError(str(error), _CHECK) from None


@dataclass(frozen=True, slots=True)
class MemoryLoader:
    """Files held in memory, by name."""

    files: Mapping[str, bytes | str] = field(default_factory=dict)

    def resolve(self, name: str, base: str) -> str:
        """The name itself."""
        return name

    def shown(self, resolved: str) -> str:
        """The name itself."""
        return resolved

    def read_bytes(self, name: str, base: str) -> bytes:
        """Content of a file. Raises LoadError."""
        content = self.files.get(name)
        if content is None:
            raise LoadError("there is no such file", "a text alone has no folder to read from")
        return content.encode() if isinstance(content, str) else content

    def path(self, name: str, base: str) -> Path:
        """Raises LoadError: nothing in memory is on disk."""
        raise LoadError("a text alone has no folder to read from", "save the mission as a file")
