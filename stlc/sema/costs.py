"""One cost of the objective: `effort(r1)[0, 4]`, `link_cost(radio, (r1, r2))`, `robustness`."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from math import isnan

from stlc.mission import Agent, Channel, ObjectiveTerm, TermKind
from stlc.scales import unbounded
from stlc.sema import clock
from stlc.sema.channel_errors import BadChannel, BadLink
from stlc.sema.durations import duration
from stlc.sema.link_calls import missing, only_channel
from stlc.sema.name_errors import UnknownName, WrongKind
from stlc.sema.objective_errors import BadObjective
from stlc.sema.report import Mistake, Reported, nearest, suggested_fix, suggestion
from stlc.sema.scope import Scope, as_scalar
from stlc.sema.time_errors import ReversedInterval
from stlc.sema.totals import total
from stlc.sema.values import ChannelName, Env, Items, Radio, Value, describe
from stlc.source import Span
from stlc.syntax import ast

COSTS = ("effort", "link_cost", "robustness", "time", "total", "normalised", "normalized")

Pair = tuple[str, str]

_BY_PACKET = ("etx", "neg_log_prr", "energy")


def is_cost(expr: ast.Expr, env: Env, scope: Scope) -> bool:
    """True when a cost stands somewhere in the expression."""
    match expr:
        case ast.Name(text=text):
            if text in env.bound:
                return False
            found = scope.declarations.get(text)
            if isinstance(found, ast.Let) and not found.parameters:
                return text not in scope.evaluating and _names_cost(found, scope)
            return found is None and text in COSTS
        case ast.Call(function=function):
            return function.text in COSTS
        case ast.Index(base=base):
            return is_cost(base, env, scope)
        case ast.Negate(arg=arg):
            return is_cost(arg, env, scope)
        case ast.Arithmetic(spine=chain):
            operands = (chain[0].left, *(link.right for link in chain))
            return any(is_cost(operand, env, scope) for operand in operands)
        case ast.Quantifier(kind="sum", body=body):
            return is_cost(body, env, scope)
    return False


def _names_cost(let: ast.Let, scope: Scope) -> bool:
    """Whether the body of a plain `let` holds a cost; each is looked through once."""
    name = let.name.text
    if name not in scope.cost_lets:
        scope.cost_lets[name] = False  # while it is looked through: a cycle holds none
        scope.cost_lets[name] = is_cost(let.body, Env({}), scope)
    return scope.cost_lets[name]


def cost_term(expr: ast.Expr, weight: float, env: Env, scope: Scope) -> ObjectiveTerm:
    """The term of one cost. Raises Mistake."""
    if isinstance(expr, ast.Index):
        term = cost_term(expr.base, weight, env, scope)
        if term.kind is TermKind.VIOLATION:
            raise Mistake(BadObjective(span=expr.span, problem="a time has no window"))
        return replace(term, window=_window(expr, env, scope), span=expr.span)
    name, args = _head(expr)
    match name:
        case "effort":
            return _effort(expr, args, weight, env, scope)
        case "link_cost":
            return _link_cost(expr, args, weight, env, scope)
        case "robustness":
            return _robustness(expr, args, weight, env, scope)
        case "time":
            return duration(expr, args, weight, env, scope)
        case "total":
            return total(expr, args, weight, env, scope)
        case "normalised" | "normalized" if len(args) == 1:
            inner = cost_term(args[0], weight, env, scope)
            if inner.kind is TermKind.ROBUSTNESS:
                raise Mistake(BadObjective(span=expr.span, problem="robustness isn't a cost"))
            if inner.kind in (TermKind.VIOLATION, TermKind.TOTAL):
                what = "time" if inner.kind is TermKind.VIOLATION else "total"
                raise Mistake(BadObjective(span=expr.span, problem=f"a {what} has no static range"))
            _check_range(inner, expr.span, scope)
            return replace(inner, normalised=True, span=expr.span)
    problem = "a constant adds nothing" if isinstance(expr, ast.Number) else "this is not a cost"
    near = nearest(name, COSTS)
    if name in scope.declarations or near is None:
        raise Mistake(BadObjective(span=expr.span, problem=problem))
    raise Mistake(BadObjective(span=expr.span, problem=problem, hint=f"did you mean `{near}`?"))


def _head(expr: ast.Expr) -> tuple[str, tuple[ast.Expr, ...]]:
    if isinstance(expr, ast.Call):
        return expr.function.text, expr.args
    return (expr.text, ()) if isinstance(expr, ast.Name) else ("", ())


def _window(expr: ast.Index, env: Env, scope: Scope) -> tuple[int, int]:
    if len(expr.indices) != 2:
        problem = "a window has a first and a last step"
        raise Mistake(BadObjective(span=expr.span, problem=problem, hint="write `effort[0, 4]`"))
    start, end = (clock.steps(e, scope, env) for e in expr.indices)
    if end < start:
        raise Mistake(ReversedInterval(span=expr.span, start=start, end=end))
    return start, end


# --- effort ------------------------------------------------------------------------------------


def _effort(
    expr: ast.Expr, args: tuple[ast.Expr, ...], weight: float, env: Env, scope: Scope
) -> ObjectiveTerm:
    if args:
        agents = tuple(n for a in args for n in _agents(scope.value(a, env), a.span))
    else:
        agents = tuple(scope.agents)
    _each_once([(name,) for name in agents], expr.span)
    return ObjectiveTerm(TermKind.EFFORT, weight, agents=agents, span=expr.span)


def _check_range(term: ObjectiveTerm, span: Span, scope: Scope) -> None:
    """Raise Mistake where a cost has no static range to be divided by."""
    for name in term.agents:
        what = unbounded(scope.agents[name])
        if what is not None:
            problem = f"`{name}` has no bound on some {what} that effort weighs"
            hint = f"give every {what} that it weighs a range, or leave `normalised` out"
            raise Mistake(BadObjective(span=span, problem=problem, hint=hint))


def _agents(value: Value, span: Span) -> list[str]:
    if isinstance(value, Items):
        return [n for item in value.items for n in _agents(item, span)]
    if isinstance(value, Radio) and isinstance(value.thing, Agent):
        return [value.name]
    raise Mistake(WrongKind(span=span, expected="an agent", found=describe(value)))


def _each_once(members: Sequence[tuple[str, ...]], span: Span) -> None:
    """Raise Mistake where a cost would count an agent or an unordered pair twice."""
    seen: set[frozenset[str]] = set()
    for member in members:
        if frozenset(member) in seen:
            problem = f"`{', '.join(member)}` is listed twice"
            raise Mistake(BadObjective(span=span, problem=problem, hint=_ONCE))
        seen.add(frozenset(member))


_ONCE = "list it once; a weight makes it count more: `2 * effort(r1)`"


# --- link cost -----------------------------------------------------------------------------------


def _link_cost(
    expr: ast.Expr, args: tuple[ast.Expr, ...], weight: float, env: Env, scope: Scope
) -> ObjectiveTerm:
    """`link_cost([channel,] pairs)`, by default of the named pairs, or of the only one."""
    values = [scope.value(a, env) for a in args]
    if values and isinstance(values[0], ChannelName):
        name = values.pop(0)
        assert isinstance(name, ChannelName)
        channel_name = name.name
    else:
        channel_name = only_channel(expr.span, scope)
        scope.used.add(channel_name)
    if channel_name not in scope.channels:
        raise Reported
    channel = scope.channels[channel_name]
    pairs = tuple(p for v in values for p in pairs_of(v, expr.span)) if values else ()
    pairs = pairs or scope.pairs.get(channel_name) or default_pairs(expr.span, scope)
    _each_once(pairs, expr.span)
    check_cost(channel, pairs, expr.span)
    return ObjectiveTerm(
        TermKind.LINK_COST, weight, channel=channel_name, pairs=pairs, span=expr.span
    )


def pairs_of(value: Value, span: Span) -> list[Pair]:
    """A pair of radios, or a list of pairs."""
    if isinstance(value, Items):
        if len(value.items) == 2 and all(isinstance(i, Radio) for i in value.items):
            a, b = (i.name for i in value.items if isinstance(i, Radio))
            if a == b:
                raise Mistake(BadLink(span=span, problem=f"`{a}` has no link with itself"))
            return [(a, b)]
        return [p for item in value.items for p in pairs_of(item, span)]
    raise Mistake(WrongKind(span=span, expected="a pair `(a, b)`", found=describe(value)))


def default_pairs(span: Span, scope: Scope) -> tuple[Pair, ...]:
    """Every pair of agents; with a single agent, its links to the stations."""
    agents = list(scope.agents)
    pairs = tuple((a, b) for k, a in enumerate(agents) for b in agents[k + 1 :])
    if not pairs and agents:
        pairs = tuple((agents[0], s) for s in scope.stations)
    if not pairs:
        hint = "a link cost needs two agents, or an agent and a station"
        raise Mistake(BadObjective(span=span, problem="there is no link", hint=hint))
    return pairs


def check_cost(channel: Channel, pairs: tuple[Pair, ...], span: Span) -> None:
    """Raise Mistake unless the channel can price these links."""
    if channel.model is None:
        _check_tables(channel, pairs, span)
        return
    budget = channel.budget
    if budget is None or all(channel.has_table(pair) for pair in pairs):
        return
    cost, name = channel.cost, channel.name
    why = f"the link cost `{cost}` needs it"
    if cost in ("inv_snr", *_BY_PACKET) and isnan(budget.noise_floor):
        raise Mistake(missing(name, "noise_floor", why, span))
    if cost in _BY_PACKET and budget.modulation is None:
        raise Mistake(missing(name, "modulation", why, span))
    if cost in _BY_PACKET and budget.packet is None:
        raise Mistake(missing(name, "packet", why, span))
    if cost == "energy" and budget.power is None:
        raise Mistake(missing(name, "power", why, span))
    if cost == "energy" and budget.rate is None:
        raise Mistake(missing(name, "rate", why, span))
    if cost == "outage" and budget.sensitivity is None:
        raise Mistake(missing(name, "sensitivity", why, span))


def _check_tables(channel: Channel, pairs: tuple[Pair, ...], span: Span) -> None:
    for a, b in pairs:
        if not channel.has_table((a, b)):
            problem = f"it has no table for ({a}, {b})"
            hint = f'add `table ({a}, {b}) "cost.csv"`'
            raise Mistake(BadChannel(span=span, channel=channel.name, problem=problem, hint=hint))


# --- robustness ----------------------------------------------------------------------------------


def _robustness(
    expr: ast.Expr, args: tuple[ast.Expr, ...], weight: float, env: Env, scope: Scope
) -> ObjectiveTerm:
    """`robustness([requirement,] [scale(...)])`, over all requirements where none is named."""
    requirement: str | None = None
    scales: dict[str, float] = {}
    for arg in args:
        if isinstance(arg, ast.Call) and arg.function.text == "scale":
            scales = _scales(arg, env, scope)
        else:
            requirement = _requirement(arg, scope)
    return ObjectiveTerm(
        TermKind.ROBUSTNESS, weight, requirement=requirement, scales=scales, span=expr.span
    )


def _scales(expr: ast.Call, env: Env, scope: Scope) -> dict[str, float]:
    scales: dict[str, float] = {}
    for arg in expr.args:
        scalar = as_scalar(scope.value(arg, env), arg.span)
        unit = "" if scalar.unit is None else str(scalar.unit)
        if not scalar.is_constant or scalar.constant <= 0 or unit in scales:
            problem = "a scale is a positive constant, one for each unit"
            raise Mistake(BadObjective(span=arg.span, problem=problem, hint="scale(1 m, 10 dB)"))
        scales[unit] = scalar.constant
    return scales


def _requirement(expr: ast.Expr, scope: Scope) -> str:
    name = expr.text if isinstance(expr, ast.Name) else ""
    if name in scope.requirements:
        return name
    hint = suggestion(name, scope.requirements, "name a `require`, or leave the brackets out")
    fix = suggested_fix(expr.span, name, scope.requirements)
    raise Mistake(UnknownName(span=expr.span, name=expr.span.text, hint=hint, fix=fix))
