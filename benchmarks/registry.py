"""What is measured: suites of problems, as data. `generate.py` writes the missions."""

from dataclasses import replace

from stlc.bench.problem import Problem, Suite


def _made(
    folder: str,
    name: str,
    generator: str,
    axis: str = "",
    quick: bool = False,
    family: str = "",
    data: tuple[str, ...] = (),
    **parameters: int,
) -> Problem:
    """A generated problem; `axis` names the parameters (by spaces) that growth curves run over."""
    axes = {f"{generator} {one}": float(parameters[one]) for one in axis.split()}
    file = f"{folder}/{name}.stl"
    return Problem(name, file, data, generator, parameters, axes, family, quick)


_TABLE = "headline/links_c{cells}_s{seed}.npz"


def _links(
    family: str, seeds: range, axis: str, agents: int = 2, steps: int = 8, cells: int = 10
) -> tuple[Problem, ...]:
    """Random missions with link costs; those of one size and seed share their table."""
    size = {"agents": agents, "steps": steps, "cells": cells}
    name = f"links_a{agents}_t{steps}_c{cells}_s"
    quick = seeds == _TEN
    return tuple(
        _made("headline", f"{name}{seed}", "links", axis, quick and seed == 0, family,
              (_TABLE.format(cells=cells, seed=seed),), **size, seed=seed)
        for seed in seeds
    )  # fmt: skip


def _talks(kind: int, name: str, *sizes: tuple[int, int, int]) -> tuple[Problem, ...]:
    """Requirements on the channel; `sizes` are agents, steps, cells."""
    return tuple(
        _made("headline", f"{name}_a{a}_t{t}_c{c}", "talks", family=f"{name} required",
              kind=kind, agents=a, steps=t, cells=c, seed=0)
        for a, t, c in sizes
    )  # fmt: skip


_TEN, _TWO = range(10), range(2)

PAPER = Suite(
    "paper",
    "the paper's case and its small sibling: our tables against the paper's own encoding",
    (
        Problem("two_agents_t4", "two_agents_t4.stl", quick=True),
        Problem("two_agents_t8", "two_agents_t8.stl", ("two_agents_t8_link_cost.csv",)),
    ),
    ("auto", "auto:milp", "literal-tight:milp", "literal:milp"),
)

HEADLINE = Suite(
    "headline",
    "the paper's case and families around it: other tables, places, sizes; requirements on links",
    (
        Problem("two_agents_t8", "two_agents_t8.stl", ("two_agents_t8_link_cost.csv",),
                family="two_agents_t8"),
        *(_made("headline", f"two_agents_t8_table{s}", "headline", "", False, "its tables 1 to 5",
                (_TABLE.format(cells=10, seed=s),), seed=s) for s in range(1, 6)),
        *_links("ten random of its size", _TEN, "agents steps cells"),
        *_links("12 steps", _TWO, "steps", steps=12),
        *_links("16 steps", _TWO, "steps", steps=16),
        *_links("15 x 15 cells", _TWO, "cells", cells=15),
        *_links("20 x 20 cells", _TWO, "cells", cells=20),
        *_links("3 agents", _TWO, "agents", agents=3),
        *_links("4 agents", _TWO, "agents", agents=4),
        *_links("6 agents", _TWO, "agents", agents=6),
        *_links("4 agents, 12 steps, 20 x 20", _TWO, "", agents=4, steps=12, cells=20),
        *_talks(0, "rssi", (2, 8, 10), (2, 12, 20), (3, 12, 10), (4, 12, 20)),
        *_talks(1, "ber", (2, 8, 10), (2, 12, 20), (4, 8, 10)),
        *_talks(2, "prr", (2, 8, 20), (3, 12, 10), (4, 12, 10)),
    ),
)  # fmt: skip

STLPY = Suite(
    "stlpy",
    "scenario families of stlpy, robustness maximised; its own models beside ours with --peer",
    (
        *(
            _made("stlpy", f"reach_avoid_T{t}", "reach_avoid", "steps", t <= 20, steps=t)
            for t in (10, 20, 35, 50)
        ),
        _made("stlpy", "either_or_T20_d5", "either_or", quick=True, steps=20, dwell=5),
        _made("stlpy", "either_or_T40_d5", "either_or", steps=40, dwell=5),
        _made("stlpy", "narrow_passage_T25", "narrow_passage", quick=True, steps=25),
        _made("stlpy", "narrow_passage_T40", "narrow_passage", steps=40),
        _made("stlpy", "stepping_stones_15_T15_s1", "stepping_stones", quick=True,
              steps=15, stones=15, seed=1),
        _made("stlpy", "stepping_stones_25_T25_s4", "stepping_stones",
              steps=25, stones=25, seed=4),
        _made("stlpy", "door_puzzle_N1_T20", "door_puzzle", quick=True, steps=20, doors=1),
        _made("stlpy", "door_puzzle_N2_T25", "door_puzzle", quick=True, steps=25, doors=2),
        _made("stlpy", "multitarget_o1_g5_t2_T25_s0", "multitarget", quick=True,
              steps=25, obstacles=1, groups=5, targets=2, seed=0),
        *(
            _made("stlpy", f"multitarget_o3_g4_t2_T30_s{s}", "multitarget",
                  steps=30, obstacles=3, groups=4, targets=2, seed=s)
            for s in (1, 3, 4)
        ),
    ),
)  # fmt: skip

RADIO = Suite(
    "radio",
    "channel cost and requirements on the channel: level, bit errors, chance, packets",
    tuple(
        _made("radio", f"{name}_c{cells}", "radio", quick=cells == 5,
              kind=kind, steps=8, cells=cells)
        for kind, name in enumerate(("cost", "rssi", "ber", "chance", "prr_cost"))
        for cells in (5, 10)
    ),
    ("auto", "unary:milp", "hull:milp", "lifted:milp", "logarithmic:milp"),
)  # fmt: skip

TEAMS = Suite(
    "teams",
    "2 to 6 agents that change sides: alone, paying for every link, always connected; 16 and 32",
    (
        *(_made("teams", f"team_{n}", "team", "agents", n <= 2, agents=n, steps=7)
          for n in range(2, 7)),
        *(_made("teams", f"radio_team_{n}", "radio_team", "agents", n <= 2,
                agents=n, steps=7, cells=5) for n in range(2, 7)),
        *(_made("teams", f"connected_team_{n}", "connected_team", "agents", n <= 2,
                agents=n, steps=7, cells=5) for n in range(2, 7)),
        *(_made("teams", f"swarm_{n}_s{seed}", "swarm", family=f"{n} agents, swept",
                agents=n, steps=20, seed=seed) for n in (16, 32) for seed in range(3)),
    ),
)  # fmt: skip

SCALING = Suite(
    "scaling",
    "horizon, cells, agents, length of the formula: each alone",
    (
        *(_made("scaling", f"horizon_{t}", "patrol", "steps", t <= 50,
                steps=t, targets=2, seed=0) for t in (25, 50, 100, 200)),
        *(_made("scaling", f"targets_{n}", "patrol", "targets", n <= 4,
                steps=30, targets=n, seed=0) for n in (1, 2, 4, 8)),
        *(_made("scaling", f"cells_{n}", "radio", "cells", n <= 6,
                kind=0, steps=6, cells=n) for n in (4, 6, 9, 13, 20)),
        *(_made("scaling", f"agents_{n}", "team", "agents", n <= 3,
                agents=n, steps=8) for n in (1, 2, 3, 4, 5)),
    ),
)  # fmt: skip

LONG = Suite(
    "long",
    "one agent over 10 to 100 steps: rounds, a rover, keys and doors, stlpy's scenarios; "
    "effort minimised",
    (
        *(_made("long", f"rounds_{t}", "rounds", "steps", t == 40, "rounds", steps=t, period=10)
          for t in (40, 60, 100)),
        *(Problem(name, f"published/{name}.stl", family="published")
          for name in ("stlp_rover-1", "stlp_doorpuzzle-1")),
        *(_made("long", f"maze_{n}", "maze", "doors", n == 1, "keys and doors", doors=n)
          for n in range(1, 6)),
        *(replace(p, name=f"frugal_{p.name}", file=f"long/frugal_{p.name}.stl",
                  generator=f"frugal_{p.generator}", axes={}, family="stlpy, effort")
          for p in STLPY.problems),
    ),
)  # fmt: skip

PUBLISHED = Suite(
    "published",
    "what others have published: STLPlanning's rover, door puzzle, wall and STLCG scene, a point "
    "mass of Logic Network Flow; effort or regions' costs minimised",
    (
        *(Problem(f"stlp_{name}", f"published/stlp_{name}.stl", quick=name == "stlcg-1",
                  family="STLPlanning")
          for name in ("stlcg-1", "rover-1", "doorpuzzle-1", "wall-1")),
        Problem("lnf_env1_s0", "published/lnf_env1_s0.stl", ("published/lnf_env1_s0.csv",),
                family="Logic Network Flow"),
    ),
)  # fmt: skip

NETWORKS = Suite(
    "networks",
    "four agents that stay one network over 12 steps; six of which two relay",
    tuple(Problem(name, f"networks/{name}.stl", quick=True)
          for name in ("join_4_t12", "relay_6_t10")),
)  # fmt: skip

_ABLATED = (
    "narrow_passage_T25", "stepping_stones_15_T15_s1", "door_puzzle_N1_T20", "targets_2", "ber_c5",
)  # fmt: skip

ABLATION = Suite(
    "ablation",
    "what each pass and encoding is worth: run with --passes each, or with --encodings",
    tuple(p for s in (STLPY, SCALING, RADIO) for p in s.problems if p.name in _ABLATED),
    tuple(f"{name}:milp" for name in ("auto", "onehot", "stl=unary", "log", "bigm", "stl=hull")),
)

SUITES = (PAPER, HEADLINE, STLPY, RADIO, TEAMS, SCALING, LONG, PUBLISHED, NETWORKS, ABLATION)
