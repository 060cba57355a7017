"""The inputs of a run: each follows from the seed and its number alone."""

from __future__ import annotations

import random
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

from fuzz.corpus import Seed
from fuzz.data import damaged_file
from fuzz.equivalents import TEXTUAL, scene_pair
from fuzz.text import damaged

PAIRS = 10  # every such input is a pair of equivalent scenes
TWINS = 4  # of the mutants that are solved, one in so many has a twin
HEAVY = 4  # of the mutants of heavy missions, one in so many is compiled


@dataclass(frozen=True, slots=True)
class Input:
    """Mission and files; an equivalent text whose optimum is `factor` times this one's."""

    origin: str
    text: str
    files: Mapping[str, bytes] = field(default_factory=dict)
    twin: str | None = None
    factor: float = 1.0
    compiled: bool = True
    change: str = ""

    def write(self, folder: Path) -> None:
        """Files, `m.stl`, and `twin.stl` where there is one."""
        for name, data in self.files.items():
            path = folder / name
            if path.resolve().is_relative_to(folder.resolve()):
                path.parent.mkdir(parents=True, exist_ok=True)
                path.write_bytes(data)
        (folder / "m.stl").write_bytes(self.text.encode("utf-8", "surrogatepass"))
        if self.twin is not None:
            (folder / "twin.stl").write_text(self.twin, encoding="utf-8")


def drawn(number: int, seed: int, seeds: Sequence[Seed]) -> Input:
    """Input `number`."""
    rng = random.Random(f"{seed}/{number}")
    if number % PAIRS == 0:
        one, other, factor, change = scene_pair(rng)
        return Input(f"scene {one.family}", one.text(), {}, other.text(), factor, True, change)
    start, other_seed = rng.choice(seeds), rng.choice(seeds)
    text, files = start.text, dict(start.files)
    if files and rng.random() < 0.4:
        name = rng.choice(sorted(files))
        files[name] = damaged_file(rng, name, files[name])
    else:
        text = damaged(rng, text, other_seed.text)
    change = rng.choice(TEXTUAL)
    twin = change(rng, text) if rng.randrange(TWINS) == 0 else None
    compiled = not start.is_heavy or rng.randrange(HEAVY) == 0
    return Input(start.name, text, files, twin, 1.0, compiled, change.__name__)
