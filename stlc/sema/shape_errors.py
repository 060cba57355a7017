"""Mistakes about shapes, matrices and places (E04xx)."""

from __future__ import annotations

from typing import ClassVar

from stlc.diagnostics import Diagnostic


class BadPolygon(Diagnostic):
    """A polygon that isn't one: fewer than three corners, no area, or edges that cross."""

    code: ClassVar[str] = "E0401"
    title: ClassVar[str] = "this is not a simple polygon: {problem}"
    label: ClassVar[str] = "{problem}"
    help: ClassVar[str] = "list the corners in order, three or more, without crossing edges"
    problem: str


class EmptyBox(Diagnostic):
    """A box whose lower end isn't below its upper end."""

    code: ClassVar[str] = "E0402"
    title: ClassVar[str] = "the box is empty along {axis}: {low:g} is not below {high:g}"
    label: ClassVar[str] = "empty side"
    help: ClassVar[str] = "write the smaller number first"
    axis: str
    low: float
    high: float


class NotConvex(Diagnostic):
    """The workspace must be one convex polygon.

    Every position stays inside the workspace, which is a conjunction of half-planes. Cut out what
    is not allowed with obstacles.
    """

    code: ClassVar[str] = "E0403"
    title: ClassVar[str] = "the workspace is not convex"
    label: ClassVar[str] = "has a re-entrant corner, a hole or several parts"
    help: ClassVar[str] = "use its convex hull, and an obstacle for each part cut out"


class OutsideWorkspace(Diagnostic):
    """A region or a station lies wholly outside the workspace, where no agent can ever be."""

    code: ClassVar[str] = "E0404"
    title: ClassVar[str] = "{what} `{name}` lies outside the workspace"
    label: ClassVar[str] = "no point of it is reachable"
    help: ClassVar[str] = "move it, or make the workspace larger"
    what: str
    name: str


class StartMisplaced(Diagnostic):
    """An agent's start is outside the workspace or outside its own bounds."""

    code: ClassVar[str] = "E0405"
    title: ClassVar[str] = "agent `{name}` starts {problem}"
    label: ClassVar[str] = "starts here"
    help: ClassVar[str] = "move the start, or widen the bounds"
    name: str
    problem: str


class StartInObstacle(Diagnostic):
    """An agent starts inside an obstacle (inflated as declared) that it must avoid from step 0."""

    code: ClassVar[str] = "E0406"
    title: ClassVar[str] = "agent `{name}` starts inside obstacle `{obstacle}`"
    label: ClassVar[str] = "starts here"
    help: ClassVar[str] = "move the start, or require avoidance from a later step: `always[1, n]`"
    name: str
    obstacle: str


class MissingStart(Diagnostic):
    """An agent has no `start`."""

    code: ClassVar[str] = "E0407"
    title: ClassVar[str] = "agent `{name}` has no start"
    label: ClassVar[str] = "where does it start?"
    help: ClassVar[str] = "add `start {usage}` to its block"
    name: str
    usage: str


class MatrixShape(Diagnostic):
    """A matrix or vector has the wrong number of rows or columns.

    With n states and m inputs, A is n x n, B is n x m, c has n entries.
    """

    code: ClassVar[str] = "E0408"
    title: ClassVar[str] = "`{name}` is {found}, expected {expected}"
    label: ClassVar[str] = "{found}"
    help: ClassVar[str] = "{hint}"
    name: str
    found: str
    expected: str
    hint: str = "with n states and m inputs A is n x n, B is n x m, c has n entries"


class MissingMatrix(Diagnostic):
    """Dynamics give neither a known kind nor the matrices A and B."""

    code: ClassVar[str] = "E0409"
    title: ClassVar[str] = "dynamics `{name}` has no `{matrix}`"
    label: ClassVar[str] = "incomplete"
    help: ClassVar[str] = (
        "use `double_integrator` or another of the named kinds, or give the matrices A and B"
    )
    name: str
    matrix: str


class EmptyBound(Diagnostic):
    """A bound leaves no value: its lower end is above its upper end, or a limit is negative."""

    code: ClassVar[str] = "E0410"
    title: ClassVar[str] = "no value satisfies this bound"
    label: ClassVar[str] = "{problem}"
    help: ClassVar[str] = "{hint}"
    problem: str
    hint: str = "the lower end must not be above the upper end"


class BadGeoJson(Diagnostic):
    """A GeoJSON file has no polygon that can be used.

    Coordinates are metres in a local frame. Polygon and MultiPolygon geometries are read, from a
    geometry, a Feature or a FeatureCollection; `feature "name"` picks one by its `name` or `id`.
    """

    code: ClassVar[str] = "E0411"
    title: ClassVar[str] = "`{path}` gives no usable polygon"
    label: ClassVar[str] = "{problem}"
    help: ClassVar[str] = "{hint}"
    path: str
    problem: str
    hint: str = "the file needs a Polygon or MultiPolygon with coordinates in metres"


class NoSwept(Diagnostic):
    """`swept` is asked of what has no known motion between steps.

    Named integrators and `continuous` matrices say how a state moves within a step. Discrete
    matrices do so through their logarithm, if they have a real one, or with `straight`. Modes far
    faster than a step can't be followed. A continuous workspace asks the same of every agent.
    """

    code: ClassVar[str] = "E0412"
    title: ClassVar[str] = "`swept` has no meaning here: {problem}"
    label: ClassVar[str] = "no motion between steps"
    help: ClassVar[str] = "{hint}"
    problem: str
    hint: str = "leave out `swept`, or apply it to `outside`, `in` or `separation(..) >=`"


class FrozenAtStart(Diagnostic):
    """With `turn_rate literal` an agent that starts at rest can never move.

    The paper's constraint ||u|| <= (u_max / v_max) ||v|| forces u = 0 while v = 0. `turn_rate on`
    adds the branch `at rest`, in which the input is free.
    """

    code: ClassVar[str] = "E0413"
    title: ClassVar[str] = "agent `{name}` starts at rest and `turn_rate literal` keeps it there"
    label: ClassVar[str] = "never moves"
    help: ClassVar[str] = "use `turn_rate on`, or give a start velocity"
    name: str


class TurnRateNeeds(Diagnostic):
    """`turn_rate` needs a velocity, a speed limit and an input limit, and two inputs."""

    code: ClassVar[str] = "E0414"
    title: ClassVar[str] = "`turn_rate` needs {what}"
    label: ClassVar[str] = "incomplete"
    help: ClassVar[str] = "add `speed <= ..` and `control |u| <= ..` to an agent with a velocity"
    what: str


class FarAway(Diagnostic):
    """A coordinate so large that doubles can't hold it to a fraction of a millimetre.

    Solvers keep constraints to 1e-6; shapes a million kilometres from the origin lose that.
    """

    code: ClassVar[str] = "E0416"
    title: ClassVar[str] = "the coordinate {value:g} m is too large"
    label: ClassVar[str] = "beyond {limit:g} m"
    help: ClassVar[str] = "put the origin of the mission near its workspace"
    value: float
    limit: float
