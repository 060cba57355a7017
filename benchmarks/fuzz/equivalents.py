"""Other ways to say the same mission: the verdict and the optimum must stay."""

from __future__ import annotations

import random
import re
from collections.abc import Callable
from dataclasses import dataclass, replace

from truth.draw import FAMILIES, draw
from truth.scene import DOUBLE, Body, Obstacle, Part, Point, Ring, Scene

_STATEMENT = re.compile(
    r"^(import|param|step|horizon|margin|workspace|dynamics|agent|station|region|obstacle|channel|"
    r"signal|let|require|minimize|maximize|prefer)\b"
)
_NAMED = re.compile(r"^(?:agent|region|obstacle|station|dynamics) (\w{2,})\b", re.M)


def statements(text: str) -> list[str]:
    """A file's statements with the lines that continue them."""
    found: list[str] = []
    for line in text.split("\n"):
        if found and not _STATEMENT.match(line):
            found[-1] += "\n" + line
        else:
            found.append(line)
    return found


def reordered(rng: random.Random, text: str) -> str:
    """Statements in another order."""
    parts = statements(text)
    rng.shuffle(parts)
    return "\n".join(parts)


def renamed(rng: random.Random, text: str) -> str:
    """Agents and places under other names, in the other order of the alphabet."""
    names = sorted(set(_NAMED.findall(text)))
    for k, name in enumerate(names):
        text = re.sub(rf"(?<![\w\".]){name}\b(?!\")", f"n{len(names) - k}_{name}", text)
    return text


TEXTUAL: tuple[Callable[[random.Random, str], str], ...] = (reordered, renamed)


@dataclass(frozen=True, slots=True)
class Shift:
    """p -> scale * (p, or p with x and y exchanged, or mirrored) + offset [m]."""

    scale: float = 1.0
    swap: bool = False
    mirror: bool = False
    offset: Point = (0.0, 0.0)

    def vector(self, v: Point) -> Point:
        """Of a velocity or a distance."""
        x, y = (v[1], v[0]) if self.swap else v
        return self.scale * (-x if self.mirror else x), self.scale * y

    def point(self, p: Point) -> Point:
        """Of a place."""
        x, y = self.vector(p)
        return x + self.offset[0], y + self.offset[1]

    def part(self, part: Part) -> Part:
        """Of a polygon; a box stays one."""
        return Part(self.ring(part.ring), tuple(map(self.ring, part.holes)), part.is_box)

    def ring(self, ring: Ring) -> Ring:
        """Of corners."""
        return tuple(map(self.point, ring))

    def body(self, body: Body) -> Body:
        """Of an integrator."""
        start = self.point((body.start[0], body.start[1]))
        if body.model.kind == DOUBLE:
            start += self.vector((body.start[2], body.start[3]))
        speed = None if body.speed is None else body.speed * self.scale
        return replace(body, start=start, control=body.control * self.scale, speed=speed)

    def scene(self, scene: Scene) -> Scene:
        """Of everything."""
        gaps = {k: (self.vector(gap), w) for k, (gap, w) in scene.apart.items()}
        return replace(
            scene,
            workspace=self.part(Part(scene.workspace)).ring,
            bodies=tuple(map(self.body, scene.bodies)),
            obstacles=tuple(map(self.obstacle, scene.obstacles)),
            regions={k: tuple(map(self.part, v)) for k, v in scene.regions.items()},
            apart={k: ((abs(g[0]), abs(g[1])), w) for k, (g, w) in gaps.items()},
            goals={k: self.part(v) for k, v in scene.goals.items()},
        )

    def obstacle(self, obstacle: Obstacle) -> Obstacle:
        """Of its frames and what it grows by."""
        frames = {k: tuple(map(self.part, v)) for k, v in obstacle.frames.items()}
        return replace(obstacle, frames=frames, grow=obstacle.grow * self.scale)


def cut_up(scene: Scene) -> Scene:
    """Every box of an obstacle as two that touch, the second one first."""

    def halves(part: Part) -> tuple[Part, ...]:
        if not part.is_box:
            return (part,)
        (x0, x1), (y0, y1) = (sorted({p[k] for p in part.ring}) for k in range(2))
        middle = (y0 + y1) / 2.0
        low, high = (((x0, a), (x1, a), (x1, b), (x0, b)) for a, b in ((y0, middle), (middle, y1)))
        return Part(high, is_box=True), Part(low, is_box=True)

    def cut(o: Obstacle) -> Obstacle:
        frames = {k: tuple(h for p in parts for h in halves(p)) for k, parts in o.frames.items()}
        return replace(o, frames=frames)

    return replace(scene, obstacles=tuple(map(cut, scene.obstacles)))


def rings_turned(scene: Scene) -> Scene:
    """Every polygon the other way round, from another corner, with a corner on an edge."""

    def turned(part: Part) -> Part:
        if part.is_box:
            return part
        ring = (*part.ring[::-1][1:], part.ring[-1])
        (ax, ay), (bx, by) = ring[:2]
        return replace(part, ring=(ring[0], ((ax + bx) / 2, (ay + by) / 2), *ring[1:]))

    def turn(o: Obstacle) -> Obstacle:
        return replace(o, frames={k: tuple(map(turned, v)) for k, v in o.frames.items()})

    return replace(scene, obstacles=tuple(map(turn, scene.obstacles)))


def scene_pair(rng: random.Random) -> tuple[Scene, Scene, float, str]:
    """A scene, an equivalent one, what the second optimum is divided by, and the change's name."""
    while True:
        scene = draw(rng.choice(sorted(FAMILIES)), rng.randrange(10**6))
        if all(not body.model.A and not body.turns for body in scene.bodies):
            break
    match rng.randrange(6):
        case 0:
            return scene, cut_up(scene), 1.0, "cut up"
        case 1:
            return scene, rings_turned(scene), 1.0, "rings turned"
        case 2:
            far = rng.choice((100.0, 4096.0, 1e4, 1e5, 1e6))
            shift = Shift(offset=(far, -far / 3 if rng.random() < 0.5 else 0.0))
            return scene, shift.scene(scene), 1.0, f"moved by {far:g} m"
        case 3:
            scale = rng.choice((0.01, 0.1, 10.0, 100.0, 1000.0))
            return scene, Shift(scale).scene(scene), scale, f"scaled by {scale:g}"
        case 4:
            return scene, Shift(swap=True).scene(scene), 1.0, "axes exchanged"
        case _:
            return scene, Shift(mirror=True, offset=(3.0, 7.0)).scene(scene), 1.0, "mirrored"
