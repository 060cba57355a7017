"""What the commands share: errors to exit statuses, common options, output."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable, Mapping
from contextlib import suppress
from itertools import combinations
from pathlib import Path
from traceback import format_exception
from typing import TYPE_CHECKING, Any, Literal

import click

from stlc.cli.answer import answer_end, one_answer
from stlc.cli.interrupt import INTERRUPTED
from stlc.errors import MissionError, NoPlanError, OutputError, StlcError
from stlc.inputs import recorded_inputs

if TYPE_CHECKING:
    from stlc.diagnostics import Diagnostic
    from stlc.milp.compile import Compiled, CompileOptions
    from stlc.mission import Mission

Style = Literal["text", "json", "sarif", "github"]
INTERNAL = 70
GRACE = 0.4
"""Seconds that a solver may overrun its limit, or Ctrl-C, before it is left behind."""
OUT_OF_MEMORY = "out of memory: try coarser partitions, fewer steps or `--encoding lifted`"


def run_guarded(command: click.Command) -> int:
    """Run a click command; every outcome becomes an exit status, nothing a traceback."""
    with one_answer(), recorded_inputs():
        try:
            result = command.main(standalone_mode=False, prog_name="stlc")
        except SystemExit as ended:  # after completing for a shell
            return int(ended.code or 0)
        except (Exception, KeyboardInterrupt) as error:
            status = _told(error)
            with suppress(OutputError):  # what is wrong with standard output was told
                answer_end(status, _message(error))
            return status
    return result if isinstance(result, int) else 0


def _told(error: BaseException) -> int:
    """Say on standard error how a command ended; its exit status."""
    match error:
        case click.exceptions.Abort() | KeyboardInterrupt():
            return INTERRUPTED
        case click.ClickException():
            error.show()
            return error.exit_code
        case MissionError():
            show_diagnostics(error.diagnostics)
        case StlcError():
            complain(str(error))
        case MemoryError():
            complain(OUT_OF_MEMORY)
            return NoPlanError.exit_status
        case _:  # the last line of defence: a bug of ours, said so
            return _confess(error)
    return error.exit_status


def _message(error: BaseException) -> BaseException | str:
    if isinstance(error, click.exceptions.Abort | KeyboardInterrupt):
        return "interrupted"
    if isinstance(error, MemoryError):
        return OUT_OF_MEMORY
    return error.format_message() if isinstance(error, click.ClickException) else error


def debugging() -> bool:
    """Whether STLC_DEBUG asks for tracebacks of internal errors and for the events of searches."""
    return bool(os.environ.get("STLC_DEBUG"))


def _confess(error: BaseException) -> int:
    """Own up to an error that is a bug of ours; with STLC_DEBUG, say where it came from."""
    if debugging():
        click.echo("".join(format_exception(error)), err=True, nl=False)
    complain(
        f"internal error ({type(error).__name__}: {error}).\n"
        "This is a bug in stlc, not in your file; STLC_DEBUG=1 shows where. Please report it."
    )
    return INTERNAL


def complain(message: str) -> None:
    """One error sentence on standard error."""
    click.echo(f"{click.style('error', fg='red', bold=True)}: {message}", err=True)


def show_diagnostics(diagnostics: Iterable[Diagnostic], style: Style = "text") -> None:
    """Diagnostics in one of the formats text, json, sarif, github (text goes to stderr)."""
    from stlc.render import render

    click.echo(render(tuple(diagnostics), style), err=style == "text")


_Decorator = Callable[[Callable[..., Any]], Callable[..., Any]]


def mission_options(command: Callable[..., Any]) -> Callable[..., Any]:
    """`FILE` (`-` is standard input), `-D name=value`, `--allow-path DIR`."""
    return click.argument("file", type=click.Path(path_type=Path))(reading_options(command))


def reading_options(command: Callable[..., Any]) -> Callable[..., Any]:
    """`-D name=value`, `--allow-path DIR`."""
    decorators: list[_Decorator] = [
        click.option(
            "-D", "define", multiple=True, metavar="NAME=VALUE", help="Set a `param` of the file."
        ),
        click.option(
            "--allow-path",
            multiple=True,
            type=click.Path(path_type=Path),
            help="Also read imports and data from this folder.",
        ),
    ]
    for decorator in reversed(decorators):
        command = decorator(command)
    return command


def parse_defines(define: tuple[str, ...]) -> dict[str, str]:
    """`v=3` pairs; the value is an expression of the language, such as `3 m/s`."""
    pairs = {}
    for item in define:
        name, sign, value = item.partition("=")
        if not sign or not name.strip():
            raise click.UsageError(f"-D takes NAME=VALUE, not {item!r}")
        pairs[name.strip()] = value.strip()
    return pairs


def load(file: Path, define: tuple[str, ...], allow_path: tuple[Path, ...]) -> Mission:
    """The checked mission; its warnings go to standard error."""
    return load_with(file, parse_defines(define), allow_path)


def load_with(file: Path, params: Mapping[str, str], allow_path: tuple[Path, ...]) -> Mission:
    """The checked mission with these values of parameters; its warnings go to standard error."""
    from stlc.api import load as load_file

    mission = load_file(file, params=params, allow_paths=allow_path)
    if mission.warnings:
        show_diagnostics(mission.warnings)
    return mission


def compiled_model(mission: Mission, options: CompileOptions) -> Compiled:
    """The compiled mission; its warnings go to standard error."""
    from stlc.solve.blame import compile_or_blame

    compiled = compile_or_blame(mission, options)
    if compiled.warnings:
        show_diagnostics(compiled.warnings)
    return compiled


def solver_options(command: Callable[..., Any]) -> Callable[..., Any]:
    """`--option NAME=VALUE`, the solver's own options."""
    text = "An option of the solver itself, such as mip_heuristic_effort=0.1; see `stlc backends`."
    return click.option("--option", multiple=True, metavar="NAME=VALUE", help=text)(command)


def parse_solver_options(option: tuple[str, ...]) -> dict[str, object]:
    """`NAME=VALUE` pairs; a value is a number or true/false where it reads like one."""
    pairs: dict[str, object] = {}
    for item in option:
        name, sign, value = item.partition("=")
        if not sign or not name.strip():
            raise click.UsageError(f"--option takes NAME=VALUE, not {item!r}")
        pairs[name.strip()] = _value(value.strip())
    return pairs


def _value(text: str) -> object:
    if text.lower() in ("true", "false"):
        return text.lower() == "true"
    for kind in (int, float):
        with suppress(ValueError):
            return kind(text)
    return text


def check_outputs(*paths: Path | None) -> None:
    """OutputError now rather than after an hour of solving, where a file cannot be written.

    UsageError for two outputs that are one file, or one that is an input.
    """
    from stlc.files import check_writable

    given = [path for path in paths if path is not None]
    for path in given:
        check_writable(path)
    for one, other in combinations(given, 2):
        if os.path.realpath(one) == os.path.realpath(other) and not _is_device(one):
            raise click.UsageError(f"{one} and {other} are one file: the second would overwrite it")


def _is_device(path: Path) -> bool:
    return path.exists() and not path.is_file()


def plain(value: float | None) -> str:
    """A number for people: six digits, and 0 for what is rounding."""
    if value is None:
        return "-"
    return format(0.0 if abs(value) < 1e-9 else value, ".6g")
