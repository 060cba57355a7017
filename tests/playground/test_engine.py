"""What the playground's page is answered."""

from __future__ import annotations

import json
import threading
from typing import Any

import pytest
from support.command import CONFLICT, MISSION

from stlc.backends import support
from stlc.playground import engine
from stlc.playground.engine import answer

WRONG = "agent r : single_integrator { start (1, 1) }\nrequire a: always r.q >= 3\n"


def asked(do: str, **words: Any) -> dict[str, Any]:
    return json.loads(answer(json.dumps({"do": do, **words})))


def test_problems_have_places_and_meaning() -> None:
    found = asked("examine", text=WRONG)
    assert found["depth"] == "meaning"
    (problem,) = found["problems"]
    assert problem["code"] == "E0206"
    assert problem["span"]["start"]["line"] == 2
    assert WRONG[problem["span"]["start"]["offset"] :].startswith("q >=")


def test_a_good_text_is_summed_up() -> None:
    found = asked("examine", text=MISSION)
    assert (found["problems"], found["summary"]) == ([], "1 agent, 2 requirements, 4 steps of 1 s")


def test_without_numpy_the_syntax_is_looked_at(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(engine, "find_spec", lambda name: None)
    assert asked("abilities")["check"] == ["numpy", "shapely"]
    assert asked("examine", text=WRONG) == {"depth": "syntax", "problems": [], "summary": None}
    found = asked("examine", text="require a: always r.x >== 3\n")
    assert [p["span"]["start"]["column"] for p in found["problems"]] == [25]


def test_texts_are_laid_out_unless_they_cannot_be_read() -> None:
    assert asked("format", text="require   a:always r.x>=3") == {
        "text": "require a: always r.x >= 3\n"
    }
    assert asked("format", text="require a: (")["problems"]


def test_a_mission_is_solved_and_shown() -> None:
    found = asked("solve", text=MISSION, seconds=30)
    assert found["report"].startswith("<!doctype html>")
    assert "visit" in found["said"]


def test_what_fails_is_said_with_its_status() -> None:
    assert asked("solve", text=CONFLICT)["status"] == 3
    found = asked("solve", text=WRONG)
    assert (found["status"], found["problems"][0]["code"]) == (1, "E0206")


def test_a_mission_is_solved_where_there_are_no_threads(monkeypatch: pytest.MonkeyPatch) -> None:
    def none(thread: threading.Thread) -> None:
        raise RuntimeError("can't start new thread")

    monkeypatch.setattr(threading.Thread, "start", none)
    with pytest.raises(RuntimeError):
        asked("solve", text=MISSION)
    monkeypatch.setattr(support, "THREADS", False)
    assert "visit" in asked("solve", text=MISSION)["said"]
