"""What counts as a fault of a command, and what makes two faults the same one."""

from __future__ import annotations

import json
import re
from dataclasses import dataclass

from fuzz.pool import KILLED
from fuzz.worker import CRASH, Ran

CHECK_SECONDS = 5.0
COMPILE_SECONDS = 20.0
SOLVE_SECONDS = 30.0  # CPU, of a solve with a limit of 5 s on one thread
CHECK_MEMORY = 1 << 30
_SECONDS = {"check": CHECK_SECONDS, "compile": COMPILE_SECONDS, "solve": SOLVE_SECONDS}
_PLACE = re.compile(r"^ *--> \S.*:\d+:\d+", re.M)
_ERROR = re.compile(r"^(error(?:\[[A-Z]\d+\])?: .*)$", re.M)
_WARNING = re.compile(r"\w+\.py:\d+: \w*Warning: .*")
EXPECTED = {"check": {0, 1}, "compile": {0, 1, 3}, "solve": {0, 1, 3, 4}}


@dataclass(frozen=True, slots=True)
class Fault:
    """A kind, the command, and what tells it from others of its kind."""

    kind: str
    command: str
    detail: str = ""

    @property
    def signature(self) -> str:
        """Without numbers and names."""
        plain = re.sub(r"`[^`]*`|'[^']*'|[-+]?\d[\d.e+-]*", "#", self.detail)
        return f"{self.command}: {self.kind}: {plain[:120]}"


def faults(ran: Ran) -> list[Fault]:
    """Every fault of one command's run."""
    found = []
    if ran.status == KILLED:
        found.append(("no end", ran.where))
    elif ran.status == CRASH:
        found.append(("crash", ran.where or _first(ran.stderr)))
    elif "Traceback (most recent call last)" in ran.stderr + ran.stdout:
        found.append(("traceback", _last(ran.stderr)))
    elif (warning := _WARNING.search(ran.stderr)) is not None:
        found.append(("warning", warning[0]))
    elif ran.status not in EXPECTED[ran.command]:
        found.append((f"exit {ran.status}", _first(ran.stderr)))
    elif ran.status == 1 and not _located(ran):
        found.append(("no place", _first(ran.stderr)))
    elif (text := _not_json(ran)) is not None:
        found.append(("not JSON", f"exit {ran.status}: {text[:60]}"))
    if ran.status != KILLED and ran.seconds > _SECONDS[ran.command]:
        found.append((f"above {_SECONDS[ran.command]:g} s", ""))
    if ran.command == "check" and ran.peak > CHECK_MEMORY:
        found.append(("above 1 GB", ""))
    return [Fault(kind, ran.command, detail) for kind, detail in found]


def _located(ran: Ran) -> bool:
    """Every error has a line and a column."""
    if "--format" in ran.words:
        try:
            told = json.loads(ran.stdout)
        except ValueError:
            return False
        found = told["diagnostics"] if isinstance(told, dict) else told
        return bool(found) and all(_has_place(d) for d in found)
    return len(_PLACE.findall(ran.stderr)) >= max(1, len(_ERROR.findall(ran.stderr)))


def _has_place(diagnostic: dict[str, object]) -> bool:
    return bool(re.search(r'"line": [1-9]', json.dumps(diagnostic)))


def _not_json(ran: Ran) -> str | None:
    """Standard output that should be one JSON value and isn't, or None."""
    if not ({"--json", "--format"} & set(ran.words)) or ran.status == 1:
        return None
    try:
        json.loads(ran.stdout, parse_constant=_refuse)
    except ValueError:
        return ran.stdout or "(empty)"
    return None


def _refuse(text: str) -> None:
    raise ValueError(text)


def _first(text: str) -> str:
    at = _ERROR.search(text)
    return at[1] if at else text.strip().split("\n")[0]


def _last(text: str) -> str:
    return text.strip().split("\n")[-1]
