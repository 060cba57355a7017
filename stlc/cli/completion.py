"""`stlc completion`, and what the shell is offered for names that the program knows."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import Any

import click
from click.shell_completion import CompletionItem

_HOW = {
    "bash": "source <(stlc completion bash)   # in ~/.bashrc",
    "zsh": "source <(stlc completion zsh)   # in ~/.zshrc, after compinit",
    "fish": "stlc completion fish > ~/.config/fish/completions/stlc.fish",
}


@click.command("completion")
@click.argument("shell", type=click.Choice(list(_HOW)))
def completion_command(shell: str) -> int:
    """Print a script that completes commands, options, solvers and files in SHELL.

    \b
    source <(stlc completion bash)   # in ~/.bashrc
    source <(stlc completion zsh)    # in ~/.zshrc, after compinit
    stlc completion fish > ~/.config/fish/completions/stlc.fish
    """
    from stlc.cli import cli
    from stlc.cli.shells import script

    click.echo(script(cli, shell))
    click.echo(f"# {_HOW[shell]}")
    return 0


_Offer = Callable[[click.Context, click.Parameter, str], list[CompletionItem]]


def _offer(names: Callable[[], Iterable[str]]) -> _Offer:
    """Those that begin with what has been typed; behind a comma or an equals sign, the next one."""

    def offer(context: click.Context, parameter: click.Parameter, typed: str) -> list[Any]:
        at = max(typed.rfind(","), typed.rfind("=")) + 1
        return [
            CompletionItem(typed[:at] + name) for name in names() if name.startswith(typed[at:])
        ]

    return offer


def _backends() -> Iterable[str]:
    from stlc import backends

    return backends.names()


def _encodings() -> Iterable[str]:
    from stlc.milp.encodings import describe_encodings

    return dict.fromkeys(["auto", *(row["name"] for row in describe_encodings())])


def _strategies() -> Iterable[str]:
    from stlc.solve.strategies import strategies_named

    return ["auto", *(s.name for s in strategies_named("auto"))]


def offer_entries(context: click.Context, parameter: click.Parameter, typed: str) -> list[Any]:
    """Solvers, each with an encoding behind a colon, with commas between: `highs:auto,scip`."""
    at = max(typed.rfind(","), typed.rfind(":")) + 1
    names = _encodings() if typed[at - 1 : at] == ":" else _backends()
    return [CompletionItem(typed[:at] + name) for name in names if name.startswith(typed[at:])]


offer_encodings = _offer(_encodings)
offer_strategies = _offer(_strategies)

backend_option = click.option(
    "--backend", default="highs", show_default=True, shell_complete=_offer(_backends),
    help="See `stlc backends`.",
)  # fmt: skip
encoding_option = click.option(
    "--encoding", default="auto", show_default=True, shell_complete=offer_encodings,
    help="See `stlc encodings`.",
)  # fmt: skip
