"""How large the model of a mission would be, before anything is built.

The size counts states and inputs over the horizon, thrice, and the nodes of the unrolled formulas:
a node at each step at which it is needed, a window of w steps with w parts where it is needed once;
where steps share its parts, log2 w of them for a conjunction and a few for a disjunction or an
until (see `passes/unroll.py`).
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import ClassVar

from stlc.diagnostics import Diagnostic
from stlc.errors import MissionError
from stlc.ir.nodes import Always, Eventually, Node, Release, Timed, Until
from stlc.ir.requirement import Requirement
from stlc.ir.rewrite import postorder
from stlc.mission import Mission

MOST_PARTS = 500_000
"""Some minute to compile: an agent and an `until` over 5000 steps, 150 000 parts, took 12 s, and
32 agents that keep apart over 20 steps, 330 000 parts, as long."""

_STEP = 3
"""Parts that a state or input takes as long as at a step, by bounds propagation: an agent with six
of them over 10 000 steps takes 7 of the 9 s of that `until`; over 20 000 it was above 20 s."""

_SLIDING = 6  # parts of a disjunction over a window, two each for three nodes
_ENDLESS = 6  # parts of an until beside its window
_DIRECT = 8  # windows up to this many steps are written out


class TooLargeModel(Diagnostic):
    """The model of a mission would be larger than can be built in reasonable time.

    Its size counts the agents' states and inputs (thrice) and the parts of all formulas, at every
    step.
    `stlc compile --max-size N` and `stlc solve --max-size N` raise the limit.
    """

    code: ClassVar[str] = "E0806"
    title: ClassVar[str] = "the model would have {size:,} parts, more than {limit:,}"
    label: ClassVar[str] = "{own:,} of them are of this"
    help: ClassVar[str] = (
        "use a longer `step` or shorter intervals, or raise the limit: `--max-size {size}`"
    )
    size: int
    limit: int
    own: int


def check_size(mission: Mission, limit: int = MOST_PARTS) -> None:
    """Raise MissionError at what is largest where the model would be larger than the limit."""
    formulas = [(formula_size(r, mission.horizon), r.span) for r in mission.requirements]
    steps = mission.horizon + 1
    agents = [(steps * sum(a.dynamics.B.shape), a.span) for a in mission.agents.values()]
    size = sum(n for n, _ in formulas) + _STEP * sum(n for n, _ in agents)
    if size <= limit:
        return
    own, span = max(formulas + agents, key=lambda share: share[0])
    raise MissionError([TooLargeModel(span=span, size=size, limit=limit, own=own)])


def formula_size(requirement: Requirement, horizon: int) -> int:
    """Parts of one unrolled formula."""
    steps = needed_steps([requirement.formula], horizon)
    return sum(mask.bit_count() * _parts(node, mask, horizon) for node, mask in steps.items())


def needed_steps(roots: Sequence[Node], horizon: int) -> dict[Node, int]:
    """Steps within the horizon at which each node is needed by roots judged at step 0, as bits."""
    order = list(postorder(roots))
    within = (1 << (horizon + 1)) - 1
    steps = dict.fromkeys(order, 0) | dict.fromkeys(roots, 1)
    for node in reversed(order):
        here = steps[node]
        for child, first, last in _windows(node, horizon):
            steps[child] |= _spread(here, first, last) & within
        for t, child in enumerate(node.cases if isinstance(node, Timed) else ()):
            final = t == len(node.children) - 1
            steps[child] |= (here >> t << t) if final else here & (1 << t)
    return steps


def _windows(node: Node, horizon: int) -> list[tuple[Node, int, int]]:
    """Sub-formulas, with the first and last step after the present at which they are needed."""
    match node:
        case Timed():
            return []
        case Always(start=a, end=b) | Eventually(start=a, end=b):
            return [(node.arg, a, horizon if b is None else b)]
        case Until(start=a, end=b) | Release(start=a, end=b):
            end = horizon if b is None else b
            return [(node.left, 0, end), (node.right, a, end)]
    return [(child, 0, 0) for child in node.children]


def _spread(steps: int, first: int, last: int) -> int:
    """All t + k for t in `steps` and first <= k <= last, by doubling."""
    out, width, wanted = steps << first, 1, last - first + 1
    while width < wanted:
        more = min(width, wanted - width)
        out |= out << more
        width += more
    return out


def _parts(node: Node, steps: int, horizon: int) -> int:
    """Parts of a node at one of its steps."""
    if not isinstance(node, Always | Eventually | Until | Release):
        return max(len(node.children), 1) if not isinstance(node, Timed) else 1
    count = steps.bit_count()
    end = horizon if node.end is None else node.end
    width = max(end - node.start + 1, 1)
    shared = count > 1 and width > _DIRECT and node.end is not None
    if not shared and node.end is None:
        width = max(width - count // 2, 1)  # ever shorter towards the end
    if not shared:
        return width if isinstance(node, Always | Eventually) else 4 * width  # two pairs
    near = width.bit_length() if isinstance(node, Always | Release) else _SLIDING
    return near if isinstance(node, Always | Eventually) else near + _ENDLESS
