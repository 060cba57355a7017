"""Code blocks of a Markdown file, with what the comments before them say.

    <!-- prelude NAME          statements that the blocks `stl in NAME` are checked after
    ... -->
    <!-- file NAME = PATH -->  a file of the repository that the commands find as NAME
    <!-- not run: reason -->               the next block is not run
    <!-- not run `stlc bench`: reason -->  nor are the lines of the next block that start so

Information strings: `stl` a whole mission; `stl in NAME` a fragment; `stl file=NAME` saved too;
`stl error E0301` must be refused with this code, `stl warning W1001` warns; `sh` and `console`
hold commands (and after `console`'s `$` lines their output, `...` for parts left out); `python`.
Any other block with `file=NAME` is saved as a file.
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from pathlib import Path

_BLOCK = re.compile(r"^```([^\n`]*)\n(.*?)^```\s*?$", re.M | re.S)
_COMMENT = re.compile(r"<!--\s*(.*?)\s*-->", re.S)


@dataclass(frozen=True, slots=True)
class Block:
    """One fenced block: first line number, words of its information string, text, comments."""

    line: int
    info: tuple[str, ...]
    text: str
    comments: tuple[str, ...]

    @property
    def language(self) -> str:
        """First word; blocks without one that hold stlc commands are `sh`."""
        if self.info:
            return self.info[0]
        return "sh" if self.text.startswith("stlc ") else ""

    def word_after(self, word: str) -> str | None:
        """`in NAME`: the word that follows."""
        places = [k for k, w in enumerate(self.info[:-1]) if w == word]
        return self.info[places[0] + 1] if places else None

    @property
    def file(self) -> str | None:
        """NAME of `file=NAME`."""
        names = [w.removeprefix("file=") for w in self.info if w.startswith("file=")]
        return names[0] if names else None

    def runs(self, line: str) -> bool:
        """Whether no comment excludes this line."""
        for comment in self.comments:
            match = re.match(r"not run(?: `([^`]*)`)?: \S", comment)
            if match and line.startswith(match[1] or ""):
                return False
        return True


def blocks(path: Path) -> list[Block]:
    """All blocks of a file; a comment belongs to the block that comes next."""
    text = path.read_text(encoding="utf-8")
    found, before = [], 0
    for match in _BLOCK.finditer(text):
        comments = tuple(m[1] for m in _COMMENT.finditer(text, before, match.start()))
        line = text.count("\n", 0, match.start()) + 1
        found.append(Block(line, tuple(match[1].split()), match[2], comments))
        before = match.end()
    return found


def preludes(found: list[Block]) -> dict[str, str]:
    """Statements of each prelude by name."""
    texts = (c.split("\n", 1) for b in found for c in b.comments if c.startswith("prelude "))
    return {head.split()[1]: body for head, body in texts}


def borrowed(found: list[Block]) -> dict[str, str]:
    """Files of the repository under the names that the commands use."""
    pairs = (c[5:].split("=") for b in found for c in b.comments if c.startswith("file "))
    return {name.strip(): path.strip() for name, path in pairs}
