"""The inputs of a run: each follows from the seed and its number alone."""

from __future__ import annotations

import random
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

from truth.scene import Obstacle

from fuzz.corpus import Seed
from fuzz.data import damaged_file
from fuzz.equivalents import TEXTUAL, scene_pair
from fuzz.text import damaged

PAIRS = 100  # every such input is a pair of equivalent scenes: 3.5 CPU s each, a mutant takes 0.08
TWINS = 4  # of the mutants that are solved, one in so many has a twin
CLOSE = 2e-3  # relative difference of optima: both are solved to a gap of 1e-4, and rounded
CUT = 0.05  # the same where polygons are cut into other convex pieces: `swept` keeps to their faces
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
    close: float = CLOSE

    def write(self, folder: Path) -> None:
        """Files, `m.stl`, and `twin.stl` where there is one."""
        for name, data in self.files.items():
            path = folder / name
            if path.resolve().is_relative_to(folder.resolve()):
                path.parent.mkdir(parents=True, exist_ok=True)
                path.write_bytes(data)
        (folder / "m.stl").write_bytes(self.text.encode("utf-8", "surrogatepass"))
        if self.twin is not None:
            (folder / "twin.stl").write_bytes(self.twin.encode("utf-8", "surrogatepass"))


def _is_box(obstacle: Obstacle) -> bool:
    return all(part.is_box for parts in obstacle.frames.values() for part in parts)


def drawn(number: int, seed: int, seeds: Sequence[Seed]) -> Input:
    """Input `number`."""
    rng = random.Random(f"{seed}/{number}")
    if number % PAIRS == 0:
        one, other, factor, change = scene_pair(rng)
        same = all(_is_box(o) for o in one.obstacles) or change.startswith(("moved", "scaled"))
        texts, close = (one.text(), {}, other.text()), CLOSE if same else CUT
        return Input(f"scene {one.family}", *texts, factor, True, change, close)
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
