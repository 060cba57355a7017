"""Pieces of mission files."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from itertools import combinations

Box = tuple[float, float, float, float]  # x from, x to, y from, y to [m]


def interval(low: float, high: float) -> str:
    """`[low, high]` with every digit that matters."""
    return f"[{low:.16g}, {high:.16g}]"


def box(bounds: Box) -> str:
    """`box [..] x [..]`."""
    return f"box {interval(*bounds[:2])} x {interval(*bounds[2:])}"


def region(name: str, bounds: Box) -> str:
    """One region."""
    return f"region {name} = {box(bounds)}"


def document(*parts: str | Iterable[str]) -> str:
    """Lines, with an empty one between parts."""
    blocks = [part if isinstance(part, str) else "\n".join(part) for part in parts]
    return "\n\n".join(block.strip("\n") for block in blocks if block) + "\n"


def comment(text: str) -> str:
    """Comment lines."""
    return "\n".join(f"# {line}" for line in text.splitlines())


def clock(steps: int, workspace: Box) -> list[str]:
    """Step, horizon and workspace."""
    return ["step 1 s", f"horizon {steps}", f"workspace {box(workspace)}"]


def carts(starts: Sequence[tuple[float, float]]) -> list[str]:
    """Double integrators r1, r2, ... that count speed and control as effort."""
    lines = ["dynamics cart = double_integrator"]
    for k, (x, y) in enumerate(starts, 1):
        lines += [
            f"agent r{k} : cart {{",
            f"  start ({x:g}, {y:g})",
            "  control |u| <= 1",
            "  speed <= 2",
            "  effort_state (0, 0, 1, 1)",
            "}",
        ]
    return lines


def channel(cells: int, noise: float = -60) -> list[str]:
    """The paper's channel on cells x cells cells; noise floor [dBm]."""
    return [
        "channel radio {",
        "  path_loss L0 = -12.89 dBm, n = 3",
        "  fading 10 dB^2, shadowing 10 dB^2, length 2 m",
        f"  noise_floor {noise:g} dBm",
        "  modulation oqpsk_802_15_4",
        "  packet 32 bytes",
        f"  partition {cells} x {cells}",
        "}",
    ]


def apart(agents: int, distance: float) -> list[str]:
    """One requirement of separation for each pair."""
    return [
        f"require apart{a}{b}: always separation(r{a}, r{b}) >= {distance:g} m"
        for a, b in combinations(range(1, agents + 1), 2)
    ]
