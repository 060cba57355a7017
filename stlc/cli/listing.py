"""`stlc backends` and `stlc encodings`."""

from __future__ import annotations

import click

from stlc.cli.answer import answer
from stlc.errors import SolverError


@click.command("backends")
@click.option("--json", "as_json", is_flag=True, help="Print one JSON object.")
def backends_command(as_json: bool) -> int:
    """List the solvers, what they can do, and how to get those that are missing."""
    from stlc import backends

    rows = [_describe(name) for name in backends.names()]
    if as_json:
        answer({"backends": rows})
        return 0
    for row in rows:
        state = row["version"] or f"missing: {row['missing']}"
        click.echo(f"{row['name']:12} {state}")
        click.echo(f"{'':12} {row['capabilities']}")
    return 0


def _describe(name: str) -> dict[str, object]:
    """Under the name that `--backend` takes; a plugin that cannot load is listed with its error."""
    from stlc import backends
    from stlc.backends.base import Capability

    try:
        backend = backends.get(name)
    except SolverError as error:
        return {"name": name, "version": None, "missing": str(error), "capabilities": ""}
    missing = backend.available()
    names = [c.name.lower() for c in Capability if c & backend.capabilities and c.name]
    version = None if missing else backend.version()
    return {
        "name": name,
        "version": version,
        "missing": missing,
        "capabilities": ", ".join(names),
    }


@click.command("encodings")
@click.option("--json", "as_json", is_flag=True, help="Print one JSON object.")
def encodings_command(as_json: bool) -> int:
    """List the encodings of formulas and of link tables."""
    from stlc.milp.encodings import describe_encodings

    rows = describe_encodings()
    if as_json:
        answer({"encodings": rows})
        return 0
    for row in rows:
        click.echo(f"{row['kind']:8} {row['name']:14} {row['summary']}")
    return 0
