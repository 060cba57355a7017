"""Damage to the text of a mission."""

from __future__ import annotations

import random
import re
from collections.abc import Callable, Sequence

from fuzz.tokens import change_one

TOKEN = re.compile(
    r"\s+|#[^\n]*|\"[^\"\n]*\"|\d+\.?\d*(?:[eE][-+]?\d+)?|\w+|<=|>=|==|->|\.\.|.", re.S
)
NUMBER = re.compile(r"(?<![\w.])\d+\.?\d*(?:[eE][-+]?\d+)?")
BOX = re.compile(r"box\s*\[([^\],]+),([^\]]+)\]\s*x\s*\[([^\],]+),([^\]]+)\]")
RING = re.compile(r"polygon((?:\s*\([^()]*\))+)")
INTERVAL = re.compile(r"(always|eventually|until|release|[GFUR])(\s*_?\[[^\]]*\])?(?=\W)")
POINT = re.compile(r"\([^()]*\)")

NASTY = (
    "0", "-0", "0.0", "1", "-1", "2", "0.5", "1e-320", "5e-324", "1e-300", "1e-12", "1e-9", "1e-6",
    "1e6", "1e9", "1e12", "1e15", "1e16", "1e18", "1e100", "1e200", "1e300", "1e308", "1e309",
    "123456789012345678901234567890", "9" * 400, "0.1" + "3" * 60, "0." + "0" * 320 + "1",
    "9007199254740993", "2147483648", "4294967296", "99999", "1000000", "nan", "inf", "-inf",
    "1e", "1.", ".5", "1_000", "0x10", "1,5", "٣", "1/0", "0/0", "10^400", "(-8)^0.5", "-1e-320",
    "sqrt(-1)", "log(0)", "exp(1000)", "i", "r1",
)  # fmt: skip
UNITS = (
    "m", "s", "ms", "km", "cm", "mm", "kg", "g", "N", "Hz", "MHz", "dB", "dBm", "W", "mW", "min",
    "h", "deg", "rad", "m/s", "m/s^2", "dB^2", "bytes", "bit", "percent", "%", "um", "ns", "",
)  # fmt: skip
WRAPS = (
    "not ({})", "always ({})", "eventually ({})", "({}) or ({})", "({}) and not ({})",
    "({}) until[0, 2] ({})", "({}) release[1, 3] ({})", "({}) iff ({})", "({}) implies ({})",
    "next ({})", "forall k in 0..2: always[k, k + 1] ({})", "always[0, 2] eventually[0, 2] ({})",
    "exists a in agents: ({})",
)  # fmt: skip
EXTRA = (
    "obstacle fz = box [4, 5] x [-1, 5] + box [4, 5] x [5, 11]",
    "obstacle fz = polygon (3, 3) (7, 3) (7, 7) (3, 7) hole (4, 4) (6, 4) (6, 6) (4, 6)",
    "obstacle fz = moving { 0: box [4, 5] x [4, 5]; 2: box [5, 6] x [4, 5] } inflate 0.2 m",
    "region fz = polygon (0, 0) (4, 0) (4, 4) (2, 2) (0, 4)",
    "require fz: always forall a in agents: forall o in obstacles: a outside o swept",
    "require fz: always forall (a, b) in pairs: separation(a, b) >= 0.5 m swept",
    "require fz: eventually exists a in agents: exists g in regions: a in g",
    "require fz: always forall a in agents: norm(a.v) <= 1", "maximize robustness",
    "minimize effort + 0.1 * effort[0, 2]", "margin 0.1", "horizon 6", "step 0.5 s",
    "param fz = 2 m/s", "let fz(a) = always a.x >= 0 m", "station fz at (5, 5) { height 3 m }",
    "agent fz[1..3] : double_integrator { start (2 * i, 1); control |u| <= 1 }",
    "agent fz : single_integrator { start (1, 1); control |u| <= 1; integer }",
)  # fmt: skip

Mutator = Callable[[random.Random, str, str], str]


def damaged(rng: random.Random, text: str, other: str) -> str:
    """A few changes; `other` is another mission to take pieces from."""
    for _ in range(rng.choice((1, 1, 1, 2, 2, 3, 5))):
        text = rng.choices(MUTATORS, WEIGHTS)[0](rng, text, other)
    return text


def _replaced(text: str, at: re.Match[str], new: str) -> str:
    return text[: at.start()] + new + text[at.end() :]


def _pick(rng: random.Random, pattern: re.Pattern[str], text: str) -> re.Match[str] | None:
    found = list(pattern.finditer(text))
    return rng.choice(found) if found else None


def number(rng: random.Random, text: str, other: str) -> str:
    """One number becomes a nasty one, or a near one."""
    at = _pick(rng, NUMBER, text)
    if at is None:
        return text
    value = float(at[0])
    if rng.random() < 0.5 or abs(value) > 1e300:
        return _replaced(text, at, rng.choice(NASTY))
    near = rng.choice((
        -value, value * 10, value / 10, value * 1e3, value + 1e-9, value - 1e-7, value + 1e-6,
        value * (1 + 2**-52), round(value), value + 0.5, 10 - value, value * 1e-3,
    ))  # fmt: skip
    return _replaced(text, at, repr(near))


def copied_number(rng: random.Random, text: str, other: str) -> str:
    """A number takes the value of another: shapes touch, are flush, empty, or coincide."""
    at, source = _pick(rng, NUMBER, text), _pick(rng, NUMBER, text)
    return text if at is None or source is None else _replaced(text, at, source[0])


def unit(rng: random.Random, text: str, other: str) -> str:
    """A number's unit is changed, added or removed."""
    at = _pick(rng, re.compile(NUMBER.pattern + r"( [A-Za-z%][\w/^]*)?"), text)
    if at is None:
        return text
    return _replaced(text, at, f"{NUMBER.match(at[0])[0]} {rng.choice(UNITS)}".rstrip())  # type: ignore[index]


def tokens(rng: random.Random, text: str, other: str) -> str:
    """Tokens left out, doubled, exchanged, or taken from another mission."""
    made, theirs = TOKEN.findall(text), TOKEN.findall(other)
    if not made or not theirs:
        return text
    change_one(rng, made, theirs)
    return "".join(made)


def lines(rng: random.Random, text: str, other: str) -> str:
    """Lines left out, doubled, moved, or taken from another mission."""
    made = text.split("\n")
    at = rng.randrange(len(made))
    match rng.randrange(4):
        case 0:
            del made[at]
        case 1:
            made.insert(rng.randrange(len(made) + 1), made[at])
        case 2:
            made.insert(rng.randrange(len(made)), made.pop(at))
        case _:
            made.insert(at, rng.choice(other.split("\n")))
    return "\n".join(made)


def wrapped(rng: random.Random, text: str, other: str) -> str:
    """A requirement's formula under one more operator."""
    at = _pick(rng, re.compile(r"^(require[^:\n]*:)([^\n#]+)$", re.M), text)
    if at is None:
        return text
    body = rng.choice(WRAPS).replace("{}", at[2].strip())
    return _replaced(text, at, f"{at[1]} {body}")


def interval(rng: random.Random, text: str, other: str) -> str:
    """A temporal operator's window."""
    at = _pick(rng, INTERVAL, text)
    if at is None:
        return text
    a, b = rng.choice((0, 0, 1, 2, 3, 7)), rng.choice((0, 1, 2, 3, 5, 8, 40, 5000))
    made = rng.choice((
        f"[{a}, {b}]", f"[{a}, {a}]", f"[{b}, end]", f"[{a}]", f"[{a}, inf]", "", f"[{a} s, {b} s]",
        f"[{a}:{b}]", f"[{a}, {b} ms]", "[-1, 3]", "[0, 2.5]", "[0, 1e9]", "[0, 99999999999999]",
    ))  # fmt: skip
    return _replaced(text, at, at[1] + made)


def geometry(rng: random.Random, text: str, other: str) -> str:
    """A ring with repeated, collinear, crossing or touching corners; a box that is flat or huge."""
    at = _pick(rng, RING, text) if rng.random() < 0.5 else None
    if at is not None:
        return _replaced(text, at, "polygon " + " ".join(_ring(rng, POINT.findall(at[1]))))
    at = _pick(rng, BOX, text)
    return (
        text
        if at is None
        else _replaced(text, at, _box(rng, [at[k].strip() for k in (1, 2, 3, 4)]))
    )


def _ring(rng: random.Random, points: list[str]) -> list[str]:
    at, second = rng.randrange(len(points)), rng.randrange(len(points))
    match rng.randrange(8):
        case 0:
            points.insert(at, points[at])
        case 1:
            points.insert(at, points[second])
        case 2:
            points[at], points[second] = points[second], points[at]
        case 3:
            points.reverse()
        case 4:
            points = points + points
        case 5:
            points = [*points, "hole", *points[: rng.randint(2, 4)]]
        case 6:
            del points[at]
        case _:
            points = [*points, "hole", *_shrunk(points)]
    return points


def _shrunk(points: Sequence[str]) -> list[str]:
    share = "0.5" if len(points) % 2 else "1"
    return [p.replace("(", f"({share} * ", 1) for p in points if p.startswith("(")]


def _box(rng: random.Random, ends: list[str]) -> str:
    x0, x1, y0, y1 = ends
    match rng.randrange(9):
        case 0:
            x1 = x0
        case 1:
            x0, x1 = x1, x0
        case 2:
            x1 = f"{x0} + {rng.choice(('1e-9', '1e-7', '1e-300', '1e-4'))}"
        case 3:
            far = rng.choice(("1e5", "1e6", "1e9", "1e12", "1e15"))
            x0, x1 = f"{x0} + {far}", f"{x1} + {far}"
        case 4:
            return f"polygon ({x0}, {y0}) ({x1}, {y0}) ({x1}, {y1}) ({x0}, {y1}) ({x0}, {y0})"
        case 5:
            return f"box [{x0}, {x1}] x [{y0}, {y1}] + box [{x1}, {x1} + 1] x [{y0}, {y1}]"
        case 6:
            return f"polygon ({x0}, {y0}) ({x1}, {y0}) ({x1}, {y1})"
        case 7:
            x0, x1, y0, y1 = y0, y1, x0, x1
        case _:
            mid = f"({y0} + {y1}) / 2"
            return f"box [{x0}, {x1}] x [{y0}, {mid}] + box [{x0}, {x1}] x [{mid}, {y1}]"
    return f"box [{x0}, {x1}] x [{y0}, {y1}]"


def far(rng: random.Random, text: str, other: str) -> str:
    """Everything that has coordinates moves away from the origin."""
    by = rng.choice(("100", "1e4", "1e6", "1e9", "1e12"))
    text = BOX.sub(lambda m: f"box [{m[1]} + {by}, {m[2]} + {by}] x [{m[3]}, {m[4]}]", text)
    return re.sub(r"(start|at) \(", rf"\1 ({by} + ", text)


def extra(rng: random.Random, text: str, other: str) -> str:
    """One more statement."""
    return f"{text.rstrip()}\n{rng.choice(EXTRA)}\n"


def sweep(rng: random.Random, text: str, other: str) -> str:
    """One more `swept`."""
    at = _pick(rng, re.compile(r"(outside|in) (\w+)(?=[\s)])"), text)
    return text if at is None else _replaced(text, at, at[0] + " swept")


def raw(rng: random.Random, text: str, other: str) -> str:
    """Characters."""
    at = rng.randrange(len(text) + 1)
    made = rng.choice(
        ("\0", "\ufeff", "\r", "\x85", "é", "(", ")", "[", "{", "}", "|", '"', "#", ";", ";;", "\t")
    )
    return text[:at] + made + text[at + rng.randrange(3) :]


_TABLE: tuple[tuple[Mutator, float], ...] = (
    (number, 6), (copied_number, 3), (unit, 2), (tokens, 3), (lines, 2), (wrapped, 2),
    (interval, 2), (geometry, 4), (far, 0.5), (extra, 2), (sweep, 1), (raw, 0.3),
)  # fmt: skip
MUTATORS = [mutator for mutator, _ in _TABLE]
WEIGHTS = [weight for _, weight in _TABLE]
