"""Link qualities between radios: `rssi(a, b)`, `ber(a, b)`, `P(..)`, `link_cost(radio, (a, b))`."""

from __future__ import annotations

from dataclasses import replace
from math import isnan

from stlc.ir.nodes import Linear, Link, Node, Not, Quantity
from stlc.mission import Agent, Channel, Station
from stlc.sema.allocation import allocated, packets
from stlc.sema.channel_errors import (
    BadLink,
    BadProbability,
    MissingChannelValue,
    TableOnly,
    WhichChannel,
)
from stlc.sema.compare import MIRRORED, QUANTITY_UNITS, Operator
from stlc.sema.name_errors import NoPosition, WrongArity, WrongKind
from stlc.sema.report import Mistake, Reported
from stlc.sema.scope import Scope, as_scalar
from stlc.sema.unit_errors import WrongUnit
from stlc.sema.values import (
    Chance,
    ChannelName,
    Env,
    Items,
    LinkAtom,
    Radio,
    Scalar,
    Truth,
    Value,
    describe,
)
from stlc.source import Span
from stlc.syntax import ast

USAGE = {
    "path_loss": "path_loss L0 = -40 dBm, n = 2",
    "n": "n = 2",
    "noise_floor": "noise_floor -90 dBm",
    "modulation": "modulation oqpsk_802_15_4",
    "packet": "packet 32 bytes",
    "sensitivity": "sensitivity -90 dBm",
    "power": "power 20 dBm",
    "rate": "bandwidth 2 MHz, rate 250 kbit/s",
    "partition": "partition 10 x 10",
}


def quality(expr: ast.Call, args: tuple[Value, ...], scope: Scope) -> Value:
    """`rssi(a, b)` and its like; a channel may be named third."""
    quantity = Quantity(expr.function.text)
    return Scalar(terms=((quality_of(expr, args, quantity, scope), 1.0),),
                  unit=QUANTITY_UNITS[quantity])  # fmt: skip


def quality_of(
    expr: ast.Call, args: tuple[Value, ...], quantity: Quantity, scope: Scope
) -> LinkAtom:
    """A quality of the link between two ends. Raises Mistake where the channel doesn't tell it."""
    if len(args) not in (2, 3):
        raise Mistake(_arity(expr, f"{expr.function.text}(a, b)"))
    ends = _ends(expr, args[:2])
    channel = _which(args[2] if len(args) == 3 else None, expr, scope)
    check_quantity(scope.channels[channel], quantity, expr.span)
    return LinkAtom(channel, quantity, *ends)


def cost(expr: ast.Call, args: tuple[Value, ...], scope: Scope) -> Value:
    """`link_cost(radio, (a, b))`, or `link_cost((a, b))`, inside a formula."""
    named = len(args) == 2
    pair = args[-1] if args else None
    if len(args) not in (1, 2) or not isinstance(pair, Items) or len(pair.items) != 2:
        raise Mistake(_arity(expr, "link_cost(radio, (a, b))"))
    channel = _which(args[0] if named else None, expr, scope)
    return Scalar(terms=((LinkAtom(channel, Quantity.COST, *_ends(expr, pair.items)), 1.0),))


def _arity(expr: ast.Call, usage: str) -> WrongArity:
    return WrongArity(
        span=expr.span,
        name=expr.function.text,
        expected="two ends",
        found=len(expr.args),
        usage=usage,
    )


def _ends(expr: ast.Call, values: tuple[Value, ...]) -> tuple[str, str]:
    """Names of sender and receiver: two different ones, not both stations."""
    things = tuple(_radio(v, expr.span) for v in values)
    a, b = things
    if a.name == b.name:
        raise Mistake(
            BadLink(
                span=expr.span,
                problem=f"`{a.name}` has no link with itself",
                hint=_TWO,
                itself=True,
            )
        )
    if isinstance(a, Station) and isinstance(b, Station):
        problem = "a link between two stations never changes"
        raise Mistake(BadLink(span=expr.span, problem=problem, hint=_TWO))
    return a.name, b.name


_TWO = "name two agents, or an agent and a station"


def _radio(value: Value, span: Span) -> Agent | Station:
    if not isinstance(value, Radio):
        expected = "an agent or a station"
        raise Mistake(WrongKind(span=span, expected=expected, found=describe(value)))
    thing = value.thing
    if isinstance(thing, Agent) and thing.dynamics.position is None:
        raise Mistake(NoPosition(span=span, name=thing.name))
    return thing


def _which(value: Value | None, expr: ast.Call, scope: Scope) -> str:
    """The channel that is meant."""
    if value is not None and not isinstance(value, ChannelName):
        found = describe(value)
        raise Mistake(WrongKind(span=expr.args[-1].span, expected="a channel", found=found))
    name = value.name if value is not None else only_channel(expr.function.span, scope)
    scope.used.add(name)
    if name not in scope.channels:
        raise Reported
    return name


def only_channel(span: Span, scope: Scope) -> str:
    """The mission's one channel. Raises Mistake when it has none or several."""
    names = [n for n, d in scope.declarations.items() if isinstance(d, ast.ChannelDecl)]
    if len(names) == 1:
        return names[0]
    if not names and "channel" in scope.broken:
        raise Reported
    if not names:
        hint = "declare one: `channel radio { path_loss L0 = -40 dBm, n = 2; partition 10 x 10 }`"
        raise Mistake(WhichChannel(span=span, found="the mission has no channel", hint=hint))
    found = "the mission has " + " and ".join(f"`{n}`" for n in names)
    raise Mistake(WhichChannel(span=span, found=found, hint=f"name it last: `.., {names[0]})`"))


def check_quantity(channel: Channel, quantity: Quantity, span: Span) -> None:
    """Raise Mistake unless the channel has what the quantity needs."""
    if channel.model is None:
        raise Mistake(TableOnly(span=span, channel=channel.name, quantity=quantity.value))
    if quantity is Quantity.RSSI:
        return
    why = f"`{quantity.value}` needs it"
    budget = channel.budget
    if budget is None or isnan(budget.noise_floor):
        raise Mistake(missing(channel.name, "noise_floor", why, span))
    if quantity is not Quantity.SNR and budget.modulation is None:
        raise Mistake(missing(channel.name, "modulation", why, span))
    if quantity is Quantity.PRR and budget.packet is None:
        raise Mistake(missing(channel.name, "packet", why, span))


def missing(channel: str, what: str, why: str, span: Span | None) -> MissingChannelValue:
    """The diagnostic for a value that a channel lacks."""
    return MissingChannelValue(span=span, channel=channel, what=what, why=why, usage=USAGE[what])


def chance(expr: ast.Call, env: Env, scope: Scope) -> Value:
    """`P(rssi(a, b) >= -70 dBm)`, or of several packets, to be compared with a probability."""
    if len(expr.args) != 1:
        raise Mistake(_arity(expr, "P(rssi(a, b) >= -70 dBm) >= 0.95"))
    value = scope.value(expr.args[0], env)
    node = value.node if isinstance(value, Truth) else None
    if isinstance(node, Link) and node.quantity is not Quantity.COST:
        return Chance(replace(node, factor=1.0))  # its robustness is that of the level reached
    if node is not None and not isinstance(node, Link | Linear | Not):
        packets(node)  # its mistakes are told here
        return Chance(node)
    raise Mistake(
        BadLink(
            span=expr.args[0].span,
            problem="`P(..)` takes comparisons of link qualities with constants",
            hint="write `P(rssi(a, b) >= -70 dBm) >= 0.95`",
        )
    )


def compare_chance(
    left: Value, operator: Operator, right: Value, spans: tuple[Span, Span], positive: bool
) -> Node:
    """`P(link) >= p`; `<=` is the negation, `p <= P(link)` the mirror image. Of several packets
    only `>=` has a meaning, and not under a negation."""
    if not isinstance(left, Chance):
        left, operator, right, spans = right, MIRRORED[operator], left, (spans[1], spans[0])
    if not isinstance(left, Chance) or operator in ("==", "!="):
        problem = "a chance is compared by `>=` or `<=` with a constant"
        raise Mistake(BadLink(span=spans[0], problem=problem))
    whole = spans[0].to(spans[1])
    p = _probability(right, spans[1])
    if not isinstance(left.link, Link):
        return _together(left.link, p, operator in (">", ">=") and positive, whole)
    if operator in (">", ">="):
        return replace(left.link, probability=p, span=whole)
    return Not(replace(left.link, probability=p, span=whole), span=whole)


def _together(node: Node, probability: float, sound: bool, span: Span) -> Node:
    """A chance of several packets together, where a sufficient condition will do."""
    if not sound:
        problem = "a chance of several packets is only known from below"
        hint = "compare it by `>=`, under no negation and not left of an implication"
        raise Mistake(BadLink(span=span, problem=problem, hint=hint))
    return replace(allocated(node, probability), span=span)


def _probability(value: Value, span: Span) -> float:
    scalar = as_scalar(value, span)
    if not scalar.is_constant:
        raise Mistake(WrongKind(span=span, expected="a constant", found=describe(value)))
    if scalar.unit is not None and scalar.unit.dims:
        raise Mistake(WrongUnit(span=span, expected="a probability", found=str(scalar.unit)))
    if not 0.0 < scalar.constant < 1.0:
        raise Mistake(BadProbability(span=span, value=scalar.constant))
    return scalar.constant
