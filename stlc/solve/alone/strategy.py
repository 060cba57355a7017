"""The strategy `lone`: rows and runs from what each agent of a team does alone."""

from __future__ import annotations

from dataclasses import replace

from stlc.solve.alone.bounds import bounded, has_lone_runs, least, lone_runs
from stlc.solve.strategy import Strategy, Work


def _look_at_each(work: Work) -> Work:
    lone = lone_runs(work)
    found = replace(work, compiled=bounded(work.compiled, lone), lone=lone)
    return found.with_bound(least(work.compiled, lone))


LONE = Strategy("lone", has_lone_runs, _look_at_each)
