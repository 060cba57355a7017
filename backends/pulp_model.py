"""Our arrays as the problem that PuLP's solver commands ask for."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import ClassVar

import numpy as np

from stlc.backends.base import Floats
from stlc.milp.model import Model
from stlc.milp.writers.mps import mps_chunks
from stlc.milp.writers.names import plain_texts


@dataclass(frozen=True, slots=True)
class Column:
    """What a command asks of a variable."""

    name: str
    start: float

    def value(self) -> float:
        """Its value in the MIP start."""
        return self.start


@dataclass(slots=True)
class FileProblem:
    """Stands in for `pulp.LpProblem` in `COIN_CMD.actualSolve`, which wants a file and no more.

    More than ten times as fast as a PuLP object for every column, row and coefficient, from which
    PuLP would write such a file. `x` (n,), `status` and `sol_status` are CBC's answer.
    """

    model: Model
    start: Floats | None = None
    x: Floats | None = None
    status: int = 0
    sol_status: int = 0
    name: ClassVar[str] = "model"
    sense: ClassVar[int] = 1  # pulp.LpMinimize

    def writeMPS(
        self, path: str, rename: int
    ) -> tuple[list[Column], dict[str, str], dict[str, str], str]:
        """Write the file; columns, and the names of columns and rows in the file and outside."""
        with Path(path).open("wb") as stream:
            stream.writelines(mps_chunks(self.model, *plain_texts(self.model)))
        start = np.zeros(self.model.columns) if self.start is None else self.start
        columns = [Column(f"c{j}", value) for j, value in enumerate(start.tolist())]
        return columns, {column.name: column.name for column in columns}, {}, "COST"

    def assignVarsVals(self, values: Mapping[str, float]) -> None:
        """Keep the point."""
        self.x = np.array([values[f"c{j}"] for j in range(self.model.columns)])

    def assignStatus(self, status: int, sol_status: int) -> None:
        """Keep `pulp.LpStatus` and `pulp.LpSolution`."""
        self.status, self.sol_status = status, sol_status

    def assignVarsDj(self, values: Mapping[str, float]) -> None:
        """Nobody asks for reduced costs."""

    def assignConsPi(self, values: Mapping[str, float]) -> None:
        """Nobody asks for shadow prices."""

    def assignConsSlack(self, values: Mapping[str, float], activity: bool) -> None:
        """Nobody asks for slacks."""
