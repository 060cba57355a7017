"""Radio channels: the values of a block, as a model, a link budget, a partition and tables."""

from __future__ import annotations

from dataclasses import replace
from math import log10
from typing import TYPE_CHECKING

from stlc.mission import Array, Bound, Channel
from stlc.sema import props, units
from stlc.sema.budgets import link_budget, transmit_power
from stlc.sema.channel_data import FitShape, conditioned, fitted, read_table, sample_source
from stlc.sema.channel_errors import BadChannel, RayleighWithFading
from stlc.sema.channel_reader import Reader
from stlc.sema.costs import pairs_of
from stlc.sema.files import Files
from stlc.sema.heights import check_samples, height_range
from stlc.sema.link_calls import missing
from stlc.sema.partitions import is_auto, partition
from stlc.sema.report import Mistake, Reported
from stlc.sema.scope import Scope
from stlc.sema.values import ChannelName
from stlc.sema.walls import as_radio, known_losses, walls_of
from stlc.sema.warnings import PaperCost
from stlc.syntax import ast

if TYPE_CHECKING:
    from stlc.radio.gp import ChannelModel
    from stlc.radio.link_budget import LinkBudget
    from stlc.radio.partition import Partition
    from stlc.radio.samples import Samples

PROPERTIES = (
    "path_loss", "L0", "n", "d0", "fading", "deviation", "shadowing", "length", "kernel",
    "samples", "noise_floor", "bandwidth", "noise_figure", "modulation", "packet",
    "sensitivity", "rate", "partition", "cost", "bound", "cost_bound", "table", "pairs", "walls",
    "rates", "power", "frequency",
)  # fmt: skip
COSTS = ("inv_snr", "etx", "neg_log_prr", "outage", "neg_rssi", "paper_inv_rssi", "energy")
KERNELS = ("symmetrised", "paper_min")
BOUNDS = tuple(b.value for b in Bound)


def declare(statement: ast.ChannelDecl, scope: Scope, files: Files) -> None:
    """Declare a channel. Raises Mistake or Reported."""
    name = statement.name.text
    try:
        scope.channels[name] = channel(statement, scope, files)
    except (Mistake, Reported):
        scope.broken.add(name)
        raise
    scope.values[name] = ChannelName(name)
    item = next((p for p in statement.properties if p.key.text == "pairs"), None)
    if item is not None:
        listed = (p for e in item.args for p in pairs_of(scope.value(e), e.span))
        scope.pairs[name] = tuple(dict.fromkeys(listed))


def channel(statement: ast.ChannelDecl, scope: Scope, files: Files) -> Channel:
    """The channel that a block describes."""
    owner = f"channel `{statement.name.text}`"
    reader = Reader(props.block(owner, statement.properties, PROPERTIES, scope), scope)
    model, samples = _model(statement, reader, files)
    check_samples(reader.block, statement.name.text, model, scope)
    cells = _partition(statement, reader, model, scope)
    budget = link_budget(reader) if model is not None else None
    if model is not None and budget is not None:
        _check_fading(reader, model, budget)
    made = Channel(
        name=statement.name.text,
        partition=cells,
        model=model,
        budget=budget,
        cost=_cost(reader, scope),
        tables=_tables(reader, cells, files, scope),
        predicate_bound=Bound(reader.word("bound", BOUNDS, Bound.WORST.value)),
        cost_bound=Bound(reader.word("cost_bound", BOUNDS, Bound.MEAN.value)),
        auto=is_auto(reader.block.get("partition")),
        samples=samples,
        span=statement.name.span,
    )
    return made


def _partition(
    statement: ast.ChannelDecl, reader: Reader, model: ChannelModel | None, scope: Scope
) -> Partition:
    """The cells of the channel's table; Reported where the workspace itself couldn't be read."""
    item, name = reader.block.get("partition"), statement.name
    if item is None and model is None:
        why = "the table is over its cells"
        raise Mistake(missing(name.text, "partition", why, name.span))
    if scope.unread_workspace:
        raise Reported
    if scope.workspace is None:
        problem, hint = "a partition needs a workspace", "add `workspace box [0, 10] x [0, 10]`"
        span = name.span if item is None else item.span
        raise Mistake(BadChannel(span=span, channel=name.text, problem=problem, hint=hint))
    tabled = reader.block.get("table") is not None  # a station looks its cell up there
    heights = height_range(scope, name.text, tabled)
    return partition(item, model, heights, scope)


def _cost(reader: Reader, scope: Scope) -> str:
    cost = reader.word("cost", COSTS, "inv_snr")
    if cost == "paper_inv_rssi":
        scope.report.add(PaperCost(span=reader.block.by_key["cost"].span))
    return cost


def _model(
    statement: ast.ChannelDecl, reader: Reader, files: Files
) -> tuple[ChannelModel | None, Samples | None]:
    """The channel model, conditioned on or fitted to samples, and these; None for tables alone."""
    block, name = reader.block, statement.name.text
    item = block.get("samples")
    if block.get("L0", "n", "path_loss", "samples") is None and block.get("table"):
        return None, None
    source = None if item is None else sample_source(item, reader.scope)
    walls = walls_of(block, statement.name, reader.scope)
    drawn = as_radio(walls)
    if source is not None and source.fit:
        shape = FitShape(_kernel(reader), _d0(reader), drawn)
        return fitted(name, source, shape, reader.scope, files)
    known_losses(walls, statement.name)
    model = replace(_prior(statement, reader), walls=drawn)
    return (model, None) if source is None else conditioned(model, name, source, files)


def _kernel(reader: Reader) -> str:
    return reader.word("kernel", KERNELS, "symmetrised")


def _d0(reader: Reader) -> float:
    return reader.positive("d0", units.METRE) or 1.0


def _prior(statement: ast.ChannelDecl, reader: Reader) -> ChannelModel:
    """The model from the file's own parameters: L0 [dBm], n, variances [dB^2], length [m]."""
    from stlc.radio.gp import ChannelModel
    from stlc.radio.kernel import KernelName

    span, name = statement.name.span, statement.name.text
    exponent = reader.number("n", units.PURE)
    l0 = reader.number("L0", units.DBM, _free_space(reader, name, exponent))
    if l0 is None or exponent is None:
        what = "path_loss" if l0 is None else "n"
        why = (
            "L0 [dBm at 1 m] and n are needed" if l0 is None else "the path-loss exponent is needed"
        )
        raise Mistake(missing(name, what, why, span))
    shadowing = reader.variance("shadowing")
    length = reader.positive("length", units.METRE)
    if shadowing > 0 and length is None:
        problem = "shadowing needs a correlation `length`"
        raise Mistake(BadChannel(span=span, channel=name, problem=problem, hint="add `length 2 m`"))
    return ChannelModel(
        l0=l0,
        exponent=exponent,
        fading=reader.variance("fading"),
        shadowing=shadowing,
        length=length or 1.0,
        d0=_d0(reader),
        kernel=KernelName(_kernel(reader)),
        deviation=reader.variance("deviation"),
    )


def _free_space(reader: Reader, name: str, exponent: float | None) -> float | None:
    """L0 [dBm at 1 m] of a channel that gives a frequency in its place: the strength at d0 is that
    of free space, and falls with the exponent from there."""
    from stlc.radio.link_budget import free_space_loss

    frequency = reader.positive("frequency", units.HERTZ)
    if frequency is None or exponent is None or reader.block.get("L0") is not None:
        return None
    power = transmit_power(reader)
    if power is None:
        why = "strength by `frequency` needs it"
        raise Mistake(missing(name, "power", why, reader.block.by_key["frequency"].span))
    d0 = _d0(reader)
    return power - free_space_loss(d0, frequency) + 10.0 * exponent * log10(d0)


def _check_fading(reader: Reader, model: ChannelModel, budget: LinkBudget) -> None:
    """A Rayleigh modulation averages over fading already: fading of its own would count twice."""
    modulation = budget.modulation
    if modulation is None or not modulation.rayleigh or model.fading == 0:
        return
    item = reader.block.by_key["modulation"]
    plain = modulation.value.removeprefix("rayleigh_")
    raise Mistake(
        RayleighWithFading(
            span=item.span, modulation=modulation.value, fading=model.fading, plain=plain
        )
    )


def _tables(
    reader: Reader, cells: Partition, files: Files, scope: Scope
) -> dict[tuple[str, str] | None, Array]:
    """`table "cost.csv"`, or one for each pair: `table (r1, r2) "a.csv" (r1, base) "b.csv"`."""
    item = reader.block.get("table")
    if item is None:
        return {}
    found: dict[tuple[str, str] | None, Array] = {}
    pair: tuple[str, str] | None = None
    for expr in item.args:
        if isinstance(expr, ast.Tuple) and len(expr.items) == 2:
            first, second = (scope.radio(e).name for e in expr.items)
            pair = (first, second)
        elif isinstance(expr, ast.String):
            found[pair] = read_table(expr, len(cells), files)
        else:
            raise props.bad(item, "needs the name of a file", 'table "cost.csv"', expr.span)
    if not found:
        raise props.bad(item, "needs the name of a file", 'table "cost.csv"')
    return found
