"""Why a requirement cannot hold, where interval analysis has proven it.

The blame is followed down the formula: into a conjunct or a step that fails, to an `eventually`
or a predicate whose static upper bound stays below the margin. Reach sets over a longer horizon
then tell from which step on it would be possible.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

from stlc.analysis.bounds import static_bounds
from stlc.analysis.doubles import RangeLost
from stlc.analysis.reach import reach
from stlc.analysis.unreachable import Unreachable
from stlc.channels import TableMemo
from stlc.ir.nodes import Always, And, Eventually, Link, Node, Until, walk
from stlc.ir.requirement import Requirement
from stlc.ir.rewrite import measures
from stlc.milp.compile import Compiled, CompileOptions, compile_mission
from stlc.mission import Bound, Channel, Mission
from stlc.source import Span

_TOLERANCE = 1e-6
_LONGER = 3  # times the horizon, for the earliest possible step


_STANDS = {
    Bound.WORST: "for whole cells",
    Bound.MEAN: "by the means of cells",
    Bound.CENTRE: "at the centres of cells",
}


FACES = (
    "Euclidean lengths are planned by polygons on the safe side, of 16 sides within 2 %: a run "
    "that keeps the true one may exist; `distance(a, b, 64)` or `speed <= 2 polygon 64` come nearer"
)


STEPS = (
    "what is `swept` is planned behind one face of each place for a step, and one that moves and "
    "changes its shape by the hull of both frames: a run that rounds a corner within a step may "
    "exist; a shorter `step` comes nearer"
)


def remedy(bound: Bound, finer: str = "") -> str:
    """What to try where cells, by their bound, are what rules a link out."""
    such = f" (`{finer}`)" if finer else ""
    other = ", or `bound mean`" if bound is Bound.WORST else ""
    return f"try a finer `partition`{such}{other}"


@dataclass(frozen=True, slots=True)
class Blame:
    """What fails: needed by step `deadline` (inclusive), possible from `earliest` (None: never).

    `by_faces`: polygons stand for lengths in it. `ahead`: it is about several steps together, so
    none is its earliest. `by_cells`: what stands for cells doesn't offer
    the link in time, though points of them may; then `finer` is a partition to try.
    """

    span: Span | None
    deadline: int
    earliest: int | None
    by_cells: Bound | None = None
    finer: str = ""
    by_faces: bool = False
    ahead: bool = False

    def __str__(self) -> str:
        """One sentence; a polygon that stands for a length is told of."""
        said = self._said()
        return f"{said}, by the polygon that stands for the length" if self.by_faces else said

    def _said(self) -> str:
        """The place, what fails there, and the deadline that is missed or the remedy."""
        where = f"{self.span}: " if self.span else ""
        what = f"`{self.span.text}`" if self.span else "a part of it"
        if self.by_cells is not None:
            return (
                f"{where}{what} is out of reach in time {_STANDS[self.by_cells]}: "
                f"{remedy(self.by_cells, self.finer)}; at points of these cells it may hold"
            )
        if self.ahead:
            return f"{where}{what} is out of reach"
        if self.earliest is None:
            return f"{where}{what} is out of reach at every step"
        if self.earliest <= self.deadline:
            return f"{where}{what} is out of reach together with what the others demand"
        return (
            f"{where}{what} is not possible before step {self.earliest}, "
            f"the deadline is step {self.deadline}"
        )


class Blamed(Unreachable):
    """A requirement is out of reach; `blame` says what of it, where in the file, and when."""

    def __init__(self, requirement: Requirement, blame: Blame) -> None:
        super().__init__(requirement, str(blame))
        self.span = requirement.span
        self.blame = blame


def compile_or_blame(
    mission: Mission, options: CompileOptions | None = None, *, hopeful: bool = False
) -> Compiled:
    """Compile; a requirement that is out of reach is looked into. `hopeful`: see CompileOptions.

    Raises as `compile_mission`, with Blamed for Unreachable.
    """
    options = replace(options or CompileOptions(), hopeful=hopeful)
    try:
        return compile_mission(mission, options)
    except Unreachable as error:
        name = error.requirement.name
        requirement = next(r for r in mission.requirements if r.name == name)
        tables = options.tables if options.tables is not None else {}
        blame = _Analysis(mission, requirement.margin, tables).blame(requirement)
        raise Blamed(requirement, blame) from None


@dataclass(frozen=True, slots=True)
class _Analysis:
    mission: Mission
    margin: float
    tables: TableMemo

    def blame(self, requirement: Requirement) -> Blame:
        """Follow the failing parts of the formula, which is judged from step 0."""
        node, first, last = requirement.formula, 0, 0
        while True:
            failing = self._failing(node, first)
            if failing is None:
                break
            node, first, last = failing
        if isinstance(node, Eventually):
            last = self.mission.horizon if node.end is None else first + node.end
        found = node.span or requirement.span
        by_cells = self._by_cells(node, first)
        finer = self._finer(node) if by_cells is not None else ""
        faces, ahead = measures(node), _looks_ahead(node)
        earliest = None if ahead else self._earliest(node, first)
        return Blame(found, last, earliest, by_cells, finer, faces, ahead)

    def _by_cells(self, node: Node, step: int) -> Bound | None:
        """The bound of a part that fails by its cells, but may hold at points of them."""
        link = next((n for n in walk(node) if isinstance(n, Link)), None)
        if link is None or not self._possible([(node, step)], self.mission, hopeful=True)[0]:
            return None
        return self._channel(link).predicate_bound

    def _channel(self, link: Link) -> Channel:
        return self.mission.channels[link.channel]

    def _finer(self, node: Node) -> str:
        """The grid of the first link's channel with cells of half the width."""
        link = next(n for n in walk(node) if isinstance(n, Link))
        shape = self._channel(link).partition.shape
        return "" if shape is None else "partition " + " x ".join(str(2 * n) for n in shape)

    def _failing(self, node: Node, step: int) -> tuple[Node, int, int] | None:
        """The part of a failing node that already fails, from which step, needed until when."""
        if node.norms is not None:
            return None  # a length is one predicate, whichever face of it fails
        match node:
            case And():
                return self._failing_conjunct(node, step)
            case Always(arg=arg, start=a, end=b):
                end = self.mission.horizon if b is None else step + b
                parts = [(arg, t, t) for t in range(step + a, end + 1)]
            case Until(right=right, start=a, end=b):
                parts = [(Eventually(right, a, b, span=right.span), step, step)]
            case _:
                return None
        possible = self._possible([(part, t) for part, t, _ in parts], self.mission)
        return next((p for p, may in zip(parts, possible, strict=True) if not may), None)

    def _failing_conjunct(self, node: And, step: int) -> tuple[Node, int, int] | None:
        """The same of a conjunction, down through conjunctions in it, which are judged at once."""
        within: dict[Node, None] = {}
        todo: list[Node] = list(node.args)
        while todo:
            part = todo.pop()
            if part not in within:
                within[part] = None
                todo += part.args if isinstance(part, And) else ()
        judged = self._possible([(part, step) for part in within], self.mission)
        possible = dict(zip(within, judged, strict=True))
        found: Node | None = None
        around: Node = node
        while isinstance(around, And):
            failing = next((arg for arg in around.args if not possible[arg]), None)
            if failing is None:
                break
            found = around = failing
        return None if found is None else (found, step, step)

    def _earliest(self, node: Node, step: int) -> int | None:
        body = node.arg if isinstance(node, Eventually) else node
        longer = replace(self.mission, horizon=_LONGER * self.mission.horizon + 20)
        try:
            return self._first_possible(body, step, longer)
        except RangeLost:  # later than doubles can follow it
            return self._first_possible(body, step, self.mission)

    def _first_possible(self, body: Node, step: int, mission: Mission) -> int | None:
        steps = range(step, mission.horizon + 1)
        possible = self._possible([(body, t) for t in steps], mission)
        return next((t for t, may in zip(steps, possible, strict=True) if may), None)

    def _possible(
        self, parts: Sequence[tuple[Node, int]], mission: Mission, *, hopeful: bool = False
    ) -> list[bool]:
        """Whether the static upper bound of each part at its step reaches the margin."""
        from stlc.analysis.link_tables import LinkTables
        from stlc.passes import cse, horizon, nnf, unroll
        from stlc.passes.base import Program

        last = horizon.last_steps(tuple(p for p, _ in parts), mission.horizon)
        judged = [k for k, (part, step) in enumerate(parts) if last[part] >= step]
        asked = tuple(
            Requirement(str(k), Eventually(parts[k][0], parts[k][1], parts[k][1])) for k in judged
        )
        program = Program(asked, mission, reach(mission), LinkTables(mission, hopeful, self.tables))
        for step in (nnf, horizon, cse, unroll):
            program = step.run(program)
        bounds = static_bounds(program.formulas, program.ranges, None, program.link_bounds)
        best = dict(zip(judged, (bounds[f][1] for f in program.formulas), strict=True))
        return [best.get(k, -1e300) >= self.margin - _TOLERANCE for k in range(len(parts))]


def _looks_ahead(node: Node) -> bool:
    """Whether it counts links of later steps."""
    return any(isinstance(n, Link) and n.shift > 0 for n in walk(node))
