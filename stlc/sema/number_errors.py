"""Mistakes about numbers that doubles can't hold (E0308 and on)."""

from __future__ import annotations

from typing import ClassVar

from stlc.diagnostics import Diagnostic


class NotFinite(Diagnostic):
    """Dynamics whose discretisation overflows.

    Continuous dynamics x' = A x + B u + c become x(t+1) = e^(A dt) x(t) + .., and e^x exceeds what
    doubles can hold from x = 709 on.
    """

    code: ClassVar[str] = "E0308"
    title: ClassVar[str] = "`{name}` can't be discretised: e^(A dt) overflows"
    label: ClassVar[str] = "A dt has an eigenvalue with the real part {growth:.3g}"
    help: ClassVar[str] = "use a shorter `step`, or check the entries of A"
    name: str
    growth: float


class OutOfScale(Diagnostic):
    """A parameter of a channel that no radio has, and with which its formulas overflow."""

    code: ClassVar[str] = "E0309"
    title: ClassVar[str] = "`{name}` is {value:g}, which is not between {least:g} and {most:g}"
    label: ClassVar[str] = "out of scale"
    help: ClassVar[str] = "check its unit and its exponent"
    name: str
    value: float
    least: float
    most: float
