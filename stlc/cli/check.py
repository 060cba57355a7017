"""`stlc check` and `stlc fmt`."""

from __future__ import annotations

import re
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING

import click

from stlc.api import load
from stlc.cli.common import Style, complain, parse_defines, reading_options, show_diagnostics
from stlc.errors import MissionError, UsageError

if TYPE_CHECKING:
    from stlc.diagnostics import Diagnostic

_FORMATS = click.Choice(["text", "json", "sarif", "github"])


@click.command("check")
@click.argument("files", nargs=-1, required=True, type=click.Path(path_type=Path))
@reading_options
@click.option("--format", "style", type=_FORMATS, default="text", show_default=True,
              help="How the mistakes are shown.")  # fmt: skip
@click.option("--explain", "code", is_flag=True, help="FILE is a code such as E0201: tell more.")
def check_command(
    files: tuple[Path, ...],
    define: tuple[str, ...],
    allow_path: tuple[Path, ...],
    style: Style,
    code: bool,
) -> int:
    """Check FILES: every mistake with its place, reason and remedy. Exit 1 if there is any.

    `-` is standard input. A file that can't be read is told, the others are checked all the same,
    and the exit status is 2.
    """
    if code:
        click.echo("\n\n".join(_explanation(str(file)) for file in files))
        return 0
    found: list[Diagnostic] = []
    statuses = [_check(file, parse_defines(define), allow_path, style, found) for file in files]
    if style != "text":
        show_diagnostics(found, style)
    return max(statuses)


def _check(
    file: Path,
    params: Mapping[str, str],
    allow_path: tuple[Path, ...],
    style: Style,
    found: list[Diagnostic],
) -> int:
    """The exit status of one file; its diagnostics are shown, or kept in `found` for machines."""
    summary, status = "", 0
    mistakes: tuple[Diagnostic, ...]
    try:
        mission = load(file, params=params, allow_paths=allow_path)
        summary, mistakes = f"{file}: {mission.summary()}", mission.warnings
    except MissionError as error:
        status, mistakes = error.exit_status, error.diagnostics
    except UsageError as error:
        complain(str(error))
        return error.exit_status
    if style != "text":
        found.extend(mistakes)
        return status
    if mistakes:
        show_diagnostics(mistakes)
    if summary:
        click.echo(summary)
    return status


def _explanation(code: str) -> str:
    """The long text of a diagnostic, with remedy and example; UsageError names codes near it."""
    import difflib
    import inspect
    from textwrap import indent

    from stlc.cli import conflicts  # noqa: F401  (its diagnostics belong to the catalogue)
    from stlc.diagnostic_examples import EXAMPLES
    from stlc.diagnostics import catalogue
    from stlc.sema import load_all_diagnostics

    load_all_diagnostics()
    known = catalogue()
    cls = known.get(code.upper())
    if cls is None:
        near = difflib.get_close_matches(code.upper(), known, n=3)
        hint = f"; near it: {', '.join(near)}" if near else ""
        raise UsageError(f"there is no diagnostic {code!r}{hint}; codes look like E0201 or W1001")
    parts = [f"{cls.code} ({cls.severity.value})", f"  {_open(cls.title)}"]
    parts += ["", inspect.cleandoc(cls.__doc__ or "")]
    remedy = _open(cls.help)
    if remedy.strip(".`"):  # else the remedy is made for each case
        parts += ["", f"Remedy: {remedy}"]
    if cls.code in EXAMPLES:
        wrong, right = (indent(text, "  ") for text in EXAMPLES[cls.code])
        parts += ["", "Wrong:", wrong, "", "Right:", right]
    return "\n".join(parts)


def _open(template: str) -> str:
    """A template with dots for what each case fills in."""
    return re.sub(r"\{\w+[^}]*\}", "..", template)


@click.command("fmt")
@click.argument("files", nargs=-1, required=True, type=click.Path(path_type=Path))
@click.option("--check", is_flag=True, help="Change nothing; exit 1 if a file would change.")
@click.option("--stdout", is_flag=True, help="Print instead of rewriting.")
def fmt_command(files: tuple[Path, ...], check: bool, stdout: bool) -> int:
    """Lay out FILES in the one style; comments and meaning stay. `-` goes to standard output."""
    from stlc.files import write_atomic
    from stlc.inputs import STANDARD
    from stlc.syntax.parse import parse
    from stlc.syntax.printer import format_file
    from stlc.syntax.read import read_source

    changed = []
    for path in files:
        source = read_source(path)
        result = parse(source)
        errors = [d for d in result.diagnostics if d.severity.value == "error"]
        if errors:
            raise MissionError(errors)
        text = format_file(result.file)
        if stdout or str(path) == STANDARD:
            click.echo(text, nl=False)
        elif text != source.text:
            changed.append(path)
            if not check:
                write_atomic(path, text, in_place=True)
    for path in changed:
        click.echo(f"{'would reformat' if check else 'reformatted'} {path}", err=True)
    return 1 if check and changed else 0
