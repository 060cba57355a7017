"""Motion between samples, from the mission's dynamics and the run's numbers alone.

Between two samples a state follows x' = A x + B u + drift with the constant input of the step:
x(s) = exp(M s) (x, u, 1). A step is cut into equal pieces, and on each the motion is a parabola
through its ends and its middle. The parabola's error is at most sqrt(3)/216 h^3 max |x'''|, and
|x'''(s + r)| <= |M^3 z| + |M^3| (exp(|M| h) - 1) |z| on a piece of length h that starts at
z = (x(s), u, 1). Integrators move on parabolas, so one piece of theirs is exact.
A disturbed agent's path is its plan's, and `sways` says how far off it may be (`sway.py`).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from stlc.dynamics import Dynamics, Flow
from stlc.matrices import exponential
from stlc.mission import Agent, Mission
from stlc.plan import Run
from stlc.verify.sway import Parts, Quadratic, Sway, quadratic
from stlc.verify.tubes import radius

Array = NDArray[np.float64]

MOST_PIECES = 4096
FINE = 2e-7  # m, or the unit of a state: an error that the tolerance of 1e-6 has room for
_BEND = np.sqrt(3.0) / 216.0


@dataclass(frozen=True, slots=True, eq=False)
class Path:
    """Motion c0 + c1 s + c2 s^2, s in [0, 1], over every piece of every step.

    Each (T+1) * pieces rows of `width` values: places (2 or 3) [m], or all states of an agent. The
    truth lies within `error` (rows,) of it in space, or (rows, n) in each state. The pieces of
    the last step stay where the run ends. `sways` are what disturbances may add to that.
    """

    c0: Array
    c1: Array
    c2: Array
    pieces: int = 1
    error: Array | None = None
    sways: tuple[Sway, ...] = ()

    def __len__(self) -> int:
        return len(self.c0) // self.pieces

    @property
    def room(self) -> Array:
        """`error`, or zeros (rows,)."""
        return np.zeros(len(self.c0)) if self.error is None else self.error

    def at(self, steps: Array) -> Array:
        """Places (K, width) at fractional steps (K,) in [0, T]."""
        along = steps * self.pieces
        row = np.clip(np.floor(along).astype(np.intp), 0, len(self.c0) - 1)
        s = (along - row)[:, None]
        return np.asarray(self.c0[row] + s * (self.c1[row] + s * self.c2[row]))

    def minus(self, other: Path) -> Path:
        """The relative motion of two paths in as many pieces."""
        ends = self.c0 - other.c0, self.c1 - other.c1, self.c2 - other.c2
        return Path(*ends, self.pieces, self.room + other.room, self.sways + other.sways)

    def swayed(self, rows: Array) -> Quadratic:
        """Coefficients (steps * pieces, F) of 1, s and s^2 of the most by which rows (F, width) @
        places may be off."""
        none = np.zeros((3, len(self.c0), len(rows)))
        return quadratic(sum((sway.support(rows) for sway in self.sways), none))

    @property
    def reach(self) -> Array:
        """(3, steps * pieces): how far in space the truth may be off by disturbances, at Bezier
        points."""
        none = np.zeros((3, len(self.c0)))
        width = self.c0.shape[1]
        found = [np.linalg.norm(sway.support(np.eye(width)), axis=2) for sway in self.sways]
        return sum(found, none)

    @property
    def plane(self) -> Path:
        """The motion without heights."""
        if self.c0.shape[1] == 2:
            return self
        c0, c1, c2 = (c[:, :2] for c in (self.c0, self.c1, self.c2))
        flat = tuple(sway.mapped(np.eye(2)) for sway in self.sways)
        return Path(c0, c1, c2, self.pieces, self.error, flat)

    def mapped(self, rows: Array) -> Path:
        """The motion of rows @ state, for rows of length at most 1 in space."""
        error = None if self.error is None else _mapped_error(self.error, rows)
        parts = self.c0 @ rows.T, self.c1 @ rows.T, self.c2 @ rows.T
        return Path(*parts, self.pieces, error, tuple(sway.mapped(rows) for sway in self.sways))


def _mapped_error(error: Array, rows: Array) -> Array:
    """Error (steps,) in the plane of rows @ state; a weight of zero takes even an infinite one."""
    parts = np.where(rows == 0.0, 0.0, error[:, None] * np.abs(np.where(rows == 0.0, 1.0, rows)))
    return np.asarray(np.linalg.norm(parts.sum(axis=2), axis=1), dtype=np.float64)


def is_known(model: Dynamics) -> bool:
    """Whether the mission says how an agent moves between samples; else the chord is judged."""
    return model.flow is not None or model.straight


def state_paths(mission: Mission, runs: Mapping[str, Run], past: int = 0) -> dict[str, Path]:
    """Motion of every agent's states, all in as many pieces a step; up to step `past` agents are
    where the run says."""
    agents, step = mission.agents, mission.step
    each = [least_pieces(agents[name], run, step, past) for name, run in runs.items()]
    pieces = max(each, default=1)
    return {
        name: _pushed(state_path(agents[name], run, step, pieces), agents[name], run, step, past)
        for name, run in runs.items()
    }


def paths(mission: Mission, runs: Mapping[str, Run]) -> dict[str, Path]:
    """Motion of every agent that is somewhere, and of the stations, which rest."""
    return placed(mission, state_paths(mission, runs))


def placed(mission: Mission, states: Mapping[str, Path]) -> dict[str, Path]:
    """`paths`, from the motion of all states; in space where any agent flies."""
    found = {}
    for name, path in states.items():
        model = mission.agents[name].dynamics
        rows = model.space if mission.aerial else model.position
        if rows is not None:
            found[name] = _with_room(path.mapped(rows), mission.agents[name])
    pieces = next((path.pieces for path in states.values()), 1)
    for name, station in mission.stations.items():
        count = (mission.horizon + 1) * pieces
        place = np.tile(station.place[: 3 if mission.aerial else 2], (count, 1))
        found[name] = Path(place, np.zeros_like(place), np.zeros_like(place), pieces)
    return found


def _with_room(path: Path, agent: Agent) -> Path:
    """The path of a robot is that of its plan, and it is anywhere in its tube."""
    if agent.robot is None:
        return path
    return replace(path, error=path.room + radius(agent.robot))


def path_of(agent: Agent, run: Run, step: float) -> Path:
    """The motion of an agent that has a position."""
    assert agent.dynamics.position is not None
    pieces = least_pieces(agent, run, step)
    return state_path(agent, run, step, pieces).mapped(agent.dynamics.position)


def least_pieces(agent: Agent, run: Run, step: float, past: int = 0) -> int:
    """The least power of two of pieces at which the error is fine for what positions ask."""
    flow, pieces = agent.dynamics.flow, 1
    if flow is None or not len(run.inputs):
        return 1
    pushes = _pushes(agent, len(run.inputs) - past)
    while pieces < MOST_PIECES:
        errors = _errors(flow, run, step, pieces).max(initial=0.0)
        if pushes is not None:
            errors += _errors(_undrifted(flow), pushes[1], step, pieces).sum(axis=0).max()
        if not errors > FINE:
            break
        pieces *= 2
    return pieces


def _undrifted(flow: Flow) -> Flow:
    return replace(flow, drift=np.zeros_like(flow.drift))


def _pushes(agent: Agent, ages: int) -> tuple[Parts, Run] | None:
    """What pushes do to a disturbed agent, and that as a run, a step for each; None for others."""
    if agent.tube is None or ages <= 0:
        return None
    parts, model = Parts.of(agent, ages), agent.dynamics
    first, last, inputs = parts.moves()
    states = np.vstack([first, last[-1:]])
    names = model.states, model.inputs, model.state_units, model.input_units
    return parts, Run(states, inputs, *names)


def _pushed(path: Path, agent: Agent, run: Run, step: float, past: int) -> Path:
    """The path of an agent's states with how far its disturbance may put it off."""
    found, flow, count = (
        _pushes(agent, len(run.inputs) - past),
        agent.dynamics.flow,
        2 * path.pieces,
    )
    if found is None:
        return path
    parts, pushes = found
    if flow is None:
        first, last, _ = parts.moves()
        share = np.linspace(0.0, 1.0, count + 1)[:, None]
        ends = first[:, None] + share * (last - first)[:, None]
        return replace(path, sways=(Sway.of(agent.dynamics, parts, ends, past),))
    ends = _samples(_undrifted(flow), pushes, step, count)
    missed = _errors(_undrifted(flow), pushes, step, path.pieces).sum(axis=0).max(axis=0)
    error = (np.zeros_like(path.c0) if path.error is None else path.error) + missed
    sways = (Sway.of(agent.dynamics, parts, ends, past),)
    return replace(path, error=error if missed.any() else path.error, sways=sways)


def state_path(agent: Agent, run: Run, step: float, pieces: int) -> Path:
    """The motion of all states over (T+1) * pieces rows; of one that overflows between samples
    the chords, off by anything."""
    flow = agent.dynamics.flow
    if flow is None or not len(run.inputs):
        return _chords(run, pieces)
    along = _samples(flow, run, step, 2 * pieces)
    first, middle, last = along[:, :-2:2], along[:, 1::2], along[:, 2::2]
    with np.errstate(all="ignore"):
        c1, c2 = 4.0 * middle - 3.0 * first - last, 2.0 * (first + last) - 4.0 * middle
    error = _errors(flow, run, step, pieces)
    rest = np.zeros((pieces, run.states.shape[1]))
    stay = np.repeat(run.states[-1:], pieces, axis=0)
    c0, c1, c2, error = (
        np.concatenate([_rows(a), b])
        for a, b in ((first, stay), (c1, rest), (c2, rest), (error, rest))
    )
    if not all(np.isfinite(c).all() for c in (c0, c1, c2)):
        return replace(_chords(run, pieces), error=np.full_like(error, np.inf))
    return Path(c0, c1, c2, pieces, error)


def _rows(values: Array) -> Array:
    return values.reshape(-1, values.shape[-1])


def _chords(run: Run, pieces: int) -> Path:
    """Straight lines from sample to sample."""
    move = np.vstack([np.diff(run.states, axis=0), np.zeros((1, run.states.shape[1]))])
    share = np.arange(pieces)[:, None] / pieces
    start = _rows(run.states[:, None] + share * move[:, None])
    along = np.repeat(move / pieces, pieces, axis=0)
    return Path(start, along, np.zeros_like(along), pieces)


def _augmented(flow: Flow) -> Array:
    n, m = flow.B.shape
    matrix = np.zeros((n + m + 1, n + m + 1))
    matrix[:n] = np.column_stack([flow.A, flow.B, flow.drift])
    return matrix


def _samples(flow: Flow, run: Run, step: float, count: int) -> Array:
    """States (T, count + 1, n) at equal times of each step, from its start and input alone."""
    n = run.states.shape[1]
    matrix = exponential(_augmented(flow) * (step / count))
    z = np.column_stack([run.states[:-1], run.inputs, np.ones(len(run.inputs))])
    out = np.empty((len(z), count + 1, n))
    with np.errstate(all="ignore"):  # `state_path` sees what isn't finite
        for k in range(count + 1):
            out[:, k] = z[:, :n]
            z = z @ matrix.T
    return out


def _errors(flow: Flow, run: Run, step: float, pieces: int) -> Array:
    """Bound (T, pieces, n) on how far each piece's parabola is from the motion."""
    n, h = run.states.shape[1], step / pieces
    matrix = _augmented(flow)
    with np.errstate(all="ignore"):
        third = np.linalg.matrix_power(matrix, 3)[:n]
        if not third.any():
            return np.zeros((len(run.inputs), pieces, n))
        grown = np.abs(third) @ (exponential(np.abs(matrix) * h) - np.eye(len(matrix)))
    grown[np.isnan(grown)] = np.inf  # 0 times what overflows: no bound
    starts = _samples(flow, run, step, pieces)[:, :-1]
    fixed = np.column_stack([run.inputs, np.ones(len(run.inputs))])
    z = np.concatenate([starts, np.repeat(fixed[:, None], pieces, axis=1)], axis=2)
    with np.errstate(all="ignore"):
        found = np.asarray(_BEND * h**3 * (np.abs(z @ third.T) + np.abs(z) @ grown.T))
    return np.where(np.isnan(found), np.inf, found)
