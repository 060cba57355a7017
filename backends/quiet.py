"""Standard output while a solver's library may print on it: what it prints goes nowhere."""

from __future__ import annotations

import ctypes
import os
import sys
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from functools import wraps
from typing import ParamSpec, TypeVar

_P = ParamSpec("_P")
_T = TypeVar("_T")


class _Mute:
    """Descriptor 1 of this process, muted for as long as any thread asks for it."""

    def __init__(self) -> None:
        self._lock = threading.RLock()
        self._claims = 0
        self._kept: int | None = None  # what descriptor 1 was; None while nobody asks

    def claim(self) -> None:
        with self._lock:
            if self._claims == 0:
                _flush_python()
                _flush_c()
                with suppress(OSError):  # descriptor 1 is closed: there is nothing to mute
                    self._kept = os.dup(1)
                    _to_nowhere()
            self._claims += 1

    def release(self) -> None:
        with self._lock:
            self._claims -= 1
            if self._claims == 0 and self._kept is not None:
                _flush_c()  # or it would come out later
                os.dup2(self._kept, 1)
                os.close(self._kept)
                self._kept = None

    def lift(self) -> None:
        with self._lock:
            if self._kept is not None:
                _flush_c()
                os.dup2(self._kept, 1)

    def settle(self) -> None:
        with self._lock:
            if self._kept is not None:
                _flush_python()
                _to_nowhere()


_MUTE = _Mute()


@contextmanager
def silence() -> Iterator[None]:
    """Send what libraries print on standard output to nowhere; threads and nesting are fine.

    Below Python, for C code: CBC prints at log level 0, HiGHS a banner when it is made.
    """
    _MUTE.claim()
    try:
        yield
    finally:
        _MUTE.release()


@contextmanager
def aloud() -> Iterator[None]:
    """Standard output as it was, for the callback of a caller while a solver works."""
    _MUTE.lift()
    try:
        yield
    finally:
        _MUTE.settle()


def quietly(function: Callable[_P, _T]) -> Callable[_P, _T]:
    """The function, run in `silence`."""

    @wraps(function)
    def run(*args: _P.args, **kwargs: _P.kwargs) -> _T:
        with silence():
            return function(*args, **kwargs)

    return run


def _to_nowhere() -> None:
    nowhere = os.open(os.devnull, os.O_WRONLY)
    os.dup2(nowhere, 1)
    os.close(nowhere)


def _flush_python() -> None:
    if sys.stdout is not None:
        with suppress(OSError, ValueError):  # told to whoever prints next
            sys.stdout.flush()


def _flush_c() -> None:
    """Empty the buffers of C's own streams (where the C library can be called by name)."""
    with suppress(OSError, TypeError, AttributeError):
        ctypes.CDLL(None).fflush(None)
