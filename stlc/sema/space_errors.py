"""Mistakes about height: what is said of flying agents as if they moved in the plane (E0417..)."""

from __future__ import annotations

from typing import ClassVar

from stlc.diagnostics import Diagnostic


class UnboundedHeight(Diagnostic):
    """A mission has a channel, and an agent whose height nothing bounds.

    The strength of a link depends on the true distance in space. A plan knows in which cell each
    agent is, so that cells must end somewhere upwards and downwards too: bounds of the height say
    where. Write them with the agent, or in its dynamics.
    """

    code: ClassVar[str] = "E0417"
    title: ClassVar[str] = "nothing bounds the height of `{name}`"
    label: ClassVar[str] = "the cells of `{channel}` must end somewhere"
    help: ClassVar[str] = "bound it: `{state} in [0, 50]`"
    name: str
    channel: str
    state: str


class NotInSpace(Diagnostic):
    """Something is said in the plane of an agent that flies, and its height would be left out.

    Distances, separations and links of an agent with a height are those in space. What can only be
    said in the plane is refused, since it would be judged as if everything were on the ground.
    """

    code: ClassVar[str] = "E0418"
    title: ClassVar[str] = "{problem}"
    label: ClassVar[str] = "this leaves out the height"
    help: ClassVar[str] = "{hint}"
    problem: str
    hint: str
