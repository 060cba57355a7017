"""Data files of channels: cost tables and measured samples."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

from stlc.diagnostics import Note
from stlc.mission import Array
from stlc.sema import props
from stlc.sema.channel_errors import BadChannel, BadData
from stlc.sema.files import Files
from stlc.sema.report import Mistake
from stlc.sema.scope import Scope
from stlc.sema.units import DBM, METRE
from stlc.sema.warnings import ChannelNote
from stlc.syntax import ast

if TYPE_CHECKING:
    from stlc.radio.errors import DataError
    from stlc.radio.gp import ChannelModel
    from stlc.radio.samples import Samples
    from stlc.radio.walls import Walls

USAGE = 'samples "rssi.csv"'


def read_table(path: ast.String, cells: int, files: Files) -> Array:
    """A square table of costs, one value for each pair of cells, from CSV or NPZ."""
    from stlc.radio import link_table
    from stlc.radio.errors import DataError

    place = files.path(path.value, path.span)
    try:
        table = link_table.read_table(place)
    except DataError as error:
        raise Mistake(_bad(path, error)) from None
    if table.shape != (cells, cells):
        problem = f"it is {' x '.join(map(str, table.shape))}, not {cells} x {cells}"
        hint = "give one value for each pair of cells, rows in the order of the partition"
        raise Mistake(BadData(span=path.span, path=path.value, problem=problem, hint=hint))
    return table


def _bad(path: ast.String, error: DataError) -> BadData:
    line, column = error.location.line, error.location.column
    place = "" if line is None else f"line {line}: " if column is None else f"{line}:{column}: "
    hint = error.help or "see the data section of the language guide"
    return BadData(span=path.span, path=path.value, problem=f"{place}{error.message}", hint=hint)


@dataclass(frozen=True, slots=True)
class SampleSource:
    """What a `samples` property says: a file, how to read it, and whether to fit."""

    path: ast.String
    fit: bool = False
    offsets: bool = False
    floor: float | None = None
    height: float = 0.0
    where: tuple[str, str] | None = None
    not_heard: tuple[str, ...] = ()


def sample_source(item: ast.Property, scope: Scope) -> SampleSource:
    """`samples "rssi.csv" fit offsets floor -100 dBm not_heard 127 where "run" "3"`."""
    words = [word for arg in item.args for word in _parted(arg)]
    first = words.pop(0) if words else None
    if not isinstance(first, ast.String):
        raise props.bad(item, "needs the name of a file first", USAGE)
    found = SampleSource(first)
    while words:
        head = words.pop(0)
        match head.text if isinstance(head, ast.Name) else "":
            case "fit":
                found = replace(found, fit=True)
            case "offsets":
                found = replace(found, offsets=True)
            case "floor" if words:
                found = replace(found, floor=scope.number(words.pop(0), DBM))
            case "height" if words:
                found = replace(found, height=scope.number(words.pop(0), METRE))
            case "not_heard" if words:
                found = replace(found, not_heard=(*found.not_heard, _mark(words.pop(0), scope)))
            case "where" if len(words) >= 2:
                column, value = scope.text(words.pop(0)), scope.text(words.pop(0))
                found = replace(found, where=(column, value))
            case _:
                raise props.bad(item, "has an unknown word", f"{USAGE} fit", head.span)
    return found


def _mark(expr: ast.Expr, scope: Scope) -> str:
    """The cell that stands for a packet not heard: a text or a number."""
    if isinstance(expr, ast.String):
        return expr.value
    scalar = scope.constant(expr)
    value = scalar.constant if scalar.unit is None else scope.number(expr, DBM)
    return f"{value:g}"


def _parted(expr: ast.Expr) -> tuple[ast.Expr, ...]:
    """`floor -58 dBm` reads as a difference: here it is a word and a negative number."""
    if (
        isinstance(expr, ast.Arithmetic)
        and expr.operator == "-"
        and isinstance(expr.left, ast.Name)
    ):
        return expr.left, ast.Negate(expr.right.span, expr.right)
    return (expr,)


def read_samples(source: SampleSource, files: Files) -> Samples:
    """Measured links. Raises Mistake."""
    from stlc.radio import read
    from stlc.radio.errors import DataError

    place = files.path(source.path.value, source.path.span)
    options = read.SampleOptions(source.height, source.floor, source.where, source.not_heard)
    try:
        return read.read_samples(place, options)
    except DataError as error:
        raise Mistake(_bad(source.path, error)) from None


Measured = tuple["ChannelModel", "Samples"]
"""A channel, and the samples that it was made with."""


def conditioned(model: ChannelModel, name: str, source: SampleSource, files: Files) -> Measured:
    """The channel given measurements."""
    from stlc.radio.errors import RadioError
    from stlc.radio.gp import condition

    samples = read_samples(source, files)
    try:
        return condition(model, samples), samples
    except RadioError as error:
        raise Mistake(_refused(name, source, error)) from None


@dataclass(frozen=True, slots=True)
class FitShape:
    """What a fit takes from the file: the kernel, d0 [m], and walls whose losses it estimates."""

    kernel: str
    d0: float
    walls: Walls | None


def fitted(
    name: str, source: SampleSource, shape: FitShape, scope: Scope, files: Files
) -> Measured:
    """The channel of maximum likelihood for measurements, conditioned on them."""
    from stlc.radio.errors import RadioError
    from stlc.radio.fit import FitOptions, fit_channel
    from stlc.radio.kernel import KernelName

    samples = read_samples(source, files)
    options = FitOptions(
        d0=shape.d0, receiver_offsets=source.offsets, kernel=KernelName(shape.kernel),
        walls=shape.walls,
    )  # fmt: skip
    try:
        report = fit_channel(samples, options)
    except RadioError as error:
        raise Mistake(_refused(name, source, error)) from None
    for note in report.notes:
        scope.report.add(ChannelNote(span=source.path.span, channel=name, text=note))
    return report.model, samples


def _refused(name: str, source: SampleSource, error: Exception) -> BadChannel:
    note = Note("these samples", source.path.span)
    return BadChannel(span=source.path.span, channel=name, problem=str(error), notes=(note,))
