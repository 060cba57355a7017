"""Hands on this machine: processes that stay until they are sent home."""

from __future__ import annotations

from collections.abc import Callable
from queue import Empty, SimpleQueue

from stlc.backends.base import Solution
from stlc.solve.crew.ask import Ask, Order
from stlc.solve.racing.child import Child

_POLL = 0.05  # s
_DEATHS = 3  # processes that may die under one order before it is carried out by who asked

_Said = tuple[int, object | None]


class Processes:
    """Up to `size` processes, each started when there is work for it.

    One that dies takes nothing with it: its order goes to another that is started in its place.
    `born` counts all that were ever started."""

    def __init__(self, size: int) -> None:
        self._size = size
        self._said: SimpleQueue[_Said] = SimpleQueue()
        self._children: dict[int, Child] = {}  # by a number of their own
        self._busy: dict[int, tuple[int, Order]] = {}  # child: number and order
        self._deaths: dict[int, int] = {}
        self.born = 0

    @property
    def size(self) -> int:
        """How many there may be."""
        return self._size

    def pids(self) -> list[int]:
        """Ids of those that are there."""
        return [child.pid for child in self._children.values()]

    def give(self, number: int, ask: Ask) -> None:
        """To a process that is free, or to a new one."""
        self._deaths[number] = 0
        self._send(number, ask.order())

    def take(self) -> list[tuple[int, Solution | None]]:
        """The next answer, if one comes within a moment."""
        try:
            child, message = self._said.get(timeout=_POLL)
        except Empty:
            return []
        if child not in self._busy:
            return []  # it has died since it had nothing to do
        number, order = self._busy.pop(child)
        if isinstance(message, Solution):
            return [(number, message)]
        self._children.pop(child).end()
        self._deaths[number] += 1
        if self._deaths[number] >= _DEATHS:
            return [(number, None)]
        self._send(number, order)
        return []

    def drop(self) -> None:
        """End those that are at work."""
        for child in list(self._busy):
            self._children.pop(child).end()
        self._busy.clear()

    def close(self) -> None:
        """End them all."""
        for child in self._children.values():
            child.end()
        self._children.clear()
        self._busy.clear()

    def _send(self, number: int, order: Order) -> None:
        """Have a free process carry out an order, or a new one."""
        free = next((k for k in self._children if k not in self._busy), None)
        if free is None:
            self.born += 1
            free = self.born
            name = "a process of the search"
            self._busy[free] = number, order
            self._children[free] = Child("stlc.solve.crew.worker", name, order, self._teller(free))
            return
        self._busy[free] = number, order
        self._children[free].send(order)

    def _teller(self, child: int) -> Callable[[object | None], None]:
        return lambda message: self._said.put((child, message))
