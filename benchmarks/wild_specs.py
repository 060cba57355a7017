"""How many formulas found in the wild can be imported, by dialect.

    python benchmarks/wild_specs.py FORMULAS.tsv [--verbose]

Columns of the table: id, dialect, formula, source. Each formula is imported alone. Counted are
formulas imported, formulas refused with a located reason, and failures (a traceback, or an error
without a place). `in scope` are the formulas of future time with piecewise-linear predicates: all
but those refused for a past operator or a nonlinear predicate (--verbose lists them); texts that
can't be read count as refused. The share is that of imported formulas among those in scope. That
an imported formula has the same meaning is tested on random traces in tests/dialects.
"""

from __future__ import annotations

import argparse
import csv
from collections import Counter
from dataclasses import dataclass
from pathlib import Path

from stlc.dialects import DIALECTS, import_text
from stlc.errors import MissionError
from stlc.source import Source

OUT_OF_SCOPE = {"E0902": "past", "E0903": "nonlinear"}


@dataclass(frozen=True, slots=True)
class Outcome:
    """What became of one formula: `imported`, a reason, or `failure`."""

    kind: str
    detail: str


def attempt(formula: str, dialect: str) -> Outcome:
    """Import one formula."""
    try:
        import_text(Source("formula", formula), dialect)
    except MissionError as error:
        first = error.diagnostics[0]
        if first.span is None:
            return Outcome("failure", str(first))
        return Outcome(OUT_OF_SCOPE.get(first.code, "refused"), str(first))
    except (ArithmeticError, LookupError, TypeError, ValueError, RecursionError) as error:
        return Outcome("failure", f"{type(error).__name__}: {error}")
    return Outcome("imported", "")


def rows(path: Path) -> list[tuple[str, str, str]]:
    """(id, dialect, formula) of the dialects that can be imported."""
    with path.open(encoding="utf-8") as stream:
        found = csv.reader(stream, delimiter="\t", quoting=csv.QUOTE_NONE)
        return [(r[0], r[1], r[2]) for r in found if len(r) >= 3 and r[1] in DIALECTS]


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0] if __doc__ else None)
    parser.add_argument("table", type=Path)
    parser.add_argument("--verbose", action="store_true", help="print every formula refused")
    options = parser.parse_args()
    counts: dict[str, Counter[str]] = {dialect: Counter() for dialect in DIALECTS}
    for number, dialect, formula in rows(options.table):
        outcome = attempt(formula, dialect)
        counts[dialect][outcome.kind] += 1
        if options.verbose and outcome.kind != "imported":
            print(f"{number}\t{outcome.kind}\t{formula}\t{outcome.detail}")
    kinds = ("imported", "refused", "failure", "past", "nonlinear")
    print("dialect   all  in scope  share  " + "  ".join(kinds))
    for dialect, count in counts.items():
        scope = count["imported"] + count["refused"] + count["failure"]
        share = 100.0 * count["imported"] / scope if scope else 0.0
        cells = "  ".join(str(count[k]).rjust(len(k)) for k in kinds)
        print(f"{dialect:<8} {count.total():>4} {scope:>9} {share:>5.1f}%  {cells}")


if __name__ == "__main__":
    main()
