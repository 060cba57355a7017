"""Hands in a process of their own: `python -m stlc.solve.crew.worker`.

Reads pickled `Order`s from standard input, one after the other, and answers each with a pickled
`Solution`. When standard input ends, so does this process.
"""

from __future__ import annotations

import os
import threading
from queue import SimpleQueue

from stlc.solve.crew.ask import Order, carried_out
from stlc.solve.racing.child import leave, private_output
from stlc.solve.racing.messages import read_message, write_message


def main() -> None:
    """Carry out orders until there are no more."""
    output = private_output()
    orders: SimpleQueue[Order] = SimpleQueue()
    threading.Thread(target=_read, args=(orders,), daemon=True).start()
    while True:
        write_message(output, carried_out(orders.get(), bool))


def _read(orders: SimpleQueue[Order]) -> None:
    """Orders as they come; at the end of the input this process and its children end."""
    with os.fdopen(os.dup(0), "rb") as source:
        while (order := read_message(source)) is not None:
            assert isinstance(order, Order)
            orders.put(order)
    leave()


if __name__ == "__main__":
    main()
