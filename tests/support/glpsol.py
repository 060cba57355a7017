"""The part of `glpsol` that `external-glpsol` and our tests use, over GLPK's library in a wheel.

The library has no command of its own. What is solved, printed and written here is GLPK's doing;
only the reading of the command line is ours, by the flags of GLPK's own `glpsol`.
"""

from __future__ import annotations

import argparse

import swiglpk as glpk

_NO_LIMIT = 2**31 - 1  # ms, GLPK's own word for it


def main() -> int:
    """Solve one file; 0 unless it can't be read or written, as `glpsol` has it."""
    asked = _arguments()
    problem = glpk.glp_create_prob()
    if asked.freemps:
        failed = glpk.glp_read_mps(problem, glpk.GLP_MPS_FILE, None, asked.freemps)
    else:
        failed = glpk.glp_read_lp(problem, None, asked.lp)
    if failed:
        return 1
    is_mip = glpk.glp_get_num_int(problem) > 0
    _solve_mip(problem, asked) if is_mip else _solve_lp(problem, asked)
    return _write(problem, asked, is_mip)


def _arguments() -> argparse.Namespace:
    words = argparse.ArgumentParser(prog="glpsol", allow_abbrev=False)
    said = f"GLPSOL--GLPK LP/MIP Solver {glpk.glp_version()}"
    words.add_argument("--version", action="version", version=said)
    model = words.add_mutually_exclusive_group(required=True)
    model.add_argument("--freemps")
    model.add_argument("--lp")
    words.add_argument("--tmlim", type=_milliseconds, default=_NO_LIMIT)
    words.add_argument("--mipgap", type=float, default=0.0)
    words.add_argument("--seed", type=int)  # GLPK has use for it in its own generators only
    words.add_argument("-w", "--write")
    words.add_argument("-o", "--output")
    return words.parse_args()


def _milliseconds(seconds: str) -> int:
    return min(1000 * int(seconds), _NO_LIMIT)


def _solve_mip(problem: object, asked: argparse.Namespace) -> None:
    how = glpk.glp_iocp()
    glpk.glp_init_iocp(how)
    how.presolve, how.mip_gap = glpk.GLP_ON, asked.mipgap
    how.tm_lim = asked.tmlim
    glpk.glp_intopt(problem, how)


def _solve_lp(problem: object, asked: argparse.Namespace) -> None:
    how = glpk.glp_smcp()
    glpk.glp_init_smcp(how)
    how.presolve = glpk.GLP_ON
    how.tm_lim = asked.tmlim
    glpk.glp_simplex(problem, how)


def _write(problem: object, asked: argparse.Namespace, is_mip: bool) -> int:
    raw, printed = (
        (glpk.glp_write_mip, glpk.glp_print_mip)
        if is_mip
        else (glpk.glp_write_sol, glpk.glp_print_sol)
    )
    failed = asked.write is not None and raw(problem, asked.write)
    return int(failed or (asked.output is not None and printed(problem, asked.output)))


if __name__ == "__main__":
    raise SystemExit(main())
