"""The command line: a thin layer over the Python API. Commands are imported when they are used."""

from __future__ import annotations

import importlib
from typing import Any

import click

from stlc import __version__

# command -> module of stlc.cli that defines it; the listing order of `stlc --help`
_COMMANDS = {
    "check": "check",
    "fmt": "check",
    "compile": "compile",
    "solve": "solve",
    "verify": "plans",
    "plot": "plans",
    "read-solution": "plans",
    "explain": "explain",
    "race": "race",
    "fit": "fit",
    "import": "monitor",
    "monitor": "monitor",
    "bench": "bench",
    "backends": "listing",
    "encodings": "listing",
}


class _LazyGroup(click.Group):
    def list_commands(self, ctx: click.Context) -> list[str]:
        return list(_COMMANDS)

    def get_command(self, ctx: click.Context, cmd_name: str) -> click.Command | None:
        module_name = _COMMANDS.get(cmd_name)
        if module_name is None:
            return None
        module = importlib.import_module(f"stlc.cli.{module_name}")
        command: Any = getattr(module, cmd_name.replace("-", "_") + "_command")
        assert isinstance(command, click.Command)
        return command


@click.group(cls=_LazyGroup, context_settings={"help_option_names": ["-h", "--help"]})
@click.version_option(__version__, prog_name="stlc")
def cli() -> None:
    """Plan missions of robots that must keep talking: one .stl file in, a certified plan out.

    \b
    Exit status: 0 good; 1 the file has errors; 2 usage; 3 proven infeasible; 4 no plan within
    the limits; 5 solver missing, failed or refused; 6 the plan violates the mission; 70 our own
    disagreement; 74 an output could not be written; 130 interrupted.
    """


def main() -> None:
    """Entry point: runs the command and turns every error into a message and an exit status."""
    from stlc.cli.common import INTERRUPTED, run_guarded
    from stlc.cli.interrupt import leave

    try:
        status = run_guarded(cli)
    except KeyboardInterrupt:  # one more while the first was being told
        status = INTERRUPTED
    leave(status)
