"""Samples in and outside places, by the corners in the file beside the formula's half-planes."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from stlc.ir.claims import Membership
from stlc.ir.nodes import Node, walk
from stlc.mission import Mission
from stlc.verify.chains import Chain
from stlc.verify.clearance import at_steps
from stlc.verify.prisms import corrected, levels_of
from stlc.verify.robustness import TOLERANCE, Evaluator
from stlc.verify.shapes import Array, Bodies, Body, Levels


class Samples:
    """Robustness of a node that says where a sample is, corrected where its sign is wrong.

    The half-planes of the formula tell how robust it is; the shapes in the file tell whether it
    holds. `sampled` judges the formula.
    """

    def __init__(
        self, mission: Mission, chains: Mapping[str, Chain], bodies: Bodies, sampled: Evaluator
    ) -> None:
        self._mission = mission
        self._chains = chains
        self._bodies = bodies
        self._sampled = sampled

    def __call__(self, node: Node) -> Array | None:
        wrong = self._wrong(node)
        return None if wrong is None else np.where(wrong[0], wrong[1], self._sampled.judged(node))

    def differ(self, formula: Node) -> bool:
        """Whether any place in a formula is judged otherwise by its corners."""
        found = (self._wrong(node) for node in walk(formula) if node.member is not None)
        return any(wrong is not None and wrong[0].any() for wrong in found)

    def _wrong(self, node: Node) -> tuple[NDArray[np.bool_], Array] | None:
        """Where the formula has the wrong sign, and how far inside or outside a sample is."""
        claim = node.member
        if claim is None or claim.place not in self._bodies:
            return None
        value, places = self._sampled.judged(node), self._places(claim)
        if places is None:
            return None
        count = min(len(value), len(places))
        body = self._bodies.of(claim.place)
        deep = at_steps(body, places[:count, :2], claim.inside, self._mission.workspace)
        deep = corrected(deep, places[:count, -1], self._levels(claim, body), claim.inside)
        wrong = (deep < -TOLERANCE) & (value[:count] >= -TOLERANCE)
        if claim.inside:  # `outside` may take up to a millimetre more than the shape
            wrong |= (deep > TOLERANCE) & (value[:count] <= TOLERANCE)
        rest = len(value) - count
        return np.pad(wrong, (0, rest)), np.pad(deep, (0, rest))

    def _places(self, claim: Membership) -> Array | None:
        if isinstance(claim.subject, str):
            chain = self._chains.get(claim.subject)
            return None if chain is None else np.column_stack([chain.places, chain.levels])
        values = [self._sampled.judged(node) for node in claim.subject]
        count = min(map(len, values))
        return np.column_stack([value[:count] for value in values])

    def _levels(self, claim: Membership, body: Body) -> Levels | None:
        """The heights to be between, or out of [m]; None where they don't matter."""
        if body.levels is None or claim.inside:
            return body.levels
        subject = claim.subject if isinstance(claim.subject, str) else ""
        return levels_of(self._mission, subject, body)
