"""CPU seconds and memory of `stlc check` on small files that describe something large.

    python benchmarks/small_inputs.py [NAME ...]

Each file is under 100 kB (those of ten thousand of something up to a megabyte). `check` has to
answer it within 5 CPU s and 1 GB: with a verdict, or with the size that it would have.
"""

# ruff: noqa: E501 - files are told in one line each, as far as they go

from __future__ import annotations

import math
import os
import subprocess
import sys
import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import Final

SECONDS: Final = 5.0
MEGABYTES: Final = 1000.0
GIVEN_UP: Final = 40  # CPU s, then the system ends it

_HEAD = "step 1 s\nhorizon 10\nworkspace box [0, 200] x [0, 200]\n"
_ONE = "agent r : double_integrator { start (1, 1); control |u| <= 1 }\n"
_TWO = _ONE + "agent q : double_integrator { start (9, 1); control |u| <= 1 }\n"
_RADIO = "path_loss L0 = -40 dBm, n = 2; fading 10 dB^2, shadowing 10 dB^2, length 2 m; noise_floor -90 dBm"
_CALM = "require: always r.x >= 0\n"


def _lines(count: int, line: Callable[[int], str]) -> str:
    return "".join(line(k) + "\n" for k in range(count))


def _team(count: int, more: str = "") -> str:
    kind = f"double_integrator {{ start (i * 0.1, 1); control |u| <= 1{more} }}"
    return f"agent r[1..{count}] : {kind}\n"


def _grid(k: int, side: int, gap: float) -> str:
    x, y = k % side, k // side
    return f"box [{x}, {x + 1 - gap:g}] x [{y}, {y + 1 - gap:g}]"


def _star(corners: int) -> str:
    turns = ((math.pi * k / (corners / 2), 90 if k % 2 else 50) for k in range(corners))
    return " ".join(f"({100 + r * math.cos(a):.3f}, {100 + r * math.sin(a):.3f})" for a, r in turns)


def _comb(corners: int) -> str:
    teeth = "".join(f"({k * 0.01:g}, {k % 2 + 1}) " for k in range(corners - 2))
    return f"{teeth}({corners * 0.01:g}, 0) (0, 0)"


def _matrix(states: int) -> str:
    def eye(value: float) -> str:
        rows = (
            ", ".join(f"{value if i == j else 0:g}" for j in range(states)) for i in range(states)
        )
        return "[" + ", ".join(f"[{row}]" for row in rows) + "]"

    return f"dynamics d {{ A = {eye(0.9)}; B = {eye(1.0)}; position x0 x1 }}\n"


def _deep(levels: int) -> str:
    return "require: " + "always[0, 1] (" * levels + "r.x >= 0" + ")" * levels + "\n"


def _chain(count: int, rule: Callable[[int], str], first: str) -> str:
    return f"let f0 = {first}\n" + "".join(f"let f{k} = {rule(k)}\n" for k in range(1, count + 1))


_KEEP_OUT = "require: always forall o in obstacles: r outside o\n"
_RING = "polygon (10, 10) (30, 10) (30, 30) (20, 20) (10, 30)"

FILES: Final[dict[str, Callable[[], str]]] = {
    "star of 10,000 corners": lambda: f"{_HEAD}{_ONE}obstacle o = polygon {_star(10_000)}\n{_KEEP_OUT}",
    "star of 5,500 corners": lambda: f"{_HEAD}{_ONE}obstacle o = polygon {_star(5500)}\n{_KEEP_OUT}",
    "star of 3,000 corners, inflated": lambda: (
        f"{_HEAD}{_ONE}obstacle o = polygon {_star(3000)} inflate 0.1 m\n{_KEEP_OUT}"
    ),
    "comb of 5,000 corners": lambda: f"{_HEAD}{_ONE}region o = polygon {_comb(5000)}\nrequire: eventually r in o\n",
    "10,000 obstacles": lambda: (
        _HEAD + _ONE + _lines(10_000, lambda k: f"obstacle o{k} = {_grid(k, 100, 0.4)}") + _KEEP_OUT
    ),
    "3,000 obstacles that touch": lambda: (
        _HEAD + _ONE + _lines(3000, lambda k: f"obstacle o{k} = {_grid(k, 60, 0)}") + _KEEP_OUT
    ),
    "2,000 obstacles that touch, swept": lambda: (
        _HEAD + _ONE + _lines(2000, lambda k: f"obstacle o{k} = {_grid(k, 60, 0)}")
        + "require: always forall o in obstacles: r outside o swept\n"
    ),
    "2,500 obstacles that touch, swept": lambda: (
        _HEAD + _ONE + _lines(2500, lambda k: f"obstacle o{k} = {_grid(k, 60, 0)}")
        + "require: always forall o in obstacles: r outside o swept\n"
    ),
    "a union of 3,000 boxes that touch": lambda: (
        f"{_HEAD}{_ONE}obstacle o = {' + '.join(_grid(k, 60, 0) for k in range(3000))}\n{_KEEP_OUT}"
    ),
    "a union of 3,000 boxes that overlap": lambda: (
        f"{_HEAD}{_ONE}obstacle o = "
        + " + ".join(f"box [{k * 0.01:g}, {k * 0.01 + 50:g}] x [{k * 0.01:g}, 90]" for k in range(3000))
        + f"\n{_KEEP_OUT}"
    ),
    "10,000 regions": lambda: (
        _HEAD + _ONE + _lines(10_000, lambda k: f"region g{k} = {_grid(k, 100, 0.4)}")
        + "require: eventually exists g in regions: r in g\n"
    ),
    "500 moving obstacles over 1,000 steps": lambda: (
        _HEAD.replace("10\n", "1000\n", 1) + _ONE
        + _lines(500, lambda k: f"obstacle o{k} = {_grid(k, 60, 0)} velocity (0.01, 0)") + _KEEP_OUT
    ),
    "20 moving obstacles over 1,000 steps": lambda: (
        _HEAD.replace("10\n", "1000\n", 1) + _ONE
        + _lines(20, lambda k: f"obstacle o{k} = {_grid(k, 60, 0.4)} velocity (0.01, 0)") + _KEEP_OUT
    ),
    "40 moving obstacles that touch, over 200 steps": lambda: (
        _HEAD.replace("10\n", "200\n", 1) + _ONE
        + _lines(40, lambda k: f"obstacle o{k} = {_grid(k, 8, 0)} velocity (0.01, 0)") + _KEEP_OUT
    ),
    "a moving obstacle of 2,000 frames": lambda: (
        f"{_HEAD}{_ONE}obstacle o = moving {{ "
        + "; ".join(f"{k}: box [{k % 50}, {k % 50 + 1}] x [2, 3]" for k in range(2000))
        + " } linear\nrequire: always r outside o swept\n"
    ),
    "a moving polygon over 100,000 steps": lambda: (
        f"step 1 s\nhorizon 100000\n{_ONE}obstacle o = {_RING} velocity (0.001, 0)\n{_KEEP_OUT}"
    ),
    "frames 900,000 steps apart": lambda: (
        f"step 1 s\n{_ONE}obstacle o = moving {{ 0: {_RING}; 900000: {_RING} }} linear\n{_KEEP_OUT}"
    ),
    "10,000 signals": lambda: (
        "step 1 s\n" + _lines(10_000, lambda k: f"signal s{k}")
        + "require: always (" + " + ".join(f"s{k}" for k in range(10_000)) + " >= 0)\n"
    ),
    "3,000 agents": lambda: (
        _HEAD + _lines(3000, lambda k: f"agent r{k} : single_integrator {{ start (1, {k % 9}) }}")
        + "require: always r0.x >= 0\n"
    ),
    "300 agents, all pairs": lambda: (
        _HEAD + _team(300) + "require: always forall (a, b) in pairs: separation(a, b) >= 0.01\n"
    ),
    "10,000 agents, all pairs": lambda: (
        _HEAD + _team(10_000) + "require: always forall (a, b) in pairs: separation(a, b) >= 0.01\n"
    ),
    "300 agents x 30 channels, all pairs": lambda: (
        _HEAD + _team(300) + _lines(30, lambda k: f"channel c{k} {{ {_RADIO}; partition 4 x 4 }}")
        + "minimize " + " + ".join(f"link_cost(c{k})" for k in range(30)) + "\n" + "require: always r[1].x >= 0\n"
    ),
    "300 agents x 30 channels, rssi of pairs": lambda: (
        _HEAD + _team(300) + _lines(30, lambda k: f"channel c{k} {{ {_RADIO}; partition 4 x 4 }}")
        + _lines(30, lambda k: f"require: always forall (a, b) in pairs: rssi(a, b, c{k}) >= -90 dBm")
    ),
    "2,000 channels of 200 x 200 cells": lambda: (
        _HEAD + _TWO + _lines(2000, lambda k: f"channel c{k} {{ path_loss L0 = -40 dBm, n = 2; partition 200 x 200 }}")
        + _CALM
    ),
    "a channel of 3,000 x 3,000 cells": lambda: (
        f"{_HEAD}{_TWO}channel c {{ {_RADIO}; partition 3000 x 3000 }}\nrequire: always rssi(r, q) >= -90 dBm\n"
    ),
    "a quadtree of a million cells": lambda: (
        f"{_HEAD}{_TWO}channel c {{ {_RADIO}; partition quadtree 1024 x 1024 tolerance 0.001 dB cells 1000000 }}\n"
        "require: always rssi(r, q) >= -90 dBm\n"
    ),
    "400 channels of samples": lambda: (
        _HEAD + _TWO + _lines(400, lambda k: f"channel c{k} {{ {_RADIO}; partition 20 x 20 }}")
        + _lines(400, lambda k: f"require: always rssi(r, q, c{k}) >= -90 dBm")
    ),
    "10,000 requirements": lambda: (
        _HEAD + _ONE + "obstacle o = box [40, 50] x [40, 50]\n"
        + _lines(10_000, lambda k: f"require: always[0, {k % 9}] r outside o")
    ),
    "4,000 requirements on two that touch": lambda: (
        _HEAD.replace("10\n", "3000\n", 1) + _ONE + "obstacle o = box [40, 50] x [40, 50]\nobstacle p = box [50, 60] x [40, 50]\n"
        + _lines(4000, lambda k: f"require: always[{k // 2}, {k // 2}] r outside {'op'[k % 2]}")
    ),
    "2,000 requirements of their own names": lambda: (
        _HEAD + _ONE + _lines(2000, lambda k: f"require q{k}: eventually[0, 9] (r.x >= {k} and r.y <= {k})")
    ),
    "a chain of 2,000 lets, each twice the last": lambda: (
        _HEAD + _ONE + _chain(2000, lambda k: f"f{k - 1} + f{k - 1}", "r.x") + "require: always f2000 >= 0\n"
    ),
    "a chain of 2,000 formula lets, each twice the last": lambda: (
        _HEAD + _ONE + _chain(2000, lambda k: f"f{k - 1} and not f{k - 1}", "r.x >= 0") + "require: f2000\n"
    ),
    "a chain of 60 lets of max": lambda: (
        _HEAD + _ONE + _chain(60, lambda k: f"max(f{k - 1}, 1 - f{k - 1})", "r.x") + "require: always f60 >= 0\n"
    ),
    "a chain of 40 lets of abs and sums": lambda: (
        _HEAD + _ONE + _chain(40, lambda k: f"|f{k - 1}| + |f{k - 1} - {k}|", "r.x") + "require: always f40 >= 0\n"
    ),
    "a chain of 30 functions of two arguments": lambda: (
        _HEAD + _TWO + "let g0(a, b) = a.x + b.x\n"
        + "".join(f"let g{k}(a, b) = g{k - 1}(a, b) + g{k - 1}(b, a)\n" for k in range(1, 31))
        + "require: always g30(r, q) >= 0\n"
    ),
    "2,000 parameters in a chain": lambda: (
        _HEAD + _ONE + "param p0 = 1\n" + "".join(f"param p{k} = p{k - 1} + 1\n" for k in range(1, 2001))
        + "require: always r.x >= p2000 - 2001\n"
    ),
    "nested 190 levels deep, over time": lambda: f"step 1 s\n{_ONE}{_deep(190)}",
    "until nested 60 levels deep": lambda: (
        f"step 1 s\n{_ONE}require: " + "((r.x >= 0) until[0, 9] " * 60 + "(r.y >= 0)" + ")" * 60 + "\n"
    ),
    "iff nested 60 levels deep": lambda: (
        f"step 1 s\n{_ONE}require: " + "((r.x >= 0) iff " * 60 + "(r.y >= 0)" + ")" * 60 + "\n"
    ),
    "always[0,9000] of until[0,9000]": lambda: (
        f"step 1 s\n{_ONE}require: always[0, 9000] (r.x >= 0 until[0, 9000] r.y >= 0)\n"
    ),
    "a cube of quantifiers": lambda: (
        f"{_HEAD}{_ONE}require: forall a in 1..300: forall b in 1..300: forall c in 1..300: r.x >= a + b + c - 900\n"
    ),
    "a quantifier over a million": lambda: f"{_HEAD}{_ONE}require: forall a in 1..1000000: r.x >= a - 1e6\n",
    "3,000 regions in a quantifier twice": lambda: (
        _HEAD + _ONE + _lines(3000, lambda k: f"region g{k} = {_grid(k, 60, 0.4)}")
        + "require: forall g in regions: exists h in regions: eventually (r in g or r in h)\n"
    ),
    "sums over 3,000 agents, thrice": lambda: (
        _HEAD + _team(3000) + "require: always forall b in agents: (sum a in agents: a.x) - b.x >= -1\n"
    ),
    "2,000 agents with matrices": lambda: (
        _HEAD + _matrix(6)
        + _lines(2000, lambda k: f"agent r{k} : d {{ start (1, {k % 9}, 0, 0, 0, 0) }}")
        + "require: always r0.x0 >= 0\n"
    ),
    "100 states": lambda: (
        f"{_HEAD}{_matrix(100)}agent r : d {{ start ({', '.join(['1'] * 100)}) }}\nrequire: always r.x0 >= 0\n"
    ),
    "a horizon of a million": lambda: f"step 1 s\nhorizon 1000000\n{_ONE}{_CALM}",
    "a polygon norm of 100,000 sides": lambda: (
        f"{_HEAD}agent r : double_integrator {{ start (1, 1); control |u| <= 1; speed <= 1 polygon 100000 }}\n{_CALM}"
    ),
    "10,000 stations": lambda: (
        _HEAD + _ONE + _lines(10_000, lambda k: f"station s{k} at ({k % 100}, {k // 100})")
        + "require: eventually exists s in stations: distance(r, s) <= 5 m\n"
    ),
    "imports, 2,000 times the same": lambda: f"{_HEAD}{_ONE}{_CALM}" + 'import "m.stl"\n' * 2000,
}  # fmt: skip


def measured(text: str) -> tuple[int, float, float, str]:
    """(status, CPU s, peak MB, the first line it says) of `stlc check` on a text."""
    import resource

    def limited() -> None:
        resource.setrlimit(resource.RLIMIT_CPU, (GIVEN_UP, GIVEN_UP))
        resource.setrlimit(resource.RLIMIT_AS, (6 << 30, 6 << 30))

    with tempfile.TemporaryDirectory() as folder:
        (Path(folder) / "m.stl").write_text(text)
        words = [sys.executable, "-c", "from stlc.cli import main; main()", "check", "m.stl"]
        out = Path(folder) / "out"
        with out.open("wb") as stream:
            process = subprocess.Popen(
                words, cwd=folder, stdout=stream, stderr=stream, preexec_fn=limited
            )
            _, status, usage = os.wait4(process.pid, 0)
            process.returncode = os.waitstatus_to_exitcode(status)
        said = out.read_text(errors="replace").splitlines()
    first = next((line for line in said if line.startswith("error")), said[0] if said else "")
    seconds = usage.ru_utime + usage.ru_stime
    return process.returncode, seconds, usage.ru_maxrss / 1024.0, first[:90]


def main(names: list[str]) -> int:
    """Print a line for each file; 1 if any took too much or ended badly."""
    print(f"{'':52} {'kB':>6} {'CPU s':>6} {'MB':>6}  exit")
    bad = 0
    for name, made in FILES.items():
        if names and not any(word in name for word in names):
            continue
        text = made()
        status, seconds, size, said = measured(text)
        ok = status in (0, 1) and seconds <= SECONDS and size <= MEGABYTES
        bad += not ok
        mark = " " if ok else "*"
        line = f"{name:51}{mark} {len(text) / 1e3:6.0f} {seconds:6.2f} {size:6.0f}  {status:4}"
        print(f"{line}  {said}", flush=True)
    return int(bad > 0)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
