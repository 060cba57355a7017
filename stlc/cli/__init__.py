"""The command line: a thin layer over the Python API. Commands are imported when they are used."""

from __future__ import annotations

import gc
import importlib
import os
from typing import TYPE_CHECKING, Any

import click

from stlc.version import __version__

if TYPE_CHECKING:
    from click.shell_completion import CompletionItem

# command -> module of stlc.cli that defines it, and its line in `stlc --help`, in that order
_COMMANDS = {
    "check": ("check", "Find every mistake of a mission file."),
    "fmt": ("check", "Lay out mission files in the one style."),
    "compile": ("compile", "Write the mission as LP or MPS for any solver."),
    "solve": ("solve", "Plan a mission; the plan is certified and verified."),
    "verify": ("plans", "Judge a plan against its mission."),
    "plot": ("plans", "Draw a plan."),
    "report": ("report", "Show a plan in one HTML page: map in motion, requirements, signals."),
    "export": ("exchange", "Write a plan as GeoJSON, MCAP, a ROS bag or timed waypoints."),
    "map": ("exchange", "Turn a ROS map or a DXF drawing into obstacles."),
    "read-solution": ("plans", "Turn another solver's answer into a plan."),
    "explain": ("explain", "Name the requirements that conflict."),
    "replan": ("replan", "Plan what is left of a mission that is under way."),
    "simulate": ("simulate", "Carry out a plan many times: how probable is each requirement?"),
    "sweep": ("sweep", "Solve over parameters; trade two costs off against each other."),
    "race": ("race", "Solve with several solvers and encodings at once."),
    "fit": ("fit", "Fit a channel to measurements."),
    "import": ("monitor", "Translate STL files of Breach, RTAMT or FalCAuN."),
    "monitor": ("monitor", "Judge recorded signals."),
    "bench": ("bench", "Benchmark encodings and backends."),
    "backends": ("listing", "List the solvers and what they can do."),
    "encodings": ("listing", "List the encodings of formulas and link tables."),
    "lsp": ("lsp", "Serve an editor: diagnostics, completion, rename, formatting."),
    "completion": ("completion", "Complete commands, options, solvers and files in a shell."),
}


_OBJECTS = 200_000
"""New ones between two collections of the youngest. Modules and missions are hundreds of thousands
that stay: looking at them after every 700, Python's own figure, takes a tenth of a small solve."""


class _LazyGroup(click.Group):
    def list_commands(self, ctx: click.Context) -> list[str]:
        return list(_COMMANDS)

    def get_command(self, ctx: click.Context, cmd_name: str) -> click.Command | None:
        if cmd_name not in _COMMANDS:
            return None
        module = importlib.import_module(f"stlc.cli.{_COMMANDS[cmd_name][0]}")
        command: Any = getattr(module, cmd_name.replace("-", "_") + "_command")
        assert isinstance(command, click.Command)
        return command

    def resolve_command(
        self, ctx: click.Context, args: list[str]
    ) -> tuple[str | None, click.Command | None, list[str]]:
        from difflib import get_close_matches

        name = args[0]
        near = [] if name in _COMMANDS else get_close_matches(name, _COMMANDS, n=1)
        if not near:
            return super().resolve_command(ctx, args)
        raise click.UsageError(f"No such command {name!r}; did you mean {near[0]!r}?", ctx)

    def shell_complete(self, ctx: click.Context, incomplete: str) -> list[CompletionItem]:
        from click.shell_completion import CompletionItem

        found = [n for n in _COMMANDS if n.startswith(incomplete)]
        return [
            *(CompletionItem(name, help=_COMMANDS[name][1]) for name in found),
            *click.Command.shell_complete(self, ctx, incomplete),
        ]

    def format_commands(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        with formatter.section("Commands"):
            formatter.write_dl([(name, line) for name, (_, line) in _COMMANDS.items()])


@click.group(cls=_LazyGroup, context_settings={"help_option_names": ["-h", "--help"]})
@click.version_option(__version__, prog_name="stlc")
def cli() -> None:
    """Plan missions of robots that must keep talking: one .stl file in, a certified plan out.

    \b
    Exit status: 0 good; 1 the file has errors; 2 usage; 3 proven infeasible; 4 no plan within
    the limits; 5 solver missing, failed or refused; 6 the plan violates the mission; 70 our own
    disagreement; 74 an output could not be written; 130 interrupted.

    `stlc COMMAND --help` tells more about a command.
    """


def main() -> None:
    """Entry point: runs the command and turns every error into a message and an exit status."""
    gc.set_threshold(_OBJECTS, 20, 50)
    try:  # until somebody heeds signals, they come as an exception out of whatever is imported
        from stlc.cli.common import run_guarded
        from stlc.cli.interrupt import heed_signals, leave
        from stlc.cli.streams import claim_streams

        streams = claim_streams()
        heed_signals()
        if "_STLC_COMPLETE" in os.environ:  # a shell asks what it can offer
            from stlc.cli.shells import register

            register()
    except KeyboardInterrupt:
        raise SystemExit(130) from None
    leave(streams.close(run_guarded(cli)))
