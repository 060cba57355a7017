"""What is run, in which order, and when two runs are one."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest
from support.tiny import job, record, registry

from stlc.bench.job import Config, Limits
from stlc.bench.registry import chosen_suites, load_suites
from stlc.bench.rounds import pending, rounds
from stlc.bench.schedule import Choice, ablations, configs, schedule
from stlc.errors import UsageError


def _order(folder: Path, choice: Choice) -> list[tuple[str, str, int]]:
    jobs = schedule(folder, load_suites(folder).values(), choice, Limits())
    return [(j.problem, j.config.label, j.repeat) for j in jobs]


def test_repeats_alternate_the_order(tmp_path: Path) -> None:
    order = _order(registry(tmp_path), Choice(repeat=2, only=("one", "two")))
    first = [("one", "auto"), ("one", "log"), ("two", "auto"), ("two", "log")]
    second = [("one", "log"), ("one", "auto"), ("two", "log"), ("two", "auto")]
    assert order == [(*w, 0) for w in first] + [(*w, 1) for w in second]


def test_quick_only_and_peers(tmp_path: Path) -> None:
    folder, peers = registry(tmp_path), tmp_path / "peers"
    peers.mkdir()
    (peers / "two__bigM.mps.xz").write_bytes(b"")
    quick = Choice(encodings=("auto",), quick=True, peer=peers)
    assert _order(folder, quick) == [
        ("one", "auto", 0),
        ("two", "auto", 0),
        ("two", "peer bigM", 0),
    ]
    with pytest.raises(UsageError, match="no problem"):
        _order(folder, Choice(only=("nothing",)))
    with pytest.raises(UsageError, match="--peer takes a folder"):
        _order(folder, Choice(peer=tmp_path / "none"))


def test_ablations() -> None:
    assert ablations(("all", "no-cse+fold")) == ((), ("cse", "fold"))
    each = ablations(("each",))
    assert each[0] == ()
    assert ("cse",) in each
    assert set(ablations(("none",))[0]) == {name for names in each for name in names}
    for wrong in ("no-unroll", "cse", "no-"):
        with pytest.raises(UsageError, match="--passes takes"):
            ablations((wrong,))


def test_configurations_are_checked_before_anything_runs() -> None:
    (one,) = configs(("stl=log+link=hull",), Choice(strategies=("milp",)))
    assert one.label == "stl=log,link=hull, milp"
    (own,) = configs(("literal:milp",), Choice(strategies=("auto",)))
    assert (own.encoding, own.strategy) == ("literal", "milp")
    with pytest.raises(UsageError, match="no strategy 'luck'"):
        configs(("auto:luck",), Choice())
    with pytest.raises(UsageError, match="nonsense"):
        configs(("nonsense",), Choice())


def test_time_limits_of_some_encodings(tmp_path: Path) -> None:
    folder, peers = registry(tmp_path), tmp_path / "peers"
    peers.mkdir()
    (peers / "one__bigM.mps.xz").write_bytes(b"")
    special = {"log:milp": 7.0, "log": 5.0, "peer": 3.0}
    choice = Choice(("auto", "log", "log:milp"), only=("one",), peer=peers, seconds=special)
    jobs = schedule(folder, load_suites(folder).values(), choice, Limits(9.0))
    assert {j.config.label: j.limits.seconds for j in jobs} == {
        "auto": 9.0, "log": 5.0, "log, milp": 7.0, "peer bigM": 3.0,
    }  # fmt: skip
    with pytest.raises(UsageError, match="no run has the encoding 'hull'"):
        schedule(folder, load_suites(folder).values(), Choice(seconds={"hull": 1.0}), Limits())


def test_only_what_was_solved_is_repeated() -> None:
    first, again = job(), replace(job(), repeat=1)
    assert [[j.repeat for j in r] for r in rounds([first, again, first])] == [[0, 0], [1]]
    solved = replace(record("one", "auto", 1.0), key=first.key)
    stopped = replace(record("one", "auto", None), key=first.key)
    assert pending([first, again], []) == [first, again]
    assert pending([first, again], [solved]) == [again]
    assert pending([first, again], [stopped]) == []


def test_the_key_is_of_all_that_matters() -> None:
    base = job()
    others = [
        replace(base, repeat=1), replace(base, code="other"), replace(base, config=Config("log")),
        replace(base, limits=Limits(1.0)), replace(base, files={"one.stl": b"other"}),
        replace(base, problem="two"), replace(base, config=Config(disabled=("cse",))),
    ]  # fmt: skip
    assert len({base.key, *(other.key for other in others)}) == len(others) + 1
    assert job().key == base.key


def test_registries_that_are_none(tmp_path: Path) -> None:
    with pytest.raises(UsageError, match="--registry DIR"):
        load_suites(tmp_path)
    (tmp_path / "registry.py").write_text("SUITES = 3\n")
    with pytest.raises(UsageError, match="must define SUITES"):
        load_suites(tmp_path)
    suites = load_suites(registry(tmp_path / "good"))
    with pytest.raises(UsageError, match="no suite 'paper'; known: tiny"):
        chosen_suites(suites, ("paper",))
    (tmp_path / "good" / "missions" / "one.stl").unlink()
    with pytest.raises(UsageError, match=r"cannot read .*one\.stl"):
        schedule(tmp_path / "good", suites.values(), Choice(), Limits())
