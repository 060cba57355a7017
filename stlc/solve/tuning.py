"""Every number of the searches that was chosen by measuring, one frozen record a search.

Tolerances are no tuning: they stand where they are used. Read the records as `tuning.PAIR` and so
on, so that `benchmarks/tuning.py` can vary them: it halves and doubles each number over the
missions named there and prints what that does to processor time, plans and bounds. What it found
is said beside each number, as processor time relative to that of the number as it stands; "flat"
is within its noise of 10 %. Numbers with nothing said have not been varied.
"""

from __future__ import annotations

from stlc.record import Record


class Brief(Record):
    """`strategies.py`: one plain solve of a small model, before any search."""

    columns: int = 1500  # flat halved; doubled 1.2 the time where the search would have ended first
    seconds: float = 1.0  # halved 1.8 the time of a team of two, doubled flat
    share: float = 0.1  # of the time limit; flat


class Pair(Record):
    """`bounders/pair.py`: two agents."""

    rate_bins: int = 2  # of the rate along each axis; halved flat, doubled 1.35 the time
    leaf_pairs: int = 700  # cell pairs that go to the solver when no choice is open; flat
    open_leaf_pairs: int = 200  # and when one is; halved flat, doubled 1.4 the time
    dive_pairs: int = 4000  # so few left are worth a look for better plans; flat
    most_states: int = 500_000  # pairs of states: more are too slow for an ascent; both 1.1
    open_most_states: int = 200_000  # and where a choice is open; flat
    ascent_rounds: int = 12  # halved 1.1 the time, doubled flat


class Team(Record):
    """`bounders/team.py`: more than two agents.

    On `three_agents_t4` (4.8 CPU s, proven) each number halved and doubled is flat where nothing
    else is said: most of a small team goes to the solver at once.
    """

    leaf_pairs: int = 2500  # cell pairs that go to the solver when no choice is open
    open_leaf_pairs: int = 900  # and when one is
    dive_pairs: int = 1000  # where a plunge ends
    coarse_cells: int = 144  # merged grid of the first prices; doubled: bound +1.5 % after 10 s
    coarse_rounds: int = 12  # of prices; bound flat
    root_rounds: int = 30  # halved: bound -0.7 % after 10 s, doubled: +0.7 %, 1.2 the small team's
    rounds: int = 8
    momentum: float = 0.7  # halved 1.1 the time, doubled flat
    first_step: float = 0.02  # of the bound: the first step of the potentials
    later_step: float = 0.05  # of the gap
    climb_seconds: float = 20.0  # of prices at one node, at most
    leaf_seconds: float = 30.0  # of the solver, for what is small
    dive_seconds: float = 8.0  # for better plans: near a node's best runs, or near the plan
    worth_halves: float = 0.01  # of the gap: where an ascent and halves raise it by less, no more.
    # 0.03: links_a4_t8_c10_s1 split positions for 25 CPU s instead, and the bound stayed
    polish_share: float = 0.1  # of the time that is left, near the plan, and at most
    border_states: int = 30_000  # at a step: borders of more do not become cells, 10 times as many
    plunge_every: int = 8  # nodes
    pairs: int = 4_000_000  # of states in all, of which an ascent takes 0.1 CPU s a million
    split_pairs: int = 30_000_000  # likewise, with alternatives apart: 12 bytes each
    ascent_share: float = 0.25  # of the time that is left, for each
    halved: float = 0.5  # of the spread of all boxes, in those that are halved at once
    stage_rounds: int = 15  # of an ascent between two heats
    heat: float = 0.04  # of the gap, for all pairs together; 0.1 brought nothing
    cooler: float = 0.6  # links_a4_t8_c10_s1: 62.9 -> 63.8, 64.2, 64.4, 64.6 in 3 CPU s each,
    coldest: float = 0.004  # where sweeps and steps along single paths end at 63.7
    worth: float = 0.01  # of the gap: a stage that raises it by less is the last
    plunge_cut: float = 0.75  # of the gap, while plunging
    plunge_least: float = 0.95  # of the cell pairs: a cut that leaves more is the last. Without it
    # links_a4_t8_c10_s1 plunged for 35 of 60 CPU s


class Descents(Record):
    """`heuristics/iterated.py`: runs of teams on lattices of controls, others held."""

    idle: int = 40  # descents that better nothing; links_a4_t8_c10_s0 had its best after 17 in all,
    # 1.3 CPU s, links_a6_t8_c10_s0 went from 203 to 190 in 14, 2.3 CPU s
    sweeps: int = 6  # of all agents in one; mostly 3 are made
    seconds: float = 10.0  # at most
    share: float = 0.1  # of the time that is left, and at most
    follow_seconds: float = 10.0  # for the plan along the best runs; takes 0.5 to 3


class Dive(Record):
    """`heuristics/dive.py`: a run at the static robustness bound."""

    first_limit: float = 30.0  # LPs before the first restart, at least; flat
    per_choice: float = 1.5  # and so many for each disjunction, to reach the bottom; flat
    granted: int = 4  # dives that are always made; flat
    growth: float = 1.1  # of the limit at each restart; flat
    glance_lps: float = 40.0  # of dives before the first restart, at least; halved 1.2, doubled 0.9
    glance_share: float = 0.5  # and of that limit; flat


class Lone(Record):
    """`alone/effort_rows.py`: one agent of a team alone."""

    seconds: float = 20.0  # at most for each; flat
    share: float = 0.5  # of the time that is left, for all of them
    first: float = 0.15  # of that for a first look at each; agents that need more share the rest
    generous: float = 2.0  # times an even share for each of these: who is proven early leaves time
    # to the others. Even shares, half of all for the first look: none of the 8 of mastl_loop_N8,
    # 1 to 4 CPU s each, was proven in 20, bound 3.4; now all but one or all are, bound 7.9 to 8.6
    least: float = 1.0  # s: with less time than that it is left out; flat
    crowd: int = 12  # agents without a radio that are planned from what they do alone; by turns
    # before that, 16 are at 1.8 % after 26 CPU s, and 32 have no plan in 60


class Part(Record):
    """`alone/parts.py`: bounds of a few agents without the others."""

    share: float = 0.6  # of the time that is left, for all groups
    most: float = 300.0  # s
    seconds: float = 15.0  # at most for each
    gap: float = 0.01
    worth: float = 0.007  # of what the plan costs: where bounds are nearer, the solver proves it
    # sooner. agents_4 (0.55 %) in 6.9 CPU s instead of 20; agents_5 (0.85 %) is at 0.71 % after 30,
    # at 0.85 without parts
    gain: float = 0.25  # of the gap that groups of one size close, for larger ones to be tried


class Route(Record):
    """`routes/`: runs by beams over states and progress, plans near them.

    On `long/maze_1` (grids, 3.1 CPU s, proven) each number halved and doubled is flat where nothing
    else is said; `benchmarks/results/tuning.txt` has other missions for some.
    """

    glance: float = 1.0  # s of a plain solve ahead of it all; frugal_door_puzzle_N1_T20, which that
    # proves, took 2.3 times as long with half of it, doubled flat
    share: float = 0.3  # of the time that is left: for the glance, for a first plan
    seconds: float = 25.0  # for a first plan
    efforts: tuple[tuple[int, int, float, float], ...] = (
        (1500, 2, 0.0, 1.0), (400, 2, 0.3, 3.0), (1500, 2, 0.0, 3.0), (1500, 2, 0.3, 3.0),
        (1500, 3, 0.0, 1.0), (2000, 6, 0.2, 1.0), (3000, 4, 0.2, 3.0), (8000, 2, 0.0, 2.0),
        (8000, 4, 0.2, 2.0),
    )  # width, parts, miss, greed  # fmt: skip
    repair: tuple[float, ...] = (0.6, 2.0)  # cells: radius of a tube around a run
    repair_seconds: float = 3.0  # for a plan within a tube, around a run or the plan
    rough: float = 0.05  # gap of a repair
    better_share: float = 0.25  # of the time that is left
    better_seconds: float = 15.0
    first_radius: float = 0.05  # of the workspace
    least_radius: float = 0.01
    wider: float = 1.6
    bound_share: float = 0.8  # of the time that is left: for grids of `play.py`
    known_glance: float = 5.0  # s, where a plan is known; halved 0.85 the time of maze_1, which
    # without it took 3.4 times as long
    promise: float = 0.8  # of what a plan costs: visits whose first look bounds less are left to
    # the plain solve. Rounds have 0.93; frugal_narrow_passage_T40 0.74: proven in 11 s instead of a
    # gap of 30 % after 30
    worth: float = 0.05  # likewise of a plan that beams have found: horizon_200 has 0.005
    known_share: float = 0.4  # where a plan was known before
    bound_seconds: float = 60.0
    cuts: tuple[int, ...] = (1, 3, 6, 12)  # into which the fastest move is cut, at least
    beside: tuple[tuple[float, int], ...] = ((0.0, 0), (1.0, 1), (2.0, 2))
    # line gaps and steps: plans near a grid's cheapest run, found at once or not; each is the only
    # one to find any of maze_5 (the last), the door of tests (the middle), rover-1 within 0.1 s
    first_efforts: int = 2  # of beams ahead of a first plan by grids
    grid_share: float = 0.5  # of the time that is left, for that
    grid_beams: tuple[tuple[int, float], ...] = ((1000, 1.5), (10000, 1.5))
    # width, greed: rover-1 has its plan of 37.3 by the first, in 1 CPU s, as it has 300 wide,
    # a sibling not; doorpuzzle-1 and maze_5 their best by the second, in 1.1 and 1.4
    grid_agents: int = 6  # and at most so many
    growth: float = 2.0  # how much longer the next grid takes
    hardly: float = 2.0  # a grid is left out whose next has at most so many times its moves
    rooms: tuple[float, ...] = (0.0, 1.0)  # steps: how far from where ways have their visits
    guesses: int = 2  # ascents ahead of a first plan; 1: plan of rounds_40 14 % dearer, 4: flat
    climb_rounds: int = 12  # of each; 20: flat, 0.7 times as fast for rounds_100
    heat: float = 0.03  # of the gap
    cooler: float = 0.3  # where that rises no more
    coldest: float = 3e-4  # 0.03: 3.80 instead of 3.96 for frugal_door_puzzle_N2, 38.2 instead of
    # 38.4 for rounds_40


class Boxes(Record):
    """`routes/boxed.py`: the cheapest runs over boxes of one agent that pays for where it is."""

    glance: float = 1.0  # s of a plain solve ahead of it
    share: float = 0.4  # of the time that is left, for the glance and for boxes
    seconds: float = 60.0  # for boxes
    parts: tuple[int, ...] = (1, 2, 4)  # of the fastest step: how boxes are cut
    growth: float = 2.0  # how much longer the next cut takes
    near: tuple[tuple[float, int], ...] = (
        (1.0, 0), (1.0, 1), (2.0, 1), (2.0, 2), (4.0, 2),
    )  # fmt: skip
    # longest boxes and steps: tubes around a run in which plans are looked for
    near_seconds: float = 3.0
    better_share: float = 0.5  # of the time that is left, for plans near the plan


class Turns(Record):
    """`teams/turns.py`: first plans, one agent after the other."""

    share: float = 0.2  # of the time that is left, for one agent
    seconds: float = 10.0  # and at most
    all: float = 0.5  # of the time that is left, for all of them
    most: float = 120.0  # s
    crowd: int = 20  # agents; fewer soon have a plan by any runs: swarm_16 7 s, by good ones 11 s
    brief: float = 2.0  # s for a good run, before any run will do
    good: float = 0.1  # gap of one. 0.5: plan of swarm_32 28 % dearer and not earlier
    rough: float = 0.5  # gap: any run will do
    fine: float = 0.02  # gap of runs beside those that agents have alone
    beside: tuple[float, ...] = (0.05, 0.1, 0.2, 0.4)  # of the workspace: tubes around those. With
    # the first and (0.15) alone, two of the 8 of mastl_loop_N8 had none: 23 CPU s instead of 10
    partners: int = 4  # of an agent that finds no way, to be planned with it


class Near(Record):
    """`teams/neighbourhoods.py`: a few agents answer the others anew."""

    agents: int = 3  # free at once, at most
    gap: float = 0.01  # of an answer; halved 2.8 times the time of a team of four, doubled flat
    worth: float = 0.3  # gaps: an improvement that counts
    share: float = 0.2  # of the time that is left, for one answer
    seconds: float = 10.0  # and at most
    least: float = 2.0  # s, and at least
    effort: float = 0.6  # of the time that is left, for all of them
    pair: float = 1.0  # for two agents: as long as the best took; a whole model is hardly larger
    # than theirs, and the README's mission, proven in 4 CPU s, was searched for 9 without a limit
    moment: float = 0.5  # s, that it takes to begin with
    joint: float = 0.2  # of that, for a plan beside what agents do alone, after one in turn; it
    # brought mastl_loop_N8 and cover3_N8 nothing in twice the time
    bound: float = 0.1  # and where agents are bound to each other: what they do alone is no guide
    alone: float = 0.7  # to plan in turn near that: 8 agents of mastl_loop take 10 CPU s, 12.9
    # instead of 17 to 19 by neighbourhoods; with half of it they fail at the last
    beside: tuple[float, ...] = (0.02, 0.035, 0.06, 0.1)  # of the workspace: tubes around that
    crowd: float = 0.9  # and of a crowd, of which tubes around a plan are too large to search
    sides: float = 0.8  # of that, with most disjunctions decided as those runs do
    radius: float = 0.04  # of the workspace: the first tube around a plan; flat
    wider: float = 1.6
    narrowest: float = 0.005
    priced: float = 0.1  # and where links cost: 0.25 took 14 CPU s from the bounds of
    # links_a4_t8_c10_s1 for a plan 0.5 % cheaper, and found nothing for links_a6_t8_c10_s0
    most: float = 300.0  # s
    start_share: float = 0.25  # of the time that is left, for a plan near one that is none any more
    start_seconds: float = 2.0  # and at most


BRIEF, PAIR, TEAM, DESCENTS, DIVE = Brief(), Pair(), Team(), Descents(), Dive()
LONE, PARTS, ROUTES, BOXES, TURNS, NEAR = Lone(), Part(), Route(), Boxes(), Turns(), Near()
