"""Plans as JSON. Numbers round-trip exactly; infinite robustness is "inf" or "-inf", NaN null."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from dataclasses import asdict
from typing import Any

import numpy as np

from stlc.plan import FORMAT_VERSION, LinkSeries, Plan, Run
from stlc.radio.learned import Learned


def to_json(plan: Plan) -> str:
    """The plan as one JSON object with a line for each row of numbers."""
    learned = {name: _learned(what) for name, what in plan.learned.items()}
    return layout(
        {
            "format": "stlc plan",
            "version": FORMAT_VERSION,
            "mission": plan.mission,
            "sha256": plan.sha256,
            "params": dict(plan.params),
            "grids": {name: list(shape) for name, shape in plan.grids.items()},
            "step": plan.step,
            "horizon": plan.horizon,
            **({"executed": plan.executed} if plan.executed else {}),
            **({"learned": learned} if learned else {}),
            "solve": plain(asdict(plan.solve)),
            "requirements": [
                {"name": r.name, "robustness": _number(r.robustness), "margin": r.margin}
                for r in plan.requirements
            ],
            "agents": {name: _run(run) for name, run in plan.runs.items()},
            "links": [_link(series) for series in plan.links],
            "certificate": plain(plan.certificate.as_dict()),
        }
    )


def _learned(what: Learned) -> dict[str, Any]:
    """Samples in rows: their link [m], then the strength [dBm]."""
    found: dict[str, Any] = {"samples": np.column_stack([what.links, what.rssi]).tolist()}
    if what.parameters is not None:
        found["parameters"] = plain(asdict(what.parameters))
    return found


def _run(run: Run) -> dict[str, Any]:
    return {
        "state_names": list(run.state_names),
        "state_units": list(run.state_units),
        "input_names": list(run.input_names),
        "input_units": list(run.input_units),
        "states": run.states.tolist(),
        "inputs": run.inputs.tolist(),
        **({"headings": {str(t): a for t, a in run.headings.items()}} if run.headings else {}),
    }


def _link(series: LinkSeries) -> dict[str, Any]:
    values = {k: [_number(x) for x in v.tolist()] for k, v in series.values.items()}
    pair = [series.sender, series.receiver]
    return {"channel": series.channel, "pair": pair, "values": values}


def _number(value: Any) -> Any:
    if not isinstance(value, float) or math.isfinite(value):
        return value
    return None if math.isnan(value) else str(value)


def plain(value: Any) -> Any:
    """A value as JSON holds it: infinities as "inf" and "-inf", NaN as null."""
    match value:
        case Mapping():
            return {str(k): plain(v) for k, v in value.items()}
        case list() | tuple():
            return [plain(v) for v in value]
        case np.generic():
            return _number(value.item())
        case _:
            return _number(value)


def layout(value: Any, indent: str = "") -> str:
    """Indented JSON whose lists of plain values stay on one line."""
    inner = indent + "  "
    if isinstance(value, dict) and value:
        items = [f"{inner}{json.dumps(k)}: {layout(v, inner)}" for k, v in value.items()]
        body, ends = ",\n".join(items), "{}"
    elif isinstance(value, list) and any(isinstance(v, list | dict) for v in value):
        body, ends = ",\n".join(inner + layout(v, inner) for v in value), "[]"
    else:
        return json.dumps(value, allow_nan=False)
    last = "" if indent else "\n"
    return f"{ends[0]}\n{body}\n{indent}{ends[1]}{last}"
