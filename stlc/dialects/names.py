"""Names that are free to use: those of the other tool, made into names of the language here."""

from __future__ import annotations

import re

from stlc.grammar import tables


class Names:
    """Hands out names, each once."""

    def __init__(self) -> None:
        self._taken = set(_words())

    def pick(self, wanted: str) -> str:
        """`wanted` if it is free and a name; else the nearest that is."""
        base = re.sub(r"\W+", "_", wanted.lstrip("$")).strip("_" if wanted[:1] == "$" else "")
        base = base if base and not base[0].isdigit() else f"x{base}"
        name, count = base, 1
        while name in self._taken:
            count += 1
            name = f"{base}_{count}" if base not in _words() else f"{base}{'_' * (count - 1)}"
        self._taken.add(name)
        return name


def _words() -> set[str]:
    """Words of two letters and more that mean something here, and the ends of intervals."""
    spelled = {w for words in tables().spellings.values() for w in words}
    words = {w for w in spelled if len(w) > 1 and w.isalpha()}
    return words | {"inf", "infinity", "end", "P", "abs", "min", "max", "ahead"}
