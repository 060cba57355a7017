"""Plans read from JSON; whatever is missing or of another type is named with its place."""

from __future__ import annotations

import json
import math
import os
from typing import Any

import numpy as np
from numpy.typing import NDArray

from stlc.certificate import Certificate, Checked, Claim
from stlc.errors import UsageError
from stlc.inputs import InputError, read_input
from stlc.plan import FORMAT_VERSION, LinkSeries, Plan, RequirementValue, Run, SolveInfo
from stlc.plan_place import Place
from stlc.radio.learned import Learned, Parameters
from stlc.sense import Sense
from stlc.violation import Violations

Array = NDArray[np.float64]
_MOST_CELLS = 200  # along an axis: a plan can't ask for tables beyond memory


def read(path: str | os.PathLike[str]) -> Plan:
    """Read a plan file. Raises UsageError, with the place, when it isn't one."""
    name = os.fspath(path)
    try:
        data = read_input(path)
    except InputError as error:
        raise UsageError(f"{name}: {error}") from None
    return parse(data, name)


def parse(data: bytes | str, name: str = "plan") -> Plan:
    """A plan from JSON text. Raises UsageError, with the place, when it isn't one."""
    try:
        value = json.loads(data, parse_constant=_refuse_constant, object_pairs_hook=_once_each)
    except UnicodeDecodeError:
        raise UsageError(f"{name}: not a plan: the file is not UTF-8 text") from None
    except json.JSONDecodeError as error:
        where = f"{name}:{error.lineno}:{error.colno}"
        raise UsageError(f"{where}: not a plan: {error.msg.lower()}") from None
    except RecursionError:
        raise UsageError(f"{name}: not a plan: it is nested too deeply") from None
    except ValueError as error:
        raise UsageError(f"{name}: not a plan: {error}") from None
    return _plan(Place(name, "", value))


def _refuse_constant(word: str) -> float:
    raise ValueError(f"{word} is no number of JSON")


def _once_each(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    """An object's members; JSON leaves open which of two with one name counts."""
    found = dict(pairs)
    if len(found) < len(pairs):
        names = [name for name, _ in pairs]
        twice = next(name for name in names if names.count(name) > 1)
        raise ValueError(f'"{twice}" is given twice in one object')
    return found


def _plan(top: Place) -> Plan:
    """A plan from its JSON; UsageError names the place of what is missing or of another type."""
    if not top.has("format") or top["format"].value != "stlc plan":
        raise top.fail('an object with "format": "stlc plan"')
    version = top["version"]
    if version.value != FORMAT_VERSION:
        raise version.fail(f"version {FORMAT_VERSION}, which is all that this stlc reads")
    step, horizon = top["step"], top["horizon"]
    if step.number() <= 0:
        raise step.fail("a number of seconds above 0")
    if horizon.number() < 0 or not isinstance(horizon.value, int):
        raise horizon.fail("a whole number of steps")
    length = int(horizon.value)
    return Plan(
        top["mission"].text(),
        top["sha256"].text(),
        step.number(),
        length,
        {name: _read_run(place, length) for name, place in top["agents"].fields().items()},
        _read_solve(top["solve"]),
        tuple(_read_requirement(p) for p in top["requirements"].items()),
        tuple(_read_link(p, length) for p in top["links"].items()),
        _read_certificate(top["certificate"]),
        {k: p.text() for k, p in top["params"].fields().items()} if top.has("params") else {},
        {k: _grid(p) for k, p in top["grids"].fields().items()} if top.has("grids") else {},
        _executed(top["executed"], length) if top.has("executed") else 0,
        {k: _learned(p) for k, p in top["learned"].fields().items()} if top.has("learned") else {},
    )


def _executed(place: Place, horizon: int) -> int:
    """How many steps were carried out before the plan was made."""
    count = place.value
    if not isinstance(count, int) or isinstance(count, bool) or not 0 <= count <= horizon:
        raise place.fail(f"a whole number of steps up to {horizon}")
    return count


def _learned(place: Place) -> Learned:
    """Samples that a channel was conditioned on, and parameters where it was fitted anew."""
    rows = place["samples"].items()
    width = len(rows[0].items()) if rows else 0
    if width not in (5, 7):
        raise place["samples"].fail("rows of 4 or 6 coordinates and a strength")
    table = place["samples"].array(len(rows), width)
    found = place["parameters"] if place.has("parameters") else None
    if found is None:
        return Learned(table[:, :-1], table[:, -1])
    names = ("l0", "exponent", "fading", "deviation", "shadowing", "length")
    losses = tuple(loss.number() for loss in found["losses"].items())
    figures = Parameters(**{name: found[name].number() for name in names}, losses=losses)
    return Learned(table[:, :-1], table[:, -1], figures)


def _grid(place: Place) -> tuple[int, ...]:
    """Cells along each axis of a channel that chose them."""
    counts = [cell.value for cell in place.items()]
    whole = all(isinstance(n, int) and 1 <= n <= _MOST_CELLS for n in counts)
    if len(counts) not in (2, 3) or not whole:
        raise place.fail(f"two or three whole numbers of cells from 1 to {_MOST_CELLS}")
    return tuple(counts)


def _read_run(place: Place, horizon: int) -> Run:
    """One agent's run; arrays have the shapes that horizon and names ask for."""
    states, inputs = place["state_names"].texts(), place["input_names"].texts()
    units = place["state_units"].texts(), place["input_units"].texts()
    for names, of, key in ((states, units[0], "state_units"), (inputs, units[1], "input_units")):
        if len(names) != len(of):
            raise place[key].fail(f"{len(names)} units, one for each name")
    return Run(
        place["states"].array(horizon + 1, len(states)),
        place["inputs"].array(horizon, len(inputs)),
        states,
        inputs,
        *units,
        _headings(place["headings"], horizon) if place.has("headings") else {},
    )


def _headings(place: Place, horizon: int) -> dict[int, float]:
    """Headings [rad] of a robot that were measured, by step."""
    found = {}
    for key, angle in place.fields().items():
        if not key.isdecimal() or int(key) > horizon:
            raise place.fail(f"steps from 0 to {horizon}, not {key!r}")
        found[int(key)] = angle.number()
    return found


def _read_solve(place: Place) -> SolveInfo:
    words = {k: place[k].text() for k in ("status", "backend", "solver", "encoding")}
    figures = {k: place[k].optional() for k in ("objective", "bound", "gap")}
    seconds = {k: p.number() for k, p in place["seconds"].fields().items()}
    return SolveInfo(
        words["status"], figures["objective"], figures["bound"], figures["gap"],
        words["backend"], words["solver"], words["encoding"], seconds, _read_sense(place),
    )  # fmt: skip


def _read_certificate(place: Place) -> Certificate:
    """What was found of a plan; nothing of it need be there."""
    given = place.fields()
    verified = given["verified"].truth() if "verified" in given else None
    notes = given["notes"].texts() if "notes" in given else ()
    return Certificate(_read_checked(place) if "claim" in given else None, verified, notes)


def _read_checked(place: Place) -> Checked:
    """A point held against the model; `place` is the certificate's."""
    claim = place["claim"]
    said = Claim(
        claim["status"].text(), claim["objective"].optional(), claim["solver"].text(),
        claim["solver_version"].text(),
    )  # fmt: skip
    figures = [place[k].optional() for k in ("objective", "bound", "gap")]
    before, after = (_read_violations(place[f"violations_{k}"]) for k in ("before", "after"))
    return Checked(
        place["status"].text(), figures[0], figures[1], figures[2], place["tolerance"].number(),
        said, before, after, place["continuous_part_solved_again"].truth(),
        place["warnings"].texts(),
    )  # fmt: skip


def _read_violations(place: Place) -> Violations | None:
    """Largest violations, None where there was no point."""
    if place.value is None:
        return None
    rows, bounds, integrality, *relative = (
        place[k].number()
        for k in ("rows", "bounds", "integrality", "rows_relative", "bounds_relative")
    )
    worst = [
        None if place[k].value is None else place[k].text()
        for k in ("worst_row", "worst_column", "worst_integer")
    ]
    return Violations(rows, bounds, integrality, relative[0], relative[1], *worst)


def _read_sense(place: Place) -> Sense:
    """Plans that don't say so are minimised, whatever their mission."""
    if not place.has("sense"):
        return Sense.MINIMIZE
    word = place["sense"].text()
    if word not in tuple(Sense):
        raise place["sense"].fail(" or ".join(f"{s.value!r}" for s in Sense))
    return Sense(word)


def _read_requirement(place: Place) -> RequirementValue:
    value = place["robustness"].optional()
    return RequirementValue(place["name"].text(), value, place["margin"].number())


def _read_link(place: Place, horizon: int) -> LinkSeries:
    pair = place["pair"].texts()
    if len(pair) != 2:
        raise place["pair"].fail("two names")
    values = {key: _series(p, horizon) for key, p in place["values"].fields().items()}
    return LinkSeries(place["channel"].text(), pair[0], pair[1], values)


def _series(place: Place, horizon: int) -> Array:
    cells = [item.optional() for item in place.items()]
    if len(cells) != horizon + 1:
        raise place.fail(f"{horizon + 1} numbers, not {len(cells)}")
    return np.array([math.nan if c is None else c for c in cells])
