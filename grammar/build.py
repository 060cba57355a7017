"""Builds `tables.json` from `stl.lark`: run `python -m stlc.grammar.build` after a change.

Lark computes the LALR(1) table; what is stored is plain numbers and words, so that `stlc` starts
without importing lark and without unpickling anything. A test fails when the file is stale.
"""

from __future__ import annotations

import json
import os
import re
from pathlib import Path
from typing import Any

_TERMINAL = re.compile(r'^([A-Z_]+): ("[^\n]*")$', re.M)
_SPELLING = re.compile(r'"([^"]+)"')
# Terminals that carry something the tree needs; all others only guide the parser.
_KEPT = frozenset(
    {"NAME", "KEY", "NUMBER", "STRING", "UNIT", "SWEPT", "SAMPLED"}
    | {"LE", "LT", "GE", "GT", "EQEQ", "NE"}
)


def spellings(grammar: str) -> dict[str, list[str]]:
    """How each fixed terminal may be written, the canonical spelling first."""
    return {name: _SPELLING.findall(words) for name, words in _TERMINAL.findall(grammar)}


def build(grammar: str) -> dict[str, Any]:
    """Parse table of the grammar's text as JSON-ready data.

    `rules[k]` is [left side, length, callback or None, plan, splices]: the plan lists the children
    that the callback gets (positions on the right side; -1 for an absent optional), `splices` says
    that it is, or has, a repetition. `actions[s]` maps a
    terminal to a state to shift to (>= 0) or to `-1 - rule` to reduce by.
    """
    from lark import Lark

    parser = Lark(grammar, parser="lalr", start="start", maybe_placeholders=True)
    table = parser.parser.parser._parse_table
    numbers = {rule: k for k, rule in enumerate(parser.rules)}
    order = _numbering(table.states, table.start_states["start"])
    actions: list[dict[str, int]] = [{} for _ in order]
    gotos: list[dict[str, int]] = [{} for _ in order]
    for state in order:
        for symbol, (action, argument) in sorted(table.states[state].items()):
            if action.name == "Reduce":
                actions[order[state]][symbol] = -1 - numbers[argument]
            else:
                target = actions if symbol.isupper() or symbol == "$END" else gotos
                target[order[state]][symbol] = order[argument]
    return {
        "spellings": spellings(grammar),
        "rules": [_rule(rule) for rule in parser.rules],
        "actions": actions,
        "gotos": gotos,
        "start": order[table.start_states["start"]],
        "end": order[table.end_states["start"]],
    }


def _numbering(states: Any, start: Any) -> dict[Any, int]:
    """States in breadth-first order, so that the same grammar always gives the same file."""
    order = {start: 0}
    queue = [start]
    for state in queue:
        for _, (action, argument) in sorted(states[state].items()):
            if action.name == "Shift" and argument not in order:
                order[argument] = len(order)
                queue.append(argument)
    return order


def _rule(rule: Any) -> list[Any]:
    """[name, length, callback, children kept, splices]; -1 is an option left out."""
    absent = rule.options.empty_indices or (False,) * len(rule.expansion)
    plan: list[int] = []
    position = 0
    for missing in absent:
        if missing:
            plan.append(-1)
            continue
        symbol = rule.expansion[position]
        if not symbol.is_term or symbol.name in _KEPT:
            plan.append(position)
        position += 1
    name = rule.origin.name
    callback = rule.alias or (None if name.startswith("_") or rule.options.expand1 else name)
    splices = any(part.startswith("_") for part in (name, *(s.name for s in rule.expansion)))
    return [name, len(rule.expansion), callback, plan, splices]


def render(grammar: str) -> str:
    """The content of `tables.json`."""
    return json.dumps(build(grammar), ensure_ascii=False, separators=(",", ":")) + "\n"


def main() -> None:
    """Write `tables.json` beside the grammar."""
    folder = Path(__file__).resolve().parent
    scratch = folder / "tables.json.tmp"
    text = (folder / "stl.lark").read_text(encoding="utf-8")
    scratch.write_text(render(text), encoding="utf-8")
    os.replace(scratch, folder / "tables.json")


if __name__ == "__main__":
    main()
