"""Time to check missions of many requirements; growth should be linear.

    python benchmarks/scale_check.py [COUNT ...]

Each mission has the given number of named requirements of five kinds over three agents; every
requirement is written out, as a generator of missions would do it.
"""

from __future__ import annotations

import sys
import time
from typing import Final

from stlc.api import loads

HEAD: Final = """step 1 s
horizon 60
workspace box [0, 100] x [0, 100]
dynamics cart = double_integrator
agent r1 : cart { start (1, 1); control |u| <= 1; speed <= 2 }
agent r2 : cart { start (90, 1); control |u| <= 1; speed <= 2 }
agent r3 : cart { start (50, 5); control |u| <= 1; speed <= 2 }
channel radio {
  path_loss L0 = -12 dBm, n = 2
  fading 10 dB^2, shadowing 10 dB^2, length 2 m
  noise_floor -90 dBm
  partition 10 x 10
}
region goal = box [80, 90] x [80, 90]
obstacle pillar = box [40, 60] x [40, 60] inflate 0.3 m
let home(a, g) = eventually[0, 50] a in g
"""


def requirement(k: int) -> str:
    """The k-th requirement; its numbers differ from those of the others."""
    a, b = f"r{k % 3 + 1}", f"r{(k + 1) % 3 + 1}"
    start, end = k % 20, 20 + k % 31
    match k % 5:
        case 0:
            return f"require q{k}: always[{start}, {end}] {a} outside pillar"
        case 1:
            return f"require q{k}: home({a}, goal) or {a}.vx + 0.5 * {b}.vy <= {k % 97 + 1} m/s"
        case 2:
            return f"require q{k}: always[{start}, {end}] separation({a}, {b}) >= 0.{k % 89 + 10} m"
        case 3:
            return f"require q{k}: ({a}.x <= {40 + k % 50}) until[0, {end}] {b} in goal"
        case _:
            return f"require q{k}: always[{start}, {end}] rssi({a}, {b}) >= -{90 + k % 83} dBm"


def mission(count: int) -> str:
    """The text of a mission of `count` requirements."""
    return HEAD + "\n".join(map(requirement, range(count))) + "\n"


def main(counts: list[int]) -> None:
    """Check one mission of each size and print the times."""
    print("requirements   wall s    cpu s   ms each (cpu)")
    loads(mission(10))
    for count in counts:
        text = mission(count)
        wall, cpu = time.perf_counter(), time.process_time()
        checked = loads(text)
        wall, cpu = time.perf_counter() - wall, time.process_time() - cpu
        assert len(checked.requirements) == count
        print(f"{count:12} {wall:8.2f} {cpu:8.2f} {1e3 * cpu / count:15.2f}")


if __name__ == "__main__":
    main([int(argument) for argument in sys.argv[1:]] or [1000, 10000])
