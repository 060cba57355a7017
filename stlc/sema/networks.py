"""`connected(..)`, `route(..)` and `count(..)`: formulas over all links of a network.

An edge's condition is written with bare qualities, `rssi >= -70 dBm`; between two radios they are
bound to those of that link, so that any formula of one link will do.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from itertools import combinations
from math import ceil, floor

from stlc.ir.networks import COMPOSABLE, Count, Network
from stlc.ir.nodes import And, Const, Link, Node, Not, Or, Quantity, Relation
from stlc.mission import Agent, Station
from stlc.sema import link_calls
from stlc.sema.channel_errors import BadLink, BadNetwork
from stlc.sema.compare import MIRRORED, QUANTITY_UNITS, Operator
from stlc.sema.name_errors import EmptyDomain, NoPosition, WrongKind
from stlc.sema.quantifiers import instances
from stlc.sema.report import Mistake, Reported
from stlc.sema.scope import Scope, as_scalar
from stlc.sema.values import (
    ChannelName,
    Env,
    Items,
    LinkAtom,
    Radio,
    Scalar,
    Tally,
    Value,
    describe,
)
from stlc.source import Span
from stlc.syntax import ast

_QUALITIES = {"link_cost" if q is Quantity.COST else q.value: q for q in Quantity}
_ADDITIVE = ("inv_snr", "etx", "neg_log_prr", "energy")
_USAGE = {
    "connected": "connected(agents, radio, rssi >= -70 dBm)",
    "route": "route(a, base, hops <= 3, prr >= 0.9)",
}


@dataclass(slots=True)
class _Asked:
    """What a call says, sorted by kind."""

    radios: list[Agent | Station]
    relays: list[Agent | Station] | None = None
    channel: str | None = None
    hops: int | None = None
    condition: ast.Expr | None = None


def connected(expr: ast.Call, env: Env, scope: Scope) -> Node:
    """`connected(radios, channel, condition)`: the graph of links that meet it joins all."""
    asked = _asked(expr, env, scope)
    radios = list(dict.fromkeys([*asked.radios, *(asked.relays or ())]))
    if asked.hops is not None:
        raise Mistake(_bad(expr, "`hops` is for `route`", "leave it out"))
    if len(radios) < 2:
        raise Mistake(_bad(expr, "it joins two radios or more", _USAGE["connected"]))
    return _network(expr, asked, radios, None, env, scope)


def route(expr: ast.Call, env: Env, scope: Scope) -> Node:
    """`route(a, b, [relays], channel, hops <= 3, condition)`: a path from a to b."""
    asked = _asked(expr, env, scope)
    if len(asked.radios) != 2 or asked.radios[0] is asked.radios[1]:
        raise Mistake(_bad(expr, "a route leads from one radio to another", _USAGE["route"]))
    relays = asked.relays
    if relays is None:
        relays = [a for a in scope.agents.values() if a.dynamics.position is not None]
    radios = list(dict.fromkeys([*asked.radios, *relays]))
    hops = len(radios) - 1 if asked.hops is None else asked.hops
    return _network(expr, asked, radios, hops, env, scope)


CALLS = {"connected": connected, "route": route}


def _bad(expr: ast.Expr, problem: str, hint: str) -> BadNetwork:
    return BadNetwork(span=expr.span, problem=problem, hint=hint)


def _asked(expr: ast.Call, env: Env, scope: Scope) -> _Asked:
    """Arguments by kind: the condition comes last, radios first, the others in any order."""
    name = expr.function.text
    if len(expr.args) < 2:
        raise Mistake(_bad(expr, f"`{name}` needs radios and a condition", _USAGE[name]))
    asked = _Asked([], condition=expr.args[-1])
    if not _named(expr.args[-1]):
        raise Mistake(_bad(expr.args[-1], "this is no condition on a link", _USAGE[name]))
    for arg in expr.args[:-1]:
        if isinstance(arg, ast.Comparison) and _is_name(arg.operands[0], "hops"):
            asked.hops = _hops(arg, env, scope)
            continue
        value = scope.value(arg, env)
        match value:
            case ChannelName():
                asked.channel = scope.channel_name(value, arg.span)
            case Items() if asked.radios and name == "route":
                asked.relays = [*(asked.relays or ()), *_radios(value, arg.span)]
            case _:
                asked.radios += _radios(value, arg.span)
    return asked


def _named(condition: ast.Expr) -> dict[str, Quantity]:
    """The bare qualities in a condition."""
    names = {part.text for part in _parts(condition) if isinstance(part, ast.Name)}
    return {name: q for name, q in _QUALITIES.items() if name in names}


def _is_name(expr: ast.Expr, text: str) -> bool:
    return isinstance(expr, ast.Name) and expr.text == text


def _hops(expr: ast.Comparison, env: Env, scope: Scope) -> int:
    count = scope.whole(expr.operands[1], env) if expr.operators == ("<=",) else 0
    if count < 1:
        raise Mistake(_bad(expr, "`hops` has an upper limit of 1 or more", "write `hops <= 3`"))
    return count


def _radios(value: Value, span: Span) -> list[Agent | Station]:
    """Radios that a value stands for, lists within lists opened."""
    if isinstance(value, Items):
        return [radio for item in value.items for radio in _radios(item, span)]
    if not isinstance(value, Radio):
        expected = "agents or stations"
        raise Mistake(WrongKind(span=span, expected=expected, found=describe(value)))
    thing = value.thing
    if isinstance(thing, Agent) and thing.dynamics.position is None:
        raise Mistake(NoPosition(span=span, name=thing.name))
    return [thing]


def _network(
    expr: ast.Call,
    asked: _Asked,
    radios: list[Agent | Station],
    hops: int | None,
    env: Env,
    scope: Scope,
) -> Node:
    """The network over all pairs of radios; end-to-end where a route's quality has such a value."""
    condition = asked.condition
    assert condition is not None
    channel = asked.channel or link_calls.only_channel(expr.function.span, scope)
    scope.used.add(channel)
    if channel not in scope.channels:
        raise Reported
    wanted = _named(condition)
    for quantity in wanted.values():
        if quantity is not Quantity.COST:
            link_calls.check_quantity(scope.channels[channel], quantity, condition.span)
    ends = tuple(combinations(range(len(radios)), 2))
    args = []
    for a, b in ends:
        pair = (radios[a].name, radios[b].name)
        bound = {n: _quality(channel, q, pair) for n, q in wanted.items()}
        edge = replace(env, bound={**env.bound, **bound})
        args.append(scope.formula(condition, edge))
    vertices = tuple(r.name for r in radios)
    if hops is not None and hops > 1 and _has_end_to_end(args[0]):
        links = [_tight(arg, condition, scope) for arg in args]
        return Network(tuple(links), ends, vertices, hops, composed=True, span=expr.span)
    return Network(tuple(args), ends, vertices, hops, span=expr.span)


def _quality(channel: str, quantity: Quantity, pair: tuple[str, str]) -> Scalar:
    atom = LinkAtom(channel, quantity, *pair)
    return Scalar(terms=((atom, 1.0),), unit=QUANTITY_UNITS[quantity])


def _parts(expr: ast.Expr) -> Iterator[ast.Expr]:
    """An expression and all within it."""
    yield expr
    for name in type(expr).record_fields:
        found = getattr(expr, name)
        for part in found if isinstance(found, tuple) else (found,):
            if isinstance(part, ast.Expr):
                yield from _parts(part)


def _has_end_to_end(node: Node) -> bool:
    return isinstance(node, Link) and node.quantity in COMPOSABLE and node.probability is None


def _tight(node: Node, condition: ast.Expr, scope: Scope) -> Link:
    """The link whose quality is composed; its robustness counts beyond the threshold too."""
    assert isinstance(node, Link)
    wanted = Relation.AT_LEAST if node.quantity is Quantity.PRR else Relation.AT_MOST
    if node.relation is not wanted:
        hint = f"ask for {node.quantity.value} {wanted.value} a limit, perhaps under `not`"
        raise Mistake(_bad(condition, "no path is the worst one within some hops", hint))
    channel = scope.channels[node.channel]
    if node.quantity is not Quantity.COST:
        if not 0.0 < node.threshold <= 1.0:
            raise Mistake(_bad(condition, "a share lies between 0 and 1", "prr >= 0.9"))
    elif channel.tables or channel.cost not in _ADDITIVE:
        hint = f"use a cost of {', '.join(_ADDITIVE)}, or `prr`, `rssi`"
        raise Mistake(_bad(condition, "this cost does not add up along a path", hint))
    return replace(node, factor=1.0, tight=True)


# --- counts ------------------------------------------------------------------------------------


def compare_count(
    left: Value, operator: Operator, right: Value, spans: tuple[Span, Span], scope: Scope
) -> Node:
    """`count(..) >= k` and its like, with a constant k; fewer is the negation of more."""
    if not isinstance(left, Tally):
        left, operator, right, spans = right, MIRRORED[operator], left, (spans[1], spans[0])
    assert isinstance(left, Tally)
    limit = as_scalar(right, spans[1])
    if not limit.is_constant or (limit.unit is not None and limit.unit.dims):
        raise Mistake(WrongKind(span=spans[1], expected="a number", found=describe(right)))
    k, span = limit.constant, spans[0].to(spans[1])
    match operator:
        case ">=":
            return _at_least(left, ceil(k), span, scope)
        case ">":
            return _at_least(left, floor(k) + 1, span, scope)
        case "<=":
            return _fewer(left, floor(k) + 1, span, scope)
        case "<":
            return _fewer(left, ceil(k), span, scope)
    whole = k == int(k)
    least = _at_least(left, int(k), span, scope) if whole else Const(False, span=span)
    both = (least, _fewer(left, int(k) + 1, span, scope))
    if operator == "==":
        return And(both, span=span)
    more = _at_least(left, int(k) + 1, span, scope)
    less = _fewer(left, int(k), span, scope) if whole else Const(True, span=span)
    return Or((more, less), span=span)


def _fewer(tally: Tally, least: int, span: Span, scope: Scope) -> Node:
    under = replace(tally, env=replace(tally.env, positive=not tally.env.positive))
    return Not(_at_least(under, least, span, scope), span=span)


def _at_least(tally: Tally, least: int, span: Span, scope: Scope) -> Node:
    """At least so many instances; true or false where no run matters."""
    args = tuple(_instances(tally, scope))
    if least <= 0 or least > len(args):
        return Const(least <= 0, span=span)
    return args[0] if len(args) == 1 else Count(args, least, span=span)


def _instances(tally: Tally, scope: Scope) -> Iterator[Node]:
    """The body for each member of the domain; a link of a radio with itself is none."""
    empty = True
    for env in instances(tally.expr, tally.env, scope):
        try:
            node = scope.formula(tally.expr.body, env)
        except Mistake as mistake:
            found = mistake.diagnostic
            if isinstance(found, BadLink) and found.itself:
                continue
            raise
        empty = False
        yield node
    if empty:
        problem = "no member of it has a link with another"
        raise Mistake(EmptyDomain(span=tally.expr.domain.span, problem=problem))
