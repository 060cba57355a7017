"""Names of encodings as a person gives them: `auto`, `literal`, `stl=log,link=hull`."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import replace
from importlib.metadata import entry_points

from stlc.errors import UsageError
from stlc.milp.compile import CompileOptions
from stlc.milp.formulas.selectors import ENTRY_POINTS, SELECTORS, selector_named
from stlc.milp.tables.registry import ENCODINGS, encoding_named

_STL = {
    "auto": "Chosen for each disjunction by its structure.",
    "onehot": "A binary for each alternative, shared-face rows.",
    "unary": "Ordered binaries: branching splits alternatives into before and after.",
    "log": "Logarithmically many binaries (Gray code).",
    "bigm": "A binary and big-M rows for each alternative: the textbook, for comparison.",
    "hull": "Convex hull by copies of the variables (Balas).",
}


def parse_encoding(text: str) -> tuple[str, str]:
    """(formula encoding, link table encoding).

    A name alone goes wherever it is known. Raises UsageError for an unknown name.
    """
    chosen = {"stl": "auto", "link": "auto"}
    for item in filter(None, (part.strip() for part in text.split(","))):
        kind, sign, name = item.partition("=")
        if sign:
            if kind not in chosen:
                raise UsageError(f"encodings are of kind stl or link, not {kind!r}")
            chosen[kind] = name
        else:
            _place(item, chosen)
    selector_named(chosen["stl"])
    if chosen["link"] != "auto":
        encoding_named(chosen["link"])
    return chosen["stl"], chosen["link"]


def compile_options(
    encoding: str = "auto",
    disabled: Iterable[str] = (),
    print_after: Iterable[str] = (),
    show: Callable[[str, str], None] | None = None,
    max_size: int | None = None,
) -> CompileOptions:
    """CompileOptions from what a person gives. Raises UsageError for unknown names."""
    stl, link = parse_encoding(encoding)
    options = CompileOptions(stl, link, frozenset(disabled), frozenset(print_after))
    if max_size is not None:
        options = replace(options, max_size=max_size)
    return options if show is None else replace(options, show=show)


def encoding_label(options: CompileOptions | None) -> str:
    """One word for reports: `auto`, or what was asked for."""
    options = options or CompileOptions()
    named = [f"{k}={v}" for k, v in (("stl", options.stl), ("link", options.link)) if v != "auto"]
    return ",".join(named) or "auto"


def _place(name: str, chosen: dict[str, str]) -> None:
    """Put a bare name where it is known; a package's encoding says its kind itself."""
    if name == "auto":
        return
    offered = _offered()
    if name in SELECTORS or offered.get(name) == "stl":
        chosen["stl"] = name
    if name in ENCODINGS or (name not in SELECTORS and offered.get(name) != "stl"):
        encoding_named(name)  # UsageError for an unknown one
        chosen["link"] = name


def _offered() -> dict[str, str]:
    """Kind ("stl" or "link") of every encoding that an installed package offers."""
    points = entry_points(group=ENTRY_POINTS)
    return {e.name: getattr(e.load(), "kind", "link") for e in points}


def describe_encodings() -> list[dict[str, str]]:
    """Kind, name and one line for each encoding."""
    formulas = [{"kind": "stl", "name": n, "summary": s} for n, s in _STL.items()]
    tables = [{"kind": "link", "name": n, "summary": _first_line(e)} for n, e in ENCODINGS.items()]
    others = [
        {"kind": kind, "name": n, "summary": "From an installed package."}
        for n, kind in _offered().items()
    ]
    return formulas + tables + others


def _first_line(thing: object) -> str:
    return (type(thing).__doc__ or "").strip().partition("\n")[0]
