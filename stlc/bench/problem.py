"""What a registry of benchmarks says: suites of problems, described as data."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field


@dataclass(frozen=True, slots=True)
class Problem:
    """One mission file, `missions/<file>` of the registry's folder, with the `data` files it reads.

    `generator` and `parameters` say how the file was written. `axes` place the problem on growth
    curves (such as "patrol steps": 50). Problems of one `family` are reported together, with median
    and worst. `quick` problems are solved in seconds.
    """

    name: str
    file: str
    data: tuple[str, ...] = ()
    generator: str = ""
    parameters: Mapping[str, float] = field(default_factory=dict)
    axes: Mapping[str, float] = field(default_factory=dict)
    family: str = ""
    quick: bool = False


@dataclass(frozen=True, slots=True)
class Suite:
    """Problems that are compared together; `encodings` are compared unless others are asked for.

    An encoding may name its strategy: "literal:milp". The first is the one that ratios are given
    against.
    """

    name: str
    title: str
    problems: tuple[Problem, ...]
    encodings: tuple[str, ...] = ("auto",)
