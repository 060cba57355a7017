"""Progress in a notebook: one output that changes, and none elsewhere."""

from __future__ import annotations

import sys
from types import ModuleType, SimpleNamespace

import pytest

import stlc
from stlc.front import progress
from stlc.solve.events import DiagnosticEvent, ProgressEvent, StatusEvent

TEXT = """horizon 3
workspace box [0, 10] x [0, 10]
agent r : single_integrator { start (1, 1); control |u| <= 2 }
require go: eventually r.x >= 3
minimize effort
"""


@pytest.fixture
def shown(monkeypatch: pytest.MonkeyPatch) -> list[tuple[int, str]]:
    """What a notebook shows: the number of the output, and its text."""
    outputs: list[tuple[int, str]] = []

    class Handle:
        def __init__(self, number: int) -> None:
            self.number = number

        def update(self, content: dict[str, str], raw: bool) -> None:
            assert raw
            outputs.append((self.number, content["text/plain"]))

    def display(content: dict[str, str], raw: bool, display_id: bool) -> Handle:
        assert raw
        assert display_id
        made = Handle(len({n for n, _ in outputs}))
        made.update(content, raw)
        return made

    shell, view = ModuleType("IPython"), ModuleType("IPython.display")
    shell.get_ipython = lambda: SimpleNamespace(kernel=object())
    view.display = display
    monkeypatch.setitem(sys.modules, "IPython", shell)
    monkeypatch.setitem(sys.modules, "IPython.display", view)
    return outputs


def test_a_solve_has_one_line_that_moves(shown: list[tuple[int, str]]) -> None:
    assert stlc.loads(TEXT).solve().ok
    assert {number for number, _ in shown} == {0}
    assert shown[-1] == (0, "done: optimal")
    assert len(shown) > 2


def test_it_can_be_left_out(shown: list[tuple[int, str]]) -> None:
    assert stlc.loads(TEXT).solve(progress=False).ok
    assert shown == []


def test_a_busy_solver_is_looked_at_now_and_then(
    shown: list[tuple[int, str]], monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:  # fmt: skip
    clock = iter([0.0, 0.05, 0.1, 0.25, 0.26])
    monkeypatch.setattr(progress.time, "monotonic", lambda: next(clock))
    tell = progress.listener(True)
    for seconds in (0.0, 0.05, 0.1, 0.25):
        tell(ProgressEvent(seconds, None, None, None, 0))
    tell(DiagnosticEvent("note", "mind the gap"))
    tell(StatusEvent("done", "optimal"))
    assert [text.split()[0] for _, text in shown] == ["0.0", "0.2", "done:"]
    assert capsys.readouterr().out == "note: mind the gap\n"


def test_elsewhere_nothing_is_shown(capsys: pytest.CaptureFixture[str]) -> None:
    assert stlc.loads(TEXT).solve().ok
    assert capsys.readouterr() == ("", "")
