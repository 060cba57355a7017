"""Runs in processes of their own: figures, limits, peers, failures."""

from __future__ import annotations

import lzma
from dataclasses import replace
from pathlib import Path

import pytest
from support.tiny import MISSION, job

from stlc.api import loads
from stlc.bench.job import Config, Limits
from stlc.bench.record import Record
from stlc.bench.run import run_job
from stlc.errors import SolverError
from stlc.milp.compile import compile_mission
from stlc.milp.writers import write_model


def _run(made: object) -> Record:
    record = run_job(made)  # type: ignore[arg-type]
    assert record is not None
    return record


def test_every_figure_of_a_solved_run() -> None:
    run = _run(job(config=Config(strategy="milp")))
    assert (run.status, run.certified, run.solved) == ("optimal", True, True)
    assert run.message == ""
    assert run.rows
    assert run.columns
    assert run.nonzeros
    assert run.lp_bound is not None
    assert run.objective is not None
    assert run.lp_bound <= run.objective + 1e-6
    assert run.first_plan is not None
    assert run.proof is not None
    assert run.compile_seconds is not None
    assert run.compile_seconds <= run.first_plan <= run.proof <= (run.wall_seconds or 0.0)
    assert 0.0 < (run.cpu_seconds or 0.0) < 10.0
    assert run.gap_60 == run.gap is not None
    assert run.peak_memory is not None
    assert run.peak_memory > 2**20
    assert "HiGHS" in run.solver
    assert "Python" in run.versions
    assert '"unroll"' in run.pass_seconds


def test_a_peer_is_solved_beside_ours(tmp_path: Path) -> None:
    ours = job()
    path = tmp_path / "one__copy.mps"
    write_model(compile_mission(loads(MISSION.format(x=1))).model, path)
    packed = {"one__copy.mps.xz": lzma.compress(path.read_bytes())}
    peer = replace(ours, main="one__copy.mps.xz", files=packed, config=Config("peer copy"))
    a, b = _run(ours), _run(peer)
    assert b.status == "optimal"
    assert b.objective == pytest.approx(a.objective, rel=1e-4)
    assert (a.rows, a.nonzeros) == (b.rows, b.nonzeros)


def test_what_is_no_model_or_mission_fails_with_its_message() -> None:
    run = _run(job(text="step 1 s\nhorizon nonsense\n"))
    assert run.status == "failed"
    assert "one.stl" in run.message
    peer = replace(job(), main="a.mps", files={"a.mps": b"this is no model"})
    assert _run(peer).status == "failed"


def test_an_infeasible_mission_is_solved() -> None:
    text = MISSION.format(x=1).replace("[2, 3]", "[9, 10]")
    run = _run(job(text=text))
    assert (run.status, run.solved, run.objective) == ("infeasible", True, None)


def test_memory_and_time_are_limited() -> None:
    small = _run(job(limits=Limits(20.0, memory=24 * 2**20)))
    assert small.status in ("out_of_memory", "failed")
    assert small.objective is None


def test_other_sources_are_refused() -> None:
    with pytest.raises(SolverError, match="other sources"):
        run_job(job(code="0123456789abcdef"))


def test_a_run_ends_when_told_to() -> None:
    assert run_job(job(), lambda: True) is None
