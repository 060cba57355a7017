"""What a channel has learnt on the way, beside what its file says of it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from stlc.radio.errors import RadioError
from stlc.radio.gp import ChannelModel, condition, extended
from stlc.radio.samples import Samples, make_samples

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class Parameters:
    """A channel's parameters as `ChannelModel` has them; `losses` [dB] are those of its walls."""

    l0: float
    exponent: float
    fading: float
    deviation: float
    shadowing: float
    length: float
    losses: tuple[float, ...] = ()

    @classmethod
    def of(cls, model: ChannelModel) -> Parameters:
        """Those of a model."""
        losses = () if model.walls is None else tuple(map(float, model.walls.loss))
        return cls(
            model.l0, model.exponent, model.fading, model.deviation, model.shadowing,
            model.length, losses,
        )  # fmt: skip

    def prior(self, model: ChannelModel) -> ChannelModel:
        """A model with these parameters, conditioned on nothing. Raises RadioError for parameters
        that no channel has, or other walls."""
        walls = model.walls
        if len(self.losses) != (0 if walls is None else len(walls.loss)):
            raise RadioError("its fitted parameters are for other walls")
        if walls is not None:
            walls = replace(walls, loss=np.array(self.losses))
        return replace(
            model, l0=self.l0, exponent=self.exponent, fading=self.fading, walls=walls,
            deviation=self.deviation, shadowing=self.shadowing, length=self.length, posterior=None,
        )  # fmt: skip


@dataclass(frozen=True, slots=True, eq=False)
class Learned:
    """Links (K, 2 D) [m] and strengths (K,) [dBm] of uncensored samples, and the parameters that
    were fitted anew to them and those of the file, None where its own are kept."""

    links: Array
    rssi: Array
    parameters: Parameters | None = None

    def __len__(self) -> int:
        return len(self.rssi)

    @property
    def samples(self) -> Samples:
        """As samples."""
        return make_samples(self.links, self.rssi)

    def same(self, other: Learned | None) -> bool:
        """Whether it is just what `other` is."""
        return (
            other is not None
            and self.parameters == other.parameters
            and np.array_equal(self.links, other.links)
            and np.array_equal(self.rssi, other.rssi)
        )


def together(parts: Sequence[Learned]) -> Learned:
    """All samples, with the last parameters that any of them has.

    Raises RadioError for links in the plane beside such with heights.
    """
    if len({part.links.shape[1] for part in parts if len(part)}) > 1:
        raise RadioError("some of its samples have heights, others have none")
    those = [part for part in parts if len(part)] or list(parts[:1])
    fitted = [part.parameters for part in parts if part.parameters is not None]
    return Learned(
        np.vstack([part.links for part in those]), np.concatenate([part.rssi for part in those]),
        fitted[-1] if fitted else None,
    )  # fmt: skip


def taught(model: ChannelModel, given: Samples | None, learned: Learned) -> ChannelModel:
    """The channel of a file, which `given` are the samples of, with what it has learnt.

    Its posterior is that of all samples, old and new; a link measured both before and now counts
    as two as far as its own deviation goes. Raises RadioError for samples that it cannot take.
    """
    if learned.parameters is not None:
        model = learned.parameters.prior(model)
        model = model if given is None else condition(model, given)
    if model.posterior is not None and model.posterior.centres.shape[1] != learned.links.shape[1]:
        raise RadioError("some of its samples have heights, others have none")
    return extended(model, learned.samples) if len(learned) else model
