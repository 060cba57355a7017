"""A race on a dask.distributed cluster: one task a racer, each in a process of its own there.

dask's `cancel` does not stop a running solve, so the tasks watch a shared event instead.
"""

from __future__ import annotations

import uuid
from collections.abc import Callable, Sequence
from importlib import import_module
from typing import Any

from stlc.errors import SolverError
from stlc.solve.race import Finish, Lap, Race, Racer, best, check_names, race

_POLL = 0.2  # s
_TIMEOUT = 10.0  # s to reach the scheduler


def race_on_cluster(
    address: str, racers: Sequence[Racer], *, should_stop: Callable[[], bool] | None = None
) -> Race:
    """Race on the workers of the scheduler at `address` (such as tcp://host:8786).

    Each worker needs the same version of this package. SolverError when the cluster can't be
    reached or `distributed` is not installed.
    """
    check_names(racers)
    with connect(address) as client:
        word = f"stlc-race-{uuid.uuid4().hex}"
        futures = {
            client.submit(run_remotely, racer, word, pure=False, retries=0): racer.name
            for racer in racers
        }
        try:
            laps = _gather(futures, should_stop)
        finally:
            stop_event(word, client).set()
        ended = [Lap(r.name, Finish.ENDED, 0.0) for r in racers if r.name not in laps]
        everyone = laps | {lap.name: lap for lap in ended}
        return Race(best(laps.values()), tuple(everyone[r.name] for r in racers))


def run_remotely(racer: Racer, word: str) -> Lap:
    """On a worker: race one racer alone until it is done or the event `word` is set."""
    stop = stop_event(word, distributed().get_client())
    return race([racer], should_stop=stop.is_set).laps[0]


def connect(address: str) -> Any:
    """A client of the scheduler at `address`. SolverError when it cannot be had."""
    try:
        return distributed().Client(address, timeout=_TIMEOUT)
    except (OSError, ValueError) as error:
        raise SolverError(f"cannot reach the cluster at {address}: {error}") from error


def distributed() -> Any:
    """The package. SolverError when it is not installed."""
    try:
        return import_module("distributed")
    except ImportError as error:
        raise SolverError("a cluster needs: pip install 'stlc[cluster]'") from error


def stop_event(word: str, client: Any) -> Any:
    """The cluster-wide event of that name; set, it asks the tasks that watch it to stop."""
    return distributed().Event(word, client=client)


def _gather(futures: dict[Any, str], should_stop: Callable[[], bool] | None) -> dict[str, Lap]:
    """Laps as they finish, until one is a proof, all are in, or somebody says stop."""
    laps: dict[str, Lap] = {}
    open_ = set(futures)
    while open_ and not any(lap.finish is Finish.PROOF for lap in laps.values()):
        if should_stop is not None and should_stop():
            break
        try:
            done = distributed().wait(open_, timeout=_POLL, return_when="FIRST_COMPLETED").done
        except TimeoutError:
            continue
        for future in done:
            name = futures[future]
            failed = future.status != "finished"
            text = f"the worker failed: {future.exception()}" if failed else ""
            laps[name] = Lap(name, Finish.FAILED, 0.0, None, text) if failed else future.result()
        open_ -= done
    return laps
