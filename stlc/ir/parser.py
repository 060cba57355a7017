"""Reads the text that `printer.py` writes: print and parse are inverse, spans excepted."""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import dataclass, field

from stlc.errors import UsageError
from stlc.ir.networks import Count, Network
from stlc.ir.nodes import (
    Always,
    And,
    Const,
    Eventually,
    Iff,
    Implies,
    Linear,
    Link,
    Node,
    Not,
    Or,
    Quantity,
    Relation,
    Release,
    Role,
    Signal,
    Timed,
    Until,
)
from stlc.ir.requirement import Requirement

_TOKEN = re.compile(
    r'\s*(?:(?P<number>[-+]?(?:\d+\.?\d*(?:[eE][-+]?\d+)?|inf\b))|(?P<quoted>"[^"]*")'
    r"|(?P<ref>%\d+)|(?P<relation>>=|<=)|(?P<word>[A-Za-z_]\w*)|(?P<mark>[\[\](),.:*+@=/^]))"
)
_UNIT = re.compile(r"\s*:\s*([^\]]+)\]")

_NARY: dict[str, Callable[[tuple[Node, ...]], Node]] = {"and": And, "or": Or, "timed": Timed}
_FIXED: dict[str, tuple[int, Callable[..., Node]]] = {
    "not": (1, Not), "implies": (2, Implies), "iff": (2, Iff), "always": (1, Always),
    "eventually": (1, Eventually), "until": (2, Until), "release": (2, Release),
}  # fmt: skip
_NETWORKS = ("joined", "parted", "relayed", "unrelayed")
_TEMPORAL = frozenset({"always", "eventually", "until", "release"})


def parse_program(text: str) -> tuple[tuple[Requirement, ...], int]:
    """Requirements and horizon of a printed program; UsageError where the text is not one."""
    horizon = 0
    known: dict[str, Node] = {}
    requirements: list[Requirement] = []
    for number, line in enumerate(text.splitlines(), 1):
        reader = _Reader(line, number, known)
        if reader.done():
            continue
        match reader.peek():
            case "horizon":
                reader.take("horizon")
                horizon = int(reader.number())
            case "require":
                requirements.append(reader.requirement())
            case name if name.startswith("%"):
                reader.take(name)
                reader.take("=")
                known[name] = reader.node()
            case other:
                raise reader.error(f"expected a line of a program, not {other!r}")
        reader.end()
    return tuple(requirements), horizon


def parse_node(text: str) -> Node:
    """One printed formula, with the `%k = ...` lines before it."""
    known: dict[str, Node] = {}
    result: Node | None = None
    for number, line in enumerate(text.splitlines(), 1):
        reader = _Reader(line, number, known)
        if reader.done():
            continue
        if re.match(r"\s*%\d+\s*=", line):
            name = reader.pop()
            reader.take("=")
            known[name] = reader.node()
        else:
            result = reader.node()
        reader.end()
    if result is None:
        raise UsageError("no formula in the text")
    return result


@dataclass(slots=True)
class _Reader:
    line: str
    number_of_line: int
    known: dict[str, Node]
    place: int = 0
    _ahead: str | None = field(default=None)

    def error(self, message: str) -> UsageError:
        """An error at the present place of the line."""
        return UsageError(f"line {self.number_of_line}, column {self.place + 1}: {message}")

    def done(self) -> bool:
        """Whether nothing is left on the line."""
        return not self.line[self.place :].strip()

    def end(self) -> None:
        """UsageError unless the line is used up."""
        if not self.done():
            raise self.error("unexpected text after the end")

    def peek(self) -> str:
        """The next token, left where it is."""
        found = _TOKEN.match(self.line, self.place)
        if found is None:
            raise self.error("unexpected end" if self.done() else "unexpected character")
        return found.group(0).strip()

    def pop(self) -> str:
        """The next token, consumed."""
        token = self.peek()
        found = _TOKEN.match(self.line, self.place)
        assert found is not None
        self.place = found.end()
        return token

    def take(self, wanted: str) -> None:
        """Consume a token that has to come next."""
        token = self.peek()
        if token != wanted:
            raise self.error(f"expected {wanted!r}, not {token!r}")
        self.pop()

    def skip(self, wanted: str) -> bool:
        """Consume a token if it comes next; whether it did."""
        if self.done() or self.peek() != wanted:
            return False
        self.pop()
        return True

    def number(self) -> float:
        """A number, `inf` among them."""
        token = self.pop()
        try:
            return float(token)
        except ValueError:
            raise self.error(f"expected a number, not {token!r}") from None

    def name(self) -> str:
        """A name, without the quotes that it may stand in."""
        return self.pop().strip('"')

    def requirement(self) -> Requirement:
        """`require NAME >= MARGIN : NODE`."""
        self.take("require")
        name = self.name()
        self.take(">=")
        margin = self.number()
        self.take(":")
        return Requirement(name, self.node(), margin)

    def node(self) -> Node:
        """Any formula; `%k` is one that an earlier line has defined."""
        token = self.pop()
        if token in ("true", "false"):
            return Const(token == "true")
        if token.startswith("%"):
            if token not in self.known:
                raise self.error(f"{token} is not defined above")
            return self.known[token]
        if token == "[":
            return self.linear()
        if token == "link":
            return self.link()
        if token == "count":
            return self.count()
        if token in _NETWORKS:
            return self.network(token)
        if token in _NARY:
            return _NARY[token](tuple(self.arguments()))
        if token in _FIXED:
            return self.fixed(token)
        raise self.error(f"expected a formula, not {token!r}")

    def arguments(self) -> list[Node]:
        """`(NODE, NODE, ...)`."""
        numbers, found = self.numbered()
        if numbers:
            raise self.error(f"expected a formula, not {numbers[0]}")
        return found

    def numbered(self) -> tuple[list[int], list[Node]]:
        """`(0 1 NODE, 2 NODE, ...)`: the whole numbers before the formulas, and these."""
        self.take("(")
        numbers: list[int] = []
        found: list[Node] = []
        while not self.skip(")"):
            if found:
                self.take(",")
            while self.peek()[0].isdigit():
                numbers.append(int(self.number()))
            found.append(self.node())
        return numbers, found

    def count(self) -> Count:
        """`[least](NODE, ...)`, each NODE behind its weight if it has one."""
        self.take("[")
        least = int(self.number())
        self.take("]")
        weights, args = self.numbered()
        return Count(tuple(args), least, tuple(weights))

    def network(self, word: str) -> Network:
        """`[hops : vertex, ...](end end NODE, ...)`; hops may be left out."""
        self.take("[")
        hops = int(self.number()) if self.peek()[0].isdigit() else None
        if hops is not None:
            self.take(":")
        vertices = [self.name()]
        while self.skip(","):
            vertices.append(self.name())
        self.take("]")
        numbers, args = self.numbered()
        if len(numbers) != 2 * len(args):
            raise self.error(f"{word} takes the two ends of each of its {len(args)} edges")
        ends = zip(numbers[::2], numbers[1::2], strict=True)
        composed, cut = (bool(k) for k in divmod(_NETWORKS.index(word), 2))
        return Network(tuple(args), tuple(ends), tuple(vertices), hops, cut, composed)

    def fixed(self, word: str) -> Node:
        """An operator of so many arguments, with its window if it is temporal."""
        count, build = _FIXED[word]
        window = self.window() if word in _TEMPORAL else ()
        args = self.arguments()
        if len(args) != count:
            raise self.error(f"{word} takes {count} formulas, not {len(args)}")
        return build(*args, *window)

    def window(self) -> tuple[int, int | None]:
        """`[a,b]`; b may be `inf`."""
        self.take("[")
        start = int(self.number())
        self.take(",")
        end = self.number()
        self.take("]")
        return start, None if end == float("inf") else int(end)

    def linear(self) -> Linear:
        """`c*SIGNAL + ... + CONSTANT]`, a unit after the constant if it has one."""
        terms: list[tuple[Signal, float]] = []
        value = self.number()
        while self.skip("*"):
            terms.append((self.signal(), value))
            self.take("+")
            value = self.number()
        unit = _UNIT.match(self.line, self.place)
        if unit is None:
            self.take("]")
            return Linear(tuple(terms), value)
        self.place = unit.end()
        return Linear(tuple(terms), value, unit.group(1).strip())

    def signal(self) -> Signal:
        """`owner.role.index@shift`."""
        owner = self.name()
        self.take(".")
        role = self.pop()
        if role not in {r.value for r in Role}:
            raise self.error(f"expected state, input or free, not {role!r}")
        self.take(".")
        index = int(self.number())
        return Signal(owner, Role(role), index, self.shift())

    def shift(self) -> int:
        """`@k`, 0 where it is left out."""
        return int(self.number()) if self.skip("@") else 0

    def link(self) -> Link:
        """`(channel quantity(sender, receiver) relation threshold ...)`."""
        self.take("(")
        channel = self.name()
        quantity = Quantity(self.name())
        self.take("(")
        sender = self.name()
        self.take(",")
        receiver = self.name()
        self.take(")")
        relation = Relation(self.pop())
        threshold = self.number()
        probability = self.number() if self.skip("p") else None
        shift = self.shift()
        factor = self.number() if self.skip("times") else 1.0
        end = (relation, threshold, probability, shift, factor, self.skip("tight"))
        self.take(")")
        return Link(channel, quantity, sender, receiver, *end)
