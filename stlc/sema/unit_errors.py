"""Mistakes about units (E03xx)."""

from __future__ import annotations

from typing import ClassVar

from stlc.diagnostics import Diagnostic


class UnknownUnit(Diagnostic):
    """A unit that isn't known.

    Known are m, s, min, h, N, Hz, bit (with prefixes n u m k M G), cm, kg, g, rad, deg, bytes, B,
    dB, dBm, dBW, percent, and their products, quotients and powers: m/s^2, dB^2, kbit/s.
    """

    code: ClassVar[str] = "E0301"
    title: ClassVar[str] = "unknown unit `{unit}`"
    label: ClassVar[str] = "not a unit"
    help: ClassVar[str] = "{hint}"
    unit: str
    hint: str


class LevelSum(Diagnostic):
    """Two absolute levels in dBm are added.

    A dBm is an absolute power; adding two of them would multiply powers, which means nothing. A
    level plus or minus a ratio in dB is a level, and the difference of two levels is a ratio in dB.
    """

    code: ClassVar[str] = "E0302"
    title: ClassVar[str] = "adding dBm to dBm has no meaning"
    label: ClassVar[str] = "both sides are absolute levels"
    help: ClassVar[str] = "one of the two should be in dB: dBm + dB is dBm, dBm - dBm is dB"


class UnitMismatch(Diagnostic):
    """Two quantities of different dimension are added or compared.

    `r1.x >= 3 dB` compares metres with decibels. A number without a unit takes the unit of the
    other side; `m/s` times `s` is `m`; levels (dBm) are compared with levels, ratios (dB) with
    ratios.
    """

    code: ClassVar[str] = "E0303"
    title: ClassVar[str] = "{left} and {right} can't be {verb}"
    label: ClassVar[str] = "{left} on the left, {right} on the right"
    help: ClassVar[str] = "{hint}"
    left: str
    right: str
    verb: str
    hint: str = "check the units of both sides; a plain number takes the unit of the other side"


class LevelAgainstRatio(Diagnostic):
    """A level in dBm is compared with a ratio in dB.

    Received strength is an absolute level: dBm. Signal-to-noise ratio is a ratio: dB.
    """

    code: ClassVar[str] = "E0304"
    title: ClassVar[str] = "a level in dBm is compared with a ratio in dB"
    label: ClassVar[str] = "{left} against {right}"
    help: ClassVar[str] = "{hint}"
    left: str
    right: str
    hint: str = "write the threshold in dBm"


class LevelProduct(Diagnostic):
    """A level in dBm, or an angle or ratio, is multiplied in a way that means nothing."""

    code: ClassVar[str] = "E0305"
    title: ClassVar[str] = "a level in dBm can't be scaled"
    label: ClassVar[str] = "dBm in a product"
    help: ClassVar[str] = "scale the ratio to a reference instead: `2 * (rssi(a, b) - (-70 dBm))`"


class WrongUnit(Diagnostic):
    """A property or argument needs another unit than it was given."""

    code: ClassVar[str] = "E0306"
    title: ClassVar[str] = "expected a value in {expected}, found {found}"
    label: ClassVar[str] = "this is in {found}"
    help: ClassVar[str] = "give it in {expected}, or as a plain number in {expected}"
    expected: str
    found: str


class BadExponent(Diagnostic):
    """A power whose exponent isn't a whole number, of a quantity that has a unit."""

    code: ClassVar[str] = "E0307"
    title: ClassVar[str] = "the exponent of a quantity must be a whole number"
    label: ClassVar[str] = "not a whole number"
    help: ClassVar[str] = "drop the unit, or use a whole exponent"
