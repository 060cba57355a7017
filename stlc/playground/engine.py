"""What the page asks for: JSON in, JSON out, and never an exception for any text.

Which packages there are decides what can be done: the text is parsed and laid out by Lark alone,
checking what it means takes NumPy and Shapely, solving SciPy and HiGHS as well.
"""

from __future__ import annotations

import json
from collections.abc import Callable
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

from stlc.diagnostics import Diagnostic, Severity
from stlc.errors import MissionError, StlcError
from stlc.render.json import as_dict
from stlc.source import Source
from stlc.syntax.parse import parse
from stlc.syntax.printer import format_file

if TYPE_CHECKING:
    from collections.abc import Iterable

    from stlc.mission import Mission

NAME: Final = "mission.stl"
_MEANING: Final = ("numpy", "shapely")
SOLVING: Final = (*_MEANING, "scipy", "highspy", "threadpoolctl")
LONGEST: Final = 60.0
"""Seconds of a solve: whoever waits for more has a better place for it than a browser."""


def missing(packages: tuple[str, ...]) -> list[str]:
    """Those of the packages that aren't there."""
    return [name for name in packages if find_spec(name) is None]


def abilities() -> dict[str, Any]:
    """`check`, `solve`: the packages that each of them lacks here."""
    return {"check": missing(_MEANING), "solve": missing(SOLVING)}


def examine(text: str) -> dict[str, Any]:
    """`problems` with their places; `summary` of a mission without errors.

    `depth` is "meaning", or "syntax" where the packages for more are missing.
    """
    source = Source(NAME, text)
    if missing(_MEANING):
        result = parse(source)
        return {"depth": "syntax", "problems": _told(result.diagnostics), "summary": None}
    try:
        mission = _load(text)
    except MissionError as error:
        return {"depth": "meaning", "problems": _told(error.diagnostics), "summary": None}
    return {"depth": "meaning", "problems": _told(mission.warnings), "summary": mission.summary()}


def tidied(text: str) -> dict[str, Any]:
    """`text` in the one style; `problems` instead where it can't be read."""
    result = parse(Source(NAME, text))
    if any(d.severity is Severity.ERROR for d in result.diagnostics):
        return {"problems": _told(result.diagnostics)}
    return {"text": format_file(result.file)}


def solved(text: str, seconds: float = 20.0) -> dict[str, Any]:
    """`report`, the page that `stlc report` writes, and what `stlc solve` says of the plan.

    StlcError where there is no plan, as `stlc.api.solve`.
    """
    from stlc.api import solve
    from stlc.backends.support import THREADS
    from stlc.report import report_page
    from stlc.solve.outcome import SolveSettings

    mission = _load(text)
    strategy = "auto" if THREADS else "milp"  # searches over teams have threads of their own
    limit = min(seconds, LONGEST)
    outcome = solve(mission, SolveSettings(strategy=strategy, time_limit=limit, threads=1))
    return {"report": report_page(mission, outcome.plan), "said": outcome.report.text()}


_ANSWERS: Final[dict[str, Callable[..., dict[str, Any]]]] = {
    "abilities": abilities, "examine": examine, "format": tidied, "solve": solved,
}  # fmt: skip


def answer(request: str) -> str:
    """The answer to `{"do": .., "text": .., ..}`; `{"error", "status"}` for one that failed.

    `status` is the exit status of the command line, 70 for what is our own fault.
    """
    words = json.loads(request)
    do = _ANSWERS[words.pop("do")]
    try:
        return json.dumps(do(**words))
    except MissionError as error:
        return json.dumps({"error": "the mission has mistakes", "status": error.exit_status,
                           "problems": _told(error.diagnostics)})  # fmt: skip
    except StlcError as error:
        return json.dumps({"error": str(error), "status": error.exit_status})


def _load(text: str) -> Mission:
    from stlc.api import loads

    return loads(text, name=NAME, folder=Path.cwd())


def _told(diagnostics: Iterable[Diagnostic]) -> list[dict[str, Any]]:
    return [as_dict(d) for d in diagnostics]
