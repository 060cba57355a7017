"""Time to hand a large model over to each backend, without solving it.

    python benchmarks/handover.py [BACKEND ...]

CPU seconds of this process and its children, on the model of `lit_model.py` (75,000 columns).
"""

from __future__ import annotations

import argparse
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

from lit_model import lit_model

from stlc.backends.base import SolveOptions
from stlc.milp.model import Model


def _highs(model: Model) -> object:
    from stlc.backends.highs import _loaded

    return _loaded(model)


def _mip(model: Model) -> object:
    from stlc.backends.python_mip import _loaded

    return _loaded(model, SolveOptions())


def _pulp(model: Model) -> object:
    from stlc.backends.external import _write
    from stlc.backends.templates import Files

    with tempfile.TemporaryDirectory() as folder:
        files = Files.inside(Path(folder))
        _write(model, files, SolveOptions())
        return files.model.stat().st_size


def _cvxpy(model: Model) -> object:
    import cvxpy

    from stlc.backends.cvxpy_highs import _problem

    return _problem(model)[0].get_problem_data(cvxpy.HIGHS)


def _scipy(model: Model) -> object:
    """Up to the node limit 0: what SciPy does before HiGHS starts, and its presolve."""
    from stlc.backends.scipy_milp import _run

    return _run(model, SolveOptions(time_limit=0.0, extra={"presolve": False}))


def _scip(model: Model) -> object:
    from stlc.backends.scip import _loaded

    return _loaded(model)


def _external(model: Model) -> object:
    from stlc.backends.external import _write
    from stlc.backends.templates import Files

    with tempfile.TemporaryDirectory() as folder:
        files = Files.inside(Path(folder))
        _write(model, files, SolveOptions())
        return files.model.stat().st_size


HANDOVERS: dict[str, Callable[[Model], object]] = {
    "highs": _highs, "mip": _mip, "pulp": _pulp, "cvxpy": _cvxpy, "scipy": _scipy, "scip": _scip,
    "external": _external,
}  # fmt: skip


def main() -> None:
    """Print one table: first call (with its imports) apart, then the best of three."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("backend", nargs="*", default=list(HANDOVERS))
    model = lit_model()
    print(f"{model.columns} columns, {model.rows} rows, {model.nonzeros} nonzeros")
    print(f"{'backend':10} {'first s':>8} {'best s':>8}")
    for name in parser.parse_args().backend:
        times = []
        for _ in range(4):
            began = time.process_time()
            HANDOVERS[name](model)
            times.append(time.process_time() - began)
        print(f"{name:10} {times[0]:8.2f} {min(times[1:]):8.3f}", flush=True)


if __name__ == "__main__":
    main()
