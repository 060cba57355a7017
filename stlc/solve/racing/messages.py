"""What a race and its racers' processes say to each other: framed pickles."""

from __future__ import annotations

import pickle
from dataclasses import dataclass
from typing import IO

from stlc.backends.base import SolveOptions
from stlc.milp.compile import Compiled
from stlc.milp.model import Model

_LENGTH = 8  # bytes before each message that give its size


@dataclass(frozen=True, slots=True, eq=False)
class Task:
    """What to solve, with what. `memory` [bytes] limits the data of the process.

    A compiled mission is solved by a strategy, a bare model by the backend.
    """

    work: Compiled | Model
    backend: str
    options: SolveOptions
    memory: int | None = None
    strategy: str = "auto"

    @property
    def model(self) -> Model:
        """The model that answers are certified against."""
        return self.work if isinstance(self.work, Model) else self.work.model


@dataclass(frozen=True, slots=True)
class Failure:
    """Why there is no answer."""

    message: str


def write_message(stream: IO[bytes], message: object) -> None:
    """One framed pickle (protocol 5: arrays go as they are)."""
    data = pickle.dumps(message, protocol=5)
    stream.write(len(data).to_bytes(_LENGTH, "little") + data)
    stream.flush()


def read_message(stream: IO[bytes]) -> object | None:
    """The next message, or None at the end of the stream. Only for our own processes."""
    head = stream.read(_LENGTH)
    if len(head) < _LENGTH:
        return None
    size = int.from_bytes(head, "little")
    data = stream.read(size)
    return pickle.loads(data) if len(data) == size else None
