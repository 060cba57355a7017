"""What libraries print never lands on standard output; what callers print always does."""

from __future__ import annotations

import ctypes
import os
import subprocess
import sys
import threading

import pytest

from stlc.backends import get
from stlc.backends.base import SolveOptions
from stlc.backends.conformance_models import knapsack
from stlc.backends.quiet import aloud, silence

SOLVERS = ("highs", "mip", "pulp", "cvxpy", "scipy", "scip", "gurobi")
C = ctypes.CDLL(None)


def test_c_code_is_muted_and_python_is_not(capfd: pytest.CaptureFixture[str]) -> None:
    print("before")
    with silence():
        C.puts(b"a banner")
        os.write(1, b"a line\n")
        with aloud():
            print("a callback")
        C.puts(b"still at work")
    print("after")
    C.fflush(None)
    assert capfd.readouterr().out == "before\na callback\nafter\n"


def test_threads_share_the_mute(capfd: pytest.CaptureFixture[str]) -> None:
    """It ends with the last that asked for it, in whatever order they end."""
    begun, leave = threading.Event(), threading.Event()

    def other() -> None:
        with silence():
            begun.set()
            leave.wait()
            C.puts(b"late")

    thread = threading.Thread(target=other)
    with silence():
        thread.start()
        begun.wait()
    C.puts(b"between")
    leave.set()
    thread.join()
    print("after")
    assert capfd.readouterr().out == "after\n"


def test_a_closed_standard_output_is_nothing_to_mute() -> None:
    code = "import os; os.close(1)\nfrom stlc.backends.quiet import silence\nwith silence(): pass\n"
    done = subprocess.run([sys.executable, "-c", code], check=False)
    assert done.returncode == 0


@pytest.mark.parametrize("name", SOLVERS)
def test_solvers_print_nothing(name: str) -> None:
    """In a fresh process, whose C streams are written when it ends."""
    code = (
        "import sys; from stlc.backends import get\n"
        "from stlc.backends.base import SolveOptions\n"
        "from stlc.backends.conformance_models import knapsack\n"
        f"b = get({name!r}); b.version(); print(b.solve(knapsack(), SolveOptions()).status.name)\n"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    assert done.stdout == "OPTIMAL\n", done.stderr


def test_listeners_may_print(capfd: pytest.CaptureFixture[str]) -> None:
    options = SolveOptions(on_progress=lambda report: print("report"))
    get("highs").solve(knapsack(40, 8), options)
    assert set(capfd.readouterr().out.split()) == {"report"}
