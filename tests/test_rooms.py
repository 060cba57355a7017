"""Which room may import which: the table of docs/architecture.md, held against every import.

Imports inside functions and those for type checkers count as well.
"""

from __future__ import annotations

import ast
from collections.abc import Iterable, Mapping
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent

LEAVES = {
    "source",
    "record",
    "arrays",
    "database",
    "errors",
    "diagnostics",
    "files",
    "guard",
    "inputs",
    "loader",
    "sense",
    "matrices",
    "sphere",
    "version",
    "violation",
}
"""Rooms that everything may use; they use one another only."""

MAY: Mapping[str, set[str]] = {
    "ir": set(),
    "radio": set(),
    "recording": set(),
    "trajectories": set(),
    "diagnostic_examples": set(),
    "grammar": set(),
    "syntax": {"grammar"},
    "render": set(),
    "mission": {"ir", "radio"},
    "channels": {"ir", "radio", "mission"},
    "grids": {"mission", "radio"},
    "measurements": {"mission", "radio"},
    "scales": {"mission", "channels"},
    "bezier": {"mission"},
    "sema": {"grids", "syntax", "ir", "radio", "mission", "scales", "bezier", "recording"},
    "analysis": {"ir", "mission", "channels"},
    "passes": {"ir", "mission", "analysis"},
    "milp": {
        "ir", "mission", "analysis", "passes", "channels", "scales", "trajectories", "bezier",
    },
    "backends": {"milp"},
    "plan": {"grids", "measurements", "mission", "radio"},
    "verify": {"grids", "ir", "radio", "mission", "channels", "scales", "plan"},
    "monitor": {"ir", "mission", "verify", "recording"},
    "solve": {
        "grids", "ir", "radio", "mission", "channels", "scales", "analysis", "passes", "milp",
        "backends", "plan", "verify", "trajectories",
    },
    "explain": {
        "syntax", "ir", "mission", "channels", "analysis", "passes", "milp", "backends", "verify",
        "trajectories", "plan", "solve",
    },
    "simulate": {"ir", "radio", "mission", "measurements", "channels", "plan", "verify"},
    "plot": {"ir", "radio", "mission", "measurements", "channels", "plan", "verify"},
    "report": {
        "grammar", "ir", "mission", "plan", "verify", "plot", "explain",
    },
    "renew": {
        "ir", "radio", "mission", "channels", "grids", "measurements", "scales", "passes", "milp",
        "plan", "verify", "solve",
    },
    "api": {
        "syntax", "sema", "mission", "milp", "plan", "verify", "solve", "simulate", "explain",
        "radio", "renew",
    },
    "exports": {"mission", "plan", "verify"},
    "maps": {"syntax"},
    "lsp": {"syntax", "sema", "mission"},
    "front": {
        "api", "explain", "milp", "mission", "plan", "plot", "report", "solve", "syntax", "verify",
    },
    "playground": {"api", "backends", "render", "report", "solve", "syntax", "mission"},
    "sweep": {"api", "mission", "plan", "plot", "solve"},
    "conformance": {"api", "milp", "backends", "solve"},
    "dialects": {"syntax", "grammar", "sema", "api"},
    "bench": {"api", "mission", "passes", "milp", "backends", "solve", "plot"},
}  # fmt: skip
"""Room -> rooms that it may import besides itself and LEAVES; `cli` may import all of them."""


def _modules() -> dict[str, Path]:
    found: dict[str, Path] = {}
    for folder, prefix in (("stlc", ()), ("backends", ("backends",)), ("grammar", ("grammar",))):
        for path in (ROOT / folder).rglob("*.py"):
            parts = path.relative_to(ROOT / folder).with_suffix("").parts
            if folder == "stlc" and parts[0] in ("backends", "grammar"):
                continue  # symlinks for type checkers
            found[".".join(("stlc", *prefix, *parts)).removesuffix(".__init__")] = path
    return found


MODULES = _modules()


def _imports(module: str) -> set[str]:
    """Modules of ours that a module imports, wherever in it."""
    found: set[str] = set()
    for node in ast.walk(ast.parse(MODULES[module].read_text())):
        if isinstance(node, ast.Import):
            found.update(alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom) and node.module:
            names = [f"{node.module}.{alias.name}" for alias in node.names]
            found.update(name if name in MODULES else node.module for name in names)
    return found & MODULES.keys()


GRAPH = {module: _imports(module) for module in MODULES}


def _room(module: str) -> str:
    room = module.split(".")[1] if "." in module else ""
    parts = {
        "certificate": "plan", "plan_json": "plan", "plan_reader": "plan", "plan_place": "plan",
        "places": "mission", "preferences": "mission",
        "charges": "mission", "link_places": "channels", "tubes": "mission", "robots": "mission",
        "dynamics": "mission",
    }  # fmt: skip
    return parts.get(room, room)  # rooms in several files


def _crossings() -> Iterable[tuple[str, str, str, str]]:
    for module, names in GRAPH.items():
        for name in names:
            rooms = _room(module), _room(name)
            if rooms[0] != rooms[1] and "" not in rooms:
                yield *rooms, module, name


def test_rooms_import_what_the_table_allows() -> None:
    wrong = []
    for room, other, module, name in _crossings():
        if room in ("cli", "__main__"):
            continue
        allowed = LEAVES if room in LEAVES else LEAVES | MAY[room]
        if other not in allowed:
            wrong.append(f"{module} imports {name}")
    assert not wrong, "\n".join(sorted(wrong))


def test_the_table_names_every_room_and_no_import_that_is_gone() -> None:
    rooms = {_room(m) for m in MODULES} - {"", "cli", "__main__"}
    assert rooms == LEAVES | MAY.keys()
    seen = {(room, other) for room, other, _, _ in _crossings()}
    stale = [(r, o) for r, others in MAY.items() for o in others if (r, o) not in seen]
    assert not stale, stale


def test_rooms_have_no_circle() -> None:
    done: set[str] = set()
    while done != MAY.keys():
        free = {room for room, others in MAY.items() if others <= done} - done
        assert free, f"a circle among {sorted(MAY.keys() - done)}"
        done |= free


def test_no_circle_of_files_over_three() -> None:
    for circle in _circles():
        assert len(circle) <= 3, f"a circle of imports: {sorted(circle)}"


def _circles() -> list[set[str]]:
    """Strongly connected modules, by what each one reaches."""
    reach = {module: _reached(module) for module in GRAPH}
    return [
        circle
        for module in GRAPH
        if len(circle := {m for m in reach[module] if module in reach[m]} | {module}) > 1
    ]


def _reached(start: str) -> set[str]:
    seen: set[str] = set()
    todo = [start]
    while todo:
        for name in GRAPH[todo.pop()] - seen:
            seen.add(name)
            todo.append(name)
    return seen
