"""Sampled motion of all agents: what a solver's point is decoded to."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True, slots=True, eq=False)
class Trajectories:
    """states[agent] (T+1, n) and inputs[agent] (T, m), in the units of the mission."""

    states: Mapping[str, NDArray[np.float64]]
    inputs: Mapping[str, NDArray[np.float64]]
