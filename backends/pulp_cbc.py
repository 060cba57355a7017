"""The CBC that PuLP brings along, by explicit path."""

from __future__ import annotations

import os
from dataclasses import dataclass, replace
from typing import ClassVar

from stlc.backends.base import Capability, Solution, SolveOptions
from stlc.backends.external import External, external
from stlc.backends.quiet import quietly
from stlc.backends.support import missing, require
from stlc.milp.model import Model


@dataclass(frozen=True, slots=True)
class PulpCbc:
    """PuLP 3.3's own CBC 2.10.

    The command is run as that of `external-cbc` is, not by `pulp.COIN_CMD`: that one waits for CBC
    whatever happens, tells no signal from a refusal, and counts a time limit in CPU seconds.
    """

    name: ClassVar[str] = "pulp"
    capabilities: ClassVar[Capability] = (
        Capability.START
        | Capability.TIME_LIMIT
        | Capability.GAP
        | Capability.THREADS
        | Capability.SEED
        | Capability.NODES
        | Capability.CANCEL
        | Capability.EXTRA
    )

    def available(self) -> str | None:
        """None when PuLP can be imported and its CBC binary may be run."""
        problem = missing("pulp", "'stlc[pulp]'")
        if problem is None and not os.access(bundled_cbc(), os.X_OK):
            return "PuLP's CBC binary is not executable; run: pip install --force-reinstall pulp"
        return problem

    @quietly
    def version(self) -> str:
        """Such as 'CBC 2.10.3 (PuLP 3.3.2)'."""
        from importlib.metadata import version

        return f"{_command().version()} (PuLP {version('pulp')})"

    @quietly
    def solve(self, model: Model, options: SolveOptions) -> Solution:
        """Minimise. `extra` are command line options of CBC, name to value. SolverError when it
        fails or is killed."""
        require(self)
        flags = " ".join(f"-{key} {value}" for key, value in options.extra.items())
        asked = replace(options, extra={"arguments": flags} if flags else {})
        solution = _command().solve(model, asked)
        return replace(solution, solver=self.name, solver_version=self.version())


def _command() -> External:
    return external("cbc", bundled_cbc())


def bundled_cbc() -> str:
    """Path of the CBC binary inside the PuLP package (never one found on PATH)."""
    from pulp.apis.coin_api import pulp_cbc_path

    return str(pulp_cbc_path)
