"""Feeds damaged and random texts to the checker: no exception, and every error has its place.

    python benchmarks/fuzz_syntax.py 20000

Inputs are byte mutations of a sample mission, texts drawn from the grammar's own spellings,
cut-off and doubled files, raw bytes, and a few monsters (50,000 parentheses, a line of 10 MB).
Every third input is a valid mission (of `docs/language.md`) with some tokens changed, which often
parses: it goes through the whole of `stlc.api.loads`, and so does whatever else parses.
"""

from __future__ import annotations

import random
import re
import sys
import time
from pathlib import Path

from fuzz.tokens import change_one

from stlc.api import loads
from stlc.diagnostics import Diagnostic, Severity
from stlc.errors import MissionError
from stlc.grammar import tables
from stlc.render import STYLES, render
from stlc.syntax.compare import same_syntax
from stlc.syntax.parse import parse
from stlc.syntax.printer import format_file
from stlc.syntax.read import decode

SAMPLE = b"""step 1 s
workspace box [0, 10] x [0, 10]
dynamics cart = double_integrator  # a comment
agent r1 : cart { start (1, 1); control |u| <= 1; speed <= 2; turn_rate on; mass 1 kg }
agent uav[1..4] : cart { start (9, 1) }
station base at (5, 0) { height 3 m }
region goal = polygon (1, 8) (2, 8) (2, 9) hole (1.2, 8.1) (1.3, 8.1) (1.3, 8.2)
obstacle pillar = moving { 0: box [4, 6] x [4, 6]; 3: goal } inflate 0.3 m
channel radio {
  path_loss L0 = -12.89 dBm, n = 3
  samples "rssi.csv"
  partition 10 x 10
}
let home(a, g) = eventually[0, 8 s] a in g
require reach margin 0.1: home(r1, goal) and G[0,5] (|x - y| <= 2 || z U_[0,3] w)
require clear:  always forall (a, b) in pairs: a outside pillar swept
require sure:   eventually[0, 8] P(rssi(r1, base) >= -36 dBm) >= 0.95
minimize 0.1 * effort[0, 5] + 0.9 * link_cost(radio)
"""

GUIDE = Path(__file__).parent.parent / "docs" / "language.md"
TOKEN = re.compile(r"\s+|#[^\n]*|\w+(?:\.\d+)?|<=|>=|==|->|\.\.|.", re.S)
NUMBERS = ("0", "1", "-1", "1e300", "1e-300", "0.5 s", "3 dBm", "2 m", "100000", "inf", "i", "r1")

MONSTERS = (
    b"require a: " + b"(" * 50_000 + b"x > 0" + b")" * 50_000,
    b"require a: " + b"[" * 50_000,
    b"{" * 50_000,
    b"require a: " + b"not " * 50_000 + b"x",
    b"require a: " + b"always " * 50_000 + b"x > 0",
    b"require a: " + b"-" * 50_000 + b"x",
    b"require a: " + b"|" * 50_000 + b"x",
    b"require a: x" + b" + x" * 50_000 + b" > 0",
    b"require a: x > 0" + b" -> x > 0" * 50_000,
    b"require a: x > 0" + b" and x > 0" * 50_000,
    b"x " * 5_000_000,
    b"\0" * 10_000_000,
    b" " * 10_000_000,
    b"#" * 10_000_000,
    b"\n" * 3_000_000,
    b'"' * 200_000,
    b"prefer x\n" * 100_000,
    b"\xff\xfe" * 1000,
)


def words() -> list[bytes]:
    """Every spelling of the grammar, and some names and numbers."""
    spellings = [word for group in tables().spellings.values() for word in group]
    more = ["a", "G", "r1", "0", "1.5 m", "2 dB^2", '"s"', "\n", "\n", "# c\n", "//", "inf", "1..4"]
    return [word.encode() for word in spellings + more]


def mutate(rng: random.Random, data: bytes) -> bytes:
    """A few bytes changed, removed, inserted, or a piece moved."""
    text = bytearray(data)
    for _ in range(rng.randint(1, 6)):
        at = rng.randrange(len(text) + 1)
        match rng.randrange(5):
            case 0:
                text[at : at + 1] = bytes([rng.randrange(256)])
            case 1:
                del text[at : at + rng.randint(1, 20)]
            case 2:
                text[at:at] = rng.choice(b' ()[]{}|:;,=<>-\n"#x').to_bytes()
            case 3:
                start = rng.randrange(len(text) + 1)
                text[at:at] = text[start : start + rng.randint(1, 40)]
            case _:
                text[at:at] = rng.choice(words())
    return bytes(text)


def missions() -> list[list[str]]:
    """The missions of the language guide, and its fragments after their prelude, as tokens."""
    text = GUIDE.read_text(encoding="utf-8")
    found = re.search(r"<!-- prelude two\n(.*?)-->", text, re.S)
    prelude = found[1] if found else ""
    blocks = re.findall(r"^```stl( in two)?[^\n]*\n(.*?)^```", text, re.S | re.M)
    return [TOKEN.findall((prelude if fragment else "") + body) for fragment, body in blocks]


def change_tokens(rng: random.Random, tokens: list[str]) -> bytes:
    """A few tokens left out, doubled, exchanged, or replaced by others of the mission."""
    made = list(tokens)
    for _ in range(rng.randint(1, 4)):
        change_one(rng, made, NUMBERS)
        made = made or ["step"]
    return "".join(made).encode()


def draw(rng: random.Random, vocabulary: list[bytes], valid: list[list[str]]) -> bytes:
    """One input."""
    if rng.randrange(3) == 0:
        return change_tokens(rng, rng.choice(valid))
    match rng.randrange(6):
        case 0 | 1:
            return mutate(rng, SAMPLE)
        case 2:
            lines = SAMPLE.split(b"\n")
            return mutate(rng, rng.choice(lines))
        case 3:
            some = (rng.choice(vocabulary) for _ in range(rng.randint(1, 40)))
            return b"require a: " + b" ".join(some)
        case 4:
            return b" ".join(rng.choice(vocabulary) for _ in range(rng.randint(1, 60)))
        case _:
            return rng.randbytes(rng.randint(0, 60))


def examine(data: bytes) -> tuple[Diagnostic, ...]:
    """Diagnostics of an input; what is valid must survive formatting."""
    try:
        source = decode("fuzz.stl", data)
    except MissionError as error:
        return error.diagnostics
    result = parse(source)
    if result.ok:
        text = format_file(result.file)
        again = parse(decode("fuzz.stl", text.encode()))
        assert again.ok, text
        assert same_syntax(again.file.statements, result.file.statements), text
        assert format_file(again.file) == text, text
        return meaning(source.text)
    return result.diagnostics


def meaning(text: str) -> tuple[Diagnostic, ...]:
    """Diagnostics of the whole checker; the guide's folder has none of the files it names."""
    try:
        return loads(text).warnings
    except MissionError as error:
        return error.diagnostics


def check(data: bytes) -> bool:
    """Examine one input and render what was found; whether it has errors."""
    done = False
    try:
        found = examine(data)
        assert all(d.span is not None for d in found), "a diagnostic without a place"
        for style in STYLES:
            render(found, style)
        done = True
    finally:
        if not done:
            print(f"FAILED on {data[:400]!r}", file=sys.stderr)
    return any(d.severity is Severity.ERROR for d in found)


def main(count: int, seed: int = 1) -> None:
    """Try `count` inputs; the first that fails ends the run with its traceback."""
    rng, vocabulary, valid = random.Random(seed), words(), missions()
    begin = time.perf_counter()
    errors = sum(
        check(MONSTERS[number] if number < len(MONSTERS) else draw(rng, vocabulary, valid))
        for number in range(count)
    )
    spent = time.perf_counter() - begin
    print(f"{count} inputs: {count - errors} valid, {errors} with located errors, 0 failures")
    print(f"{spent:.0f} s")


if __name__ == "__main__":
    main(int(sys.argv[1]) if len(sys.argv) > 1 else 2000)
