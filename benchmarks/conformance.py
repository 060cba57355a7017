"""The conformance table: every backend against every case.

    python benchmarks/conformance.py [BACKEND ...]

Prints a Markdown table: `ok`, `-` (not offered), `missing` (not installed), or the failure.
Exit status 1 on a failure.
"""

from __future__ import annotations

import sys

from stlc import backends
from stlc.backends.base import Backend
from stlc.backends.conformance import CASES, Case
from stlc.errors import SolverError


def verdict(backend: Backend, case: Case) -> str:
    """One cell."""
    if backend.available() is not None:
        return "missing"
    if not case.applies(backend):
        return "-"
    try:
        case.check(backend)
    except (AssertionError, SolverError) as error:
        return (
            f"**{type(error).__name__}**: {str(error).splitlines()[0][:60] if str(error) else ''}"
        )
    return "ok"


def main() -> int:
    """Print the table row by row."""
    found = [backends.get(name) for name in sys.argv[1:] or backends.names() if name != "external"]
    found = [b for b in found if b.available() is None] or found
    print("| case | " + " | ".join(b.name for b in found) + " |")
    print("|---" * (len(found) + 1) + "|")
    failed = False
    for case in CASES:
        cells = [verdict(backend, case) for backend in found]
        failed = failed or any(cell not in ("ok", "-", "missing") for cell in cells)
        print(f"| {case} | " + " | ".join(cells) + " |", flush=True)
    print(*(f"\n{b.name}: {b.version()}" for b in found if b.available() is None))
    return int(failed)


if __name__ == "__main__":
    sys.exit(main())
