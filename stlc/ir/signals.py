"""What predicates are about: scalar signals, and qualities of links."""

from __future__ import annotations

from enum import Enum
from typing import NamedTuple


class Role(Enum):
    """What a signal is of its owner."""

    STATE = "state"
    INPUT = "input"
    FREE = "free"  # a recorded signal of `stlc monitor`; the owner is its name, the index 0

    __hash__ = object.__hash__  # signals are hashed for every predicate: an enum's own is slow


class Signal(NamedTuple):
    """One scalar signal, `shift` steps after the step at which the predicate is judged.

    A tuple, because formulas hash and compare millions of them.
    """

    owner: str
    role: Role
    index: int  # type: ignore[assignment]  # a tuple's own method, which no signal needs
    shift: int = 0

    @property
    def key(self) -> tuple[str, str, int, int]:
        """Sort key of canonical forms."""
        return (self.owner, self.role.value, self.index, self.shift)


class Relation(Enum):
    """Sense of a link predicate."""

    AT_LEAST = ">="
    AT_MOST = "<="


class Quantity(Enum):
    """What a link predicate measures, with its unit."""

    RSSI = "rssi"  # dBm, posterior mean
    SNR = "snr"  # dB, posterior mean
    BER = "ber"  # 1, averaged over the posterior
    BER_AT_MEAN = "ber_at_mean"  # 1, at the posterior mean
    PRR = "prr"  # 1, packet reception ratio
    COST = "cost"  # the channel's own link cost
