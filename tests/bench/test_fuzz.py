"""The fuzzer itself: inputs follow from their number, and what is wrong is seen."""

from __future__ import annotations

import random
import re
from pathlib import Path

import pytest
from fuzz.corpus import ROOT, corpus
from fuzz.data import damaged_file
from fuzz.equivalents import Shift, cut_up, renamed, reordered, rings_turned
from fuzz.faults import Fault, faults
from fuzz.fresh import Fresh, place
from fuzz.inputs import Input, drawn
from fuzz.pool import KILLED
from fuzz.shorten import shortened
from fuzz.text import damaged
from fuzz.worker import Ran
from fuzz_missions import Examined, Examiner, _compared
from truth.draw import draw
from truth.scene import Obstacle, box

from stlc.api import loads

SEEDS = corpus()
PLACE = "error[E0201]: no\n --> m.stl:3:7\n"
PLACELESS = '{"diagnostics": [{"code": "E0505", "span": null}]}'
PLACED = '{"diagnostics": [{"span": {"start": {"line": 3, "column": 1}}}]}'
JSON = ("solve", "m.stl", "--json")


def test_inputs_follow_from_seed_and_number() -> None:
    one, other = ([drawn(n, 7, SEEDS) for n in range(60)] for _ in range(2))
    assert one == other
    assert len({given.text for given in one}) > 50


def test_seeds_come_from_everywhere() -> None:
    origins = {re.split("[/:]", seed.name)[0] for seed in SEEDS}
    assert {"README.md", "benchmarks", "docs", "examples", "tests"} <= origins
    assert any(name.endswith(".npz") for seed in SEEDS for name in seed.files)


def test_texts_with_numbers_beyond_doubles_are_damaged_too() -> None:
    text = "param v = 1e309\nparam w = " + "9" * 400 + "\n"
    assert len({damaged(random.Random(k), text, text) for k in range(200)}) > 50


@pytest.mark.parametrize("kind", [".csv", ".npz", ".geojson"])
def test_data_files_are_damaged(kind: str) -> None:
    found = {n: d for seed in SEEDS for n, d in seed.files.items() if n.endswith(kind)}
    name, data = min(found.items(), key=lambda item: len(item[1]))
    made = {damaged_file(random.Random(k), name, data) for k in range(40)}
    assert len(made) > 15


@pytest.mark.parametrize(
    ("ran", "kinds"),
    [
        (Ran("check", 0), []),
        (Ran("check", 1, stderr=PLACE), []),
        (Ran("check", 1, stderr=PLACE + "error[E0505]: how long?\n"), ["no place"]),
        (Ran("check", 1, PLACED, words=("check", "--format", "json")), []),
        (Ran("check", 1, PLACELESS, words=("check", "--format", "json")), ["no place"]),
        (Ran("check", 70, where="KeyError at a.py:f: 3"), ["crash"]),
        (Ran("check", KILLED), ["no end"]),
        (Ran("check", 0, seconds=6.0, peak=2 << 30), ["above 5 s", "above 1 GB"]),
        (Ran("check", 3), ["exit 3"]),
        (Ran("compile", 3), []),
        (Ran("solve", 5, stderr="error: refused"), ["exit 5"]),
        (Ran("solve", 0, stderr="Traceback (most recent call last)\n"), ["traceback"]),
        (Ran("solve", 0, stderr="x.py:1: RuntimeWarning: overflow\n"), ["warning"]),
        (Ran("solve", 0, "{}", words=JSON), []),
        (Ran("solve", 0, "HiGHS\n{}", words=JSON), ["not JSON"]),
        (Ran("solve", 0, '{"a": Infinity}', words=JSON), ["not JSON"]),
        (Ran("solve", 4, "", words=JSON), ["not JSON"]),
    ],
)
def test_faults_are_seen(ran: Ran, kinds: list[str]) -> None:
    assert [fault.kind for fault in faults(ran)] == kinds


def test_verdicts_and_optima_of_twins_are_compared() -> None:
    given = Input("", "", factor=2.0, change="scaled")
    seen = [
        [f.kind for f in _compared(given, one, other)]
        for one, other in [
            ((0, 3.0), (0, 6.0)), ((0, 3.0), (0, 3.0)), ((0, 3.0), (3, None)),
            ((4, None), (3, None)), ((3, None), (3, None)), ((0, 3.0), None),
        ]
    ]  # fmt: skip
    assert seen == [[], ["optimum"], ["verdict"], [], [], ["twin"]]


class _Finder:
    """Finds the same fault in every text with both words."""

    def examine(self, given: Input) -> Examined:
        bad = "one" in given.text and "two" in given.text
        return Examined([Fault("crash", "check")] if bad else [])


def test_inputs_are_shortened() -> None:
    text = "\n".join(["a", "b", "one", "c", "d", "two", "e"])
    assert shortened(Input("", text), Fault("crash", "check"), _Finder()).text == "one\ntwo"


def test_twins_of_texts_say_the_same() -> None:
    text = next(s.text for s in SEEDS if s.name.startswith("docs/language.md:0"))
    rng = random.Random(1)
    for twin in (reordered(rng, text), renamed(rng, text)):
        assert twin != text
        ours, theirs = loads(text), loads(twin)
        assert ours.summary() == theirs.summary()


def test_twins_of_scenes_are_the_scenes_moved() -> None:
    part = Shift(2.0, swap=True, mirror=True, offset=(1.0, 0.0)).part(box(1, 2, 3, 5))
    assert part.text() == "box [-9.0, -5.0] x [2.0, 4.0]"
    scene = draw("union", 1)
    for twin in (Shift(mirror=True).scene(scene), cut_up(scene), rings_turned(scene)):
        loads(twin.text())
    halves = cut_up(draw("single", 3)).obstacles[0]
    assert isinstance(halves, Obstacle)
    assert len(halves.frames[0]) == 2


def test_files_stay_in_their_folder(tmp_path: Path) -> None:
    folder = tmp_path / "case"
    folder.mkdir()
    Input("", "x", {"../out.csv": b"1", "data/in.csv": b"2"}).write(folder)
    assert sorted(p.name for p in tmp_path.rglob("*.csv")) == ["in.csv"]


TRACE = """Traceback (most recent call last):
  File "/a/stlc/api.py", line 3, in load
    x()
  File "/b/site-packages/lark/parser.py", line 9, in parse
    raise ValueError
  File "/a/stlc/syntax/read.py", line 7, in parsed
    y()
KeyError: 'speed'
error: internal error (KeyError: 'speed').
"""


def test_crashes_of_children_are_placed_as_those_of_the_worker() -> None:
    assert place(TRACE) == "KeyError at syntax/read.py:parsed: 'speed'"
    assert place("error: no file\n") == ""


def test_children_end_as_users_see_it(tmp_path: Path) -> None:
    (tmp_path / "m.stl").write_text("require a: nobody.x >= 0\n")
    ran = Fresh().run(tmp_path, ("check", "m.stl", "--format", "json"), 20.0)
    assert (ran.status, faults(ran)) == (1, [])
    assert ran.seconds > 0
    assert ran.peak > 10 << 20


def test_children_that_need_too_long_are_ended(tmp_path: Path) -> None:
    mission = str(ROOT / "benchmarks" / "missions" / "two_agents_t8.stl")
    assert Fresh().run(tmp_path, ("solve", mission, "--time-limit", "60"), 0.0).status == KILLED


class _Spoilt:
    """A worker whose output is lost."""

    def run(self, folder: Path, words: tuple[str, ...], cpu_limit: float) -> Ran:
        return Ran(words[0], 0, "", words=words)


def test_what_goes_wrong_in_the_worker_alone_is_no_fault(tmp_path: Path) -> None:
    text = "agent r : single_integrator { start (1, 1) }\nrequire a: always[0, 1] r.x >= 0 m\n"
    given = Input("m", text, compiled=False)
    spoilt = Examiner(_Spoilt(), tmp_path / "case", again=None).examine(given)
    assert [fault.kind for fault in spoilt.faults] == ["not JSON"]
    assert not Examiner(_Spoilt(), tmp_path / "case").examine(given).faults
