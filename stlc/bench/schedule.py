"""From suites and choices to the list of runs, in the order they are made."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path

from stlc.bench.job import Config, Job, Limits
from stlc.bench.machine import fingerprint
from stlc.bench.problem import Problem, Suite
from stlc.bench.registry import read_files
from stlc.errors import UsageError
from stlc.milp.encodings import compile_options
from stlc.passes import PIPELINE

STRATEGIES = ("auto", "milp")


@dataclass(frozen=True, slots=True)
class Choice:
    """What to compare. Empty `encodings`: those of each suite. `peer` is a folder of MPS files.

    `seconds` are time limits of some encodings alone: "literal", "literal:milp", or "peer" for the
    models of all peers.
    """

    encodings: tuple[str, ...] = ()
    backends: tuple[str, ...] = ("highs",)
    passes: tuple[str, ...] = ("all",)
    strategies: tuple[str, ...] = ("auto",)
    repeat: int = 1
    quick: bool = False
    only: tuple[str, ...] = ()
    peer: Path | None = None
    seconds: Mapping[str, float] = field(default_factory=dict)


def schedule(
    folder: Path, suites: Iterable[Suite], choice: Choice, limits: Limits
) -> tuple[Job, ...]:
    """Every run. Repeats are the outer loop, so that a slow hour of the machine touches all
    configurations; within a problem the order of configurations is turned round each repeat.

    UsageError for unknown encodings, passes or backends, when nothing is left to run, and for a
    time limit of an encoding that no run has.
    """
    jobs = []
    for repeat in range(choice.repeat):
        for suite in suites:
            for problem in _problems(suite, choice):
                found = list(_jobs(folder, suite, problem, choice, limits))
                if repeat % 2:
                    found.reverse()
                jobs += [replace(job, repeat=repeat) for job in found]
    if not jobs:
        raise UsageError("no problem of these suites is left; see `stlc bench --list`")
    _check_limits(jobs, choice.seconds)
    return tuple(jobs)


def _problems(suite: Suite, choice: Choice) -> list[Problem]:
    return [
        problem
        for problem in suite.problems
        if (problem.quick or not choice.quick)
        and (not choice.only or any(word in problem.name for word in choice.only))
    ]


def _jobs(
    folder: Path, suite: Suite, problem: Problem, choice: Choice, limits: Limits
) -> Iterator[Job]:
    """First repetitions: our configurations, then each peer's file by each backend."""

    def job(config: Config, main: str, files: Mapping[str, bytes]) -> Job:
        own = replace(limits, seconds=_seconds(config, choice.seconds, limits.seconds))
        where = (dict(problem.axes), problem.family)
        return Job(suite.name, problem.name, main, files, config, own, 0, fingerprint(), *where)

    files = read_files(folder, problem)
    for config in configs(choice.encodings or suite.encodings, choice):
        yield job(config, Path(problem.file).name, files)
    for name, path in _peers(problem, choice.peer):
        for backend in choice.backends:
            yield job(Config(f"peer {name}", backend), path.name, {path.name: path.read_bytes()})


def _seconds(config: Config, special: Mapping[str, float], default: float) -> float:
    return next((special[name] for name in _names(config) if name in special), default)


def _names(config: Config) -> tuple[str, ...]:
    """What a time limit may call it, the narrowest first."""
    if config.encoding.startswith("peer "):
        return (config.encoding, "peer")
    written = config.encoding.replace(",", "+")
    return (f"{written}:{config.strategy}", written)


def _check_limits(jobs: Iterable[Job], special: Mapping[str, float]) -> None:
    known = {name: None for job in jobs for name in _names(job.config)}
    for name in special:
        if name not in known:
            raise UsageError(f"--time-limit: no run has the encoding '{name}'; known: "
                             f"{', '.join(known)}")  # fmt: skip


def configs(encodings: Iterable[str], choice: Choice) -> tuple[Config, ...]:
    """Every combination. '+' joins the kinds of one encoding: 'stl=log+link=hull'; what comes
    after ':' is a strategy for this encoding alone: 'literal:milp'."""
    from stlc import backends

    for backend in choice.backends:
        if (why := backends.get(backend).available()) is not None:
            raise UsageError(f"backend {backend}: {why}")
    found = tuple(
        Config(name, backend, disabled, strategy)
        for encoding in encodings
        for disabled in ablations(choice.passes)
        for name, strategy in _strategies(encoding, choice.strategies)
        for backend in choice.backends
    )
    for config in found:
        compile_options(config.encoding, config.disabled)
    return found


def _strategies(encoding: str, common: Iterable[str]) -> list[tuple[str, str]]:
    name, _, own = encoding.partition(":")
    chosen = (own,) if own else tuple(common)
    for strategy in chosen:
        if strategy not in STRATEGIES:
            raise UsageError(f"there is no strategy '{strategy}'; known: {', '.join(STRATEGIES)}")
    return [(name.replace("+", ","), strategy) for strategy in chosen]


def ablations(words: Iterable[str]) -> tuple[tuple[str, ...], ...]:
    """Sets of passes to leave out: 'all' leaves out none, 'none' all that can be,
    'no-X' or 'no-X+Y' those, 'each' is 'all' and then each one alone."""
    optional = tuple(p.name for p in PIPELINE if not p.lowering)
    found: list[tuple[str, ...]] = []
    for word in words:
        match word:
            case "all":
                found.append(())
            case "none":
                found.append(optional)
            case "each":
                found += [(), *((name,) for name in optional)]
            case _:
                found.append(_left_out(word, optional))
    return tuple(dict.fromkeys(found))


def _left_out(word: str, optional: tuple[str, ...]) -> tuple[str, ...]:
    names = tuple(word.removeprefix("no-").split("+"))
    unknown = [name for name in names if name not in optional]
    if not word.startswith("no-") or unknown:
        raise UsageError(
            f"--passes takes all, none, each or no-NAME (names joined by +), not {word!r}; passes "
            f"that can be left out: {', '.join(optional)}"
        )
    return names


def _peers(problem: Problem, folder: Path | None) -> list[tuple[str, Path]]:
    """Models `PROBLEM__NAME.mps[.xz|.gz]` of a folder: (NAME, path)."""
    if folder is None:
        return []
    if not folder.is_dir():
        raise UsageError(f"--peer takes a folder of MPS files; {folder} is none")
    paths = sorted(folder.glob(f"{problem.name}__*.mps*"))
    return [(path.name.partition("__")[2].partition(".")[0], path) for path in paths]
