"""Solution files of other solvers, read back: `read_solution(path, names)`."""

from stlc.milp.readers.solution import read_solution

__all__ = ["read_solution"]
