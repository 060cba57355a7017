"""Measured samples: links, received strengths, receivers, censoring; merged exactly."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from stlc.radio.errors import RadioError
from stlc.radio.pathloss import split_links, swap_ends

Array = NDArray[np.float64]
Ints = NDArray[np.intp]


@dataclass(frozen=True, slots=True, eq=False)
class Samples:
    """K measured links.

    links     (K, 2 D) [m], sender then receiver, D = 2 or 3
    rssi      (K,) [dBm]
    floor     (K,) [dBm]; a row with rssi <= floor is left-censored: all that is known is that
              its strength is at most `floor`. -inf: never censored
    receiver  (K,) index into `names`, whose unknown offsets a fit may estimate; all zero when
              there is one calibration for all
    """

    links: Array
    rssi: Array
    floor: Array
    receiver: Ints
    names: tuple[str, ...] = ("",)

    def __post_init__(self) -> None:
        split_links(self.links)
        count = len(self.links)
        if not (len(self.rssi) == len(self.floor) == len(self.receiver) == count):
            raise RadioError("links, rssi, floor and receiver differ in length")
        if not (np.isfinite(self.links).all() and np.isfinite(self.rssi).all()):
            raise RadioError("samples hold a value that is not finite")

    def __len__(self) -> int:
        return len(self.rssi)

    @property
    def censored(self) -> NDArray[np.bool_]:
        """Rows (K,) of which only `strength <= floor` is known."""
        return np.asarray(self.rssi <= self.floor, dtype=np.bool_)

    @property
    def directed(self) -> bool:
        """Whether no place sends in one sample and receives in another."""
        sender, receiver = split_links(self.links)
        together = np.vstack([np.unique(sender, axis=0), np.unique(receiver, axis=0)])
        return len(np.unique(together, axis=0)) == len(together)

    def take(self, rows: Ints | NDArray[np.bool_]) -> Samples:
        """The samples of the given rows, in that order."""
        return Samples(
            self.links[rows], self.rssi[rows], self.floor[rows], self.receiver[rows], self.names
        )

    def unnamed(self) -> Samples:
        """The same samples, all of one calibration."""
        return Samples(self.links, self.rssi, self.floor, np.zeros(len(self), dtype=np.intp))

    def with_floor(self, floor: float | Array) -> Samples:
        """The same samples, censored at `floor` [dBm] (one number, or one a receiver)."""
        level = np.atleast_1d(np.asarray(floor, dtype=np.float64))
        per_row = np.full(len(self), level[0]) if level.size == 1 else level[self.receiver]
        return Samples(self.links, self.rssi, per_row, self.receiver, self.names)


def make_samples(links: Array, rssi: Array) -> Samples:
    """Uncensored samples of one calibration; links (K, 2 D) [m], rssi (K,) [dBm]."""
    count = len(rssi)
    return Samples(
        np.asarray(links, dtype=np.float64),
        np.asarray(rssi, dtype=np.float64),
        np.full(count, -np.inf),
        np.zeros(count, dtype=np.intp),
    )


def joined(first: Samples, second: Samples) -> Samples:
    """The samples of both, those of `second` by the calibration that `first` begins with.

    Raises RadioError for links in the plane beside such with heights.
    """
    if first.links.shape[1] != second.links.shape[1]:
        raise RadioError("some samples have heights, others have none")
    return Samples(
        np.vstack([first.links, second.links]), np.concatenate([first.rssi, second.rssi]),
        np.concatenate([first.floor, second.floor]),
        np.concatenate([first.receiver, np.zeros(len(second), dtype=np.intp)]), first.names,
    )  # fmt: skip


def distinct(samples: Samples) -> Samples:
    """The samples without those that repeat another's link, receiver, strength and floor."""
    key = [link_numbers(samples.links), samples.receiver, samples.rssi, samples.floor]
    _, first = np.unique(np.column_stack(key), axis=0, return_index=True)
    return samples.take(np.sort(first))


@dataclass(frozen=True, slots=True, eq=False)
class Merged:
    """Samples with repeats replaced by their mean: exact, not an approximation.

    Of n samples of one link the mean, whose fading has the variance sigma_F^2 / n, is
    sufficient for all that the link's samples share; `scatter` keeps what the likelihood of
    sigma_F^2 still needs.

    samples   one row a link and receiver; censored rows are never merged
    count     (K,) how many samples each row stands for
    scatter   (K,) sum of squares of a row's samples about their mean [dB^2]
    link      (K,) number of each row's link; both directions are one link
    row_of    (K0,) the merged row of each original sample
    """

    samples: Samples
    count: Array
    scatter: Array
    link: Ints
    row_of: Ints

    @property
    def repeated(self) -> bool:
        """Whether some link was measured more than once."""
        return len(self.row_of) > len(np.unique(self.link))

    def take(self, rows: Ints) -> Merged:
        """The given rows and their samples."""
        new = np.full(len(self.samples), -1, dtype=np.intp)
        new[rows] = np.arange(len(rows))
        row_of = new[self.row_of]
        return Merged(
            self.samples.take(rows),
            self.count[rows],
            self.scatter[rows],
            self.link[rows],
            row_of[row_of >= 0],
        )


def merge(samples: Samples) -> Merged:
    """Merge equal links (also those equal after exchanging their ends) of one receiver."""
    link = link_numbers(samples.links)
    _, lead = np.unique(link, return_index=True)
    own = np.where(samples.censored, np.arange(1, len(samples) + 1), 0)
    key = np.column_stack([link, samples.receiver, own])
    _, first, row_of = np.unique(key, axis=0, return_index=True, return_inverse=True)
    row_of = row_of.reshape(-1)
    count = np.asarray(np.bincount(row_of), dtype=np.float64)
    mean = np.bincount(row_of, weights=samples.rssi) / count
    square = (samples.rssi - mean[row_of]) ** 2
    scatter = np.asarray(np.bincount(row_of, weights=square), dtype=np.float64)
    kept = samples.take(first)
    positions = samples.links[lead[link[first]]]  # one direction for all rows of a link
    merged = Samples(positions, mean, kept.floor, kept.receiver, kept.names)
    return Merged(merged, count, scatter, link[first], np.asarray(row_of, dtype=np.intp))


def link_numbers(links: Array) -> Ints:
    """Numbers (K,) from 0 on that are equal where links are equal, in either direction."""
    _, number = np.unique(_canonical(links), axis=0, return_inverse=True)
    return np.asarray(number.reshape(-1), dtype=np.intp)


def _canonical(links: Array) -> Array:
    """Each link with its lexicographically smaller end first."""
    sender, receiver = split_links(links)
    different = sender != receiver
    axis = np.argmax(different, axis=1)
    rows = np.arange(len(links))
    flip = sender[rows, axis] > receiver[rows, axis]
    return np.asarray(np.where(flip[:, None], swap_ends(links), links), dtype=np.float64)
