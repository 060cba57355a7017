"""The signal handler: where it may raise, and whom it hears."""

from __future__ import annotations

import signal
import subprocess
import sys
import threading
import time
from collections.abc import Iterator

import pytest
from support.command import LIMIT

from stlc.cli.interrupt import interruptible


@pytest.fixture(autouse=True)
def _handlers() -> Iterator[None]:
    before = signal.getsignal(signal.SIGINT)
    signal.signal(signal.SIGINT, signal.default_int_handler)
    yield
    signal.signal(signal.SIGINT, before)


class _Struck:
    """A lock that Ctrl-C strikes while a condition takes or leaves it."""

    def __init__(self, where: str) -> None:
        self._lock, self._where = threading.Lock(), where

    def __enter__(self) -> bool:
        taken = self._lock.__enter__()
        if self._where == "enter":
            signal.raise_signal(signal.SIGINT)
        return taken

    def __exit__(self, *args: object) -> None:
        if self._where == "exit":
            signal.raise_signal(signal.SIGINT)
        self._lock.release()


@pytest.mark.parametrize("where", ["enter", "exit"])
def test_no_interrupt_within_the_taking_of_a_lock(where: str) -> None:
    lock = _Struck(where)

    def work() -> None:
        with lock:
            pass
        time.sleep(LIMIT)

    with interruptible(), pytest.raises(KeyboardInterrupt):
        work()
    assert not lock._lock.locked()


def test_a_condition_struck_while_it_takes_its_lock_again() -> None:
    """Where `release unlocked lock` came from."""

    class Condition(threading.Condition):
        def _acquire_restore(self, state: object) -> None:
            signal.raise_signal(signal.SIGINT)
            super()._acquire_restore(state)  # type: ignore[misc]

    struck = Condition(threading.Lock())

    def work() -> None:
        with struck:
            struck.wait(0.01)
        time.sleep(LIMIT)

    with interruptible(), pytest.raises(KeyboardInterrupt):
        work()


def test_a_second_signal_is_told_from_the_first_sent_again() -> None:
    code = (
        "import signal, time\n"
        "from stlc.cli.interrupt import interruptible\n"
        "class Manager:\n"
        "    def __enter__(self): signal.raise_signal(signal.SIGINT)\n"
        "    def __exit__(self, *_): pass\n"
        "with interruptible():\n"
        "    try:\n"
        "        with Manager(): time.sleep(60)\n"
        "    except KeyboardInterrupt:\n"
        "        signal.raise_signal(signal.SIGINT)\n"
    )
    code = "import signal; signal.signal(signal.SIGINT, signal.default_int_handler)\n" + code
    words = [sys.executable, "-c", code]
    done = subprocess.run(words, capture_output=True, text=True, timeout=LIMIT, check=False)
    assert (done.returncode, done.stderr) == (130, "\nerror: interrupted again: ended at once\n")


def test_what_is_ignored_stays_ignored() -> None:
    """As by `nohup`, or `&` in a script, also after somebody has looked at the flag."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    with interruptible() as stop:
        assert not stop()
        assert signal.getsignal(signal.SIGINT) is signal.SIG_IGN
        signal.raise_signal(signal.SIGINT)
        assert not stop()
