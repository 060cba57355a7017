"""Random small missions, solved by every backend: do all come to one certified objective?

    python benchmarks/agreement.py [N] [--seed S] [BACKEND ...]

Each mission is written in the language, compiled once, given to each installed backend with a
relative gap of 1e-6, certified against the model and verified against the mission. `infeasible`
is an answer too: then all have to say so. Prints the missions on which they differ, or on which
one of them failed (SciPy's older HiGHS does now and then) or was refused by certification.
"""

from __future__ import annotations

import argparse
import sys
from collections import Counter
from os import times
from pathlib import Path
from time import process_time

import numpy as np

from stlc import backends
from stlc.api import loads
from stlc.backends.base import Solution, SolveOptions, Status
from stlc.errors import InfeasibleError, SolverError
from stlc.milp.compile import Compiled, compile_mission
from stlc.mission import Mission
from stlc.solve.certify import certify
from stlc.solve.judge import Judge

SIZE = 8  # the workspace is [0, 8] x [0, 8]
CLOSE = 1e-4  # relative difference of objectives that a gap of 1e-6 and tolerances explain
REFUSED = "refused"  # by certification
ASIDE = {REFUSED, Status.FAILED.value}  # no answer that anybody would see


def random_mission(seed: int, folder: Path) -> str:
    """Text of a mission; its table of link costs, if it has one, is written to `folder`."""
    rng = np.random.default_rng(seed)
    horizon, agents = int(rng.integers(3, 6)), int(rng.integers(1, 3))
    names = [f"a{i}" for i in range(agents)]
    channel = _channel(rng, seed, folder) if rng.random() < 0.4 else ""
    lines = [f"step 1 s\nhorizon {horizon}\nworkspace box [0, {SIZE}] x [0, {SIZE}]"]
    lines += [_agent(rng, name, k) for k, name in enumerate(names)]
    lines += [f"region {name} = {_box(rng)}" for name in ("red", "green")]
    lines += [f"obstacle o{k} = {_box(rng)}" for k in range(int(rng.integers(0, 3)))]
    if channel and agents == 1:
        lines.append("station base at (4, 4)")
    lines.append(channel)
    lines += [f"require r{k}: {_formula(rng, name, horizon)}" for k, name in enumerate(names)]
    obstacles = [line.split()[1] for line in lines if line.startswith("obstacle")]
    lines += [f"require clear_{o}: always[1, {horizon}] a0 outside {o}" for o in obstacles]
    if agents == 2 and rng.random() < 0.5:
        lines.append(f"require apart: always[1, {horizon}] separation(a0, a1) >= 0.5")
    lines.append(f"minimize {_objective(rng, bool(channel))}")
    return "\n".join(filter(None, lines)) + "\n"


def _agent(rng: np.random.Generator, name: str, k: int) -> str:
    x, y = rng.integers(0, SIZE, 2) + 0.5
    kind = "double_integrator" if rng.random() < 0.7 else "single_integrator"
    speed = f"\n  speed <= {rng.choice([1.5, 2])}" if kind == "double_integrator" else ""
    limit = rng.choice([1, 1.5, 2])
    return f"agent {name} : {kind} {{\n  start ({x}, {y})\n  control |u| <= {limit}{speed}\n}}"


def _box(rng: np.random.Generator) -> str:
    x, y = rng.integers(0, SIZE - 2, 2)
    w, h = rng.integers(1, 3, 2)
    return f"box [{x}, {x + w}] x [{y}, {y + h}]"


def _channel(rng: np.random.Generator, seed: int, folder: Path) -> str:
    """A channel by its parameters, or by a table of costs for 3 x 3 cells."""
    if rng.random() < 0.5:
        noise = int(rng.integers(-40, -20))
        return (
            "channel radio {\n  path_loss L0 = -13 dBm, n = 3\n  fading 10 dB^2\n"
            f"  noise_floor {noise} dBm\n  partition 2 x 2\n}}"
        )
    half = np.round(rng.uniform(0.1, 3, (9, 9)), 2)
    name = f"table_{seed}.csv"
    np.savetxt(folder / name, np.triu(half) + np.triu(half, 1).T, fmt="%.2f", delimiter=",")
    return f'channel radio {{\n  partition 3 x 3\n  table "{name}"\n}}'


def _formula(rng: np.random.Generator, name: str, horizon: int) -> str:
    start = int(rng.integers(0, 2))
    window = f"[{start}, {horizon}]"
    match int(rng.integers(0, 5)):
        case 0:
            return f"eventually{window} {name} in red"
        case 1:
            return f"({name} outside red) until{window} ({name} in green)"
        case 2:
            return f"eventually{window} ({name} in red or {name} in green)"
        case 3:
            last = horizon - 1
            return f"eventually[1, {last}] always[0, 1] {name} in green"
        case _:
            return f"eventually{window} {name} in red and always[1, {horizon}] {name} outside green"


def _objective(rng: np.random.Generator, channel: bool) -> str:
    if channel:
        return "0.3 * effort + 0.7 * link_cost(radio)"
    return str(rng.choice(["effort", "effort", "0.1 * effort - robustness"]))


def answers(compiled: Compiled, mission: Mission, names: list[str]) -> dict[str, str | float]:
    """What each backend comes to: an objective (certified and verified), or why not."""
    return {name: _answer(compiled, mission, name) for name in names}


def _answer(compiled: Compiled, mission: Mission, name: str) -> str | float:
    asked = SolveOptions(gap=1e-6, time_limit=60.0, threads=1)
    solution: Solution = backends.get(name).solve(compiled.model, asked)
    if solution.x is None:
        return solution.status.value
    try:
        certified = certify(compiled.model, solution, options=asked)
    except SolverError:
        return REFUSED
    _, report = Judge(mission, compiled).judge(solution, asked)
    if not report.ok:
        return "the verifier refuses the plan"
    # A big-M leak may cost the word 'optimal' but not the point.
    if certified.status is not Status.OPTIMAL and not certified.warnings:
        return certified.status.value
    assert certified.objective is not None
    return certified.objective


def agree(found: dict[str, str | float]) -> bool:
    """One objective, or one verdict, of all that didn't fail and weren't refused."""
    found = {k: v for k, v in found.items() if v not in ASIDE}
    values = [v for v in found.values() if isinstance(v, float)]
    if len(values) < len(found):
        return set(found.values()) == {Status.INFEASIBLE.value}
    return max(values) - min(values) <= CLOSE * max(1.0, abs(min(values)))


def judge_seed(seed: int, folder: Path, names: list[str]) -> tuple[str, dict[str, str | float]]:
    """'agree', 'infeasible' (both by all backends), 'intervals' (no solver needed) or 'differ'."""
    mission = loads(random_mission(seed, folder), name=f"{seed}.stl", folder=folder)
    try:
        compiled = compile_mission(mission)
    except InfeasibleError:
        return "intervals", {}
    found = answers(compiled, mission, names)
    if not agree(found):
        return "differ", found
    return ("infeasible" if "infeasible" in found.values() else "agree"), found


def installed() -> list[str]:
    """Every backend that can run here."""
    known = [name for name in backends.names() if name != "external"]
    return [name for name in known if backends.get(name).available() is None]


def main() -> int:
    """Run and report."""
    import tempfile

    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("count", type=int, nargs="?", default=200)
    parser.add_argument("backends", nargs="*")
    parser.add_argument("--seed", type=int, default=0)
    words = parser.parse_args()
    names = words.backends or installed()
    print("backends:", *(backends.get(n).version() for n in names), sep="\n  ", flush=True)
    tally: Counter[str] = Counter()
    seed = words.seed
    with tempfile.TemporaryDirectory() as folder:
        while tally.total() - tally["intervals"] < words.count:  # those that solvers have seen
            verdict, found = judge_seed(seed, Path(folder), names)
            tally[verdict] += 1
            if verdict == "differ" or ASIDE & set(found.values()):
                print(f"seed {seed}: {found}", flush=True)
            seed += 1
    solved = tally.total() - tally["intervals"]
    print(
        f"{solved} missions (seeds {words.seed} to {seed - 1}) by {len(names)} backends: "
        f"{dict(tally)}; {process_time() + sum(times()[2:4]):.0f} CPU s"
    )
    return int(tally["differ"] > 0)


if __name__ == "__main__":
    sys.exit(main())
