"""Command lines of the solvers that `external-NAME` runs, and how they state their verdict."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

from stlc.backends.base import Capability, SolveOptions


@dataclass(frozen=True, slots=True)
class Files:
    """The files of one run, all in one temporary folder."""

    model: Path
    solution: Path
    start: Path
    settings: Path

    @classmethod
    def inside(cls, folder: Path) -> Files:
        """The usual names in a folder."""
        return cls(*(folder / n for n in ("model.mps", "model.sol", "start.mst", "settings.txt")))


@dataclass(frozen=True, slots=True)
class Template:
    """How to call one solver. The patterns are searched in its log and solution file."""

    name: str
    title: str
    binary: str
    arguments: Callable[[Files, SolveOptions, Sequence[str]], list[str]]
    optimal: str
    infeasible: str
    unbounded: str
    ambiguous: str = ""
    capabilities: Capability = Capability.GAP
    version_argument: str = ""
    version_pattern: str = r"(\d+\.\d+[\w.]*)"
    install: str = ""


def _given(*pairs: tuple[str, object]) -> list[str]:
    """Flags whose value is given, flag and value apart."""
    return [text for flag, value in pairs if value is not None for text in (flag, str(value))]


def _cbc(files: Files, options: SolveOptions, more: Sequence[str]) -> list[str]:
    start = ["-mips", str(files.start)] if options.start is not None else []
    return [
        str(files.model), "-timeMode", "elapsed",
        *_given(("-sec", options.time_limit), ("-ratio", options.gap),
                ("-threads", options.workers if options.workers > 1 else 0),
                ("-randomSeed", options.seed), ("-randomCbcSeed", options.seed)),
        *start, *more, "-solve", "-solution", str(files.solution),
    ]  # fmt: skip


def _glpsol(files: Files, options: SolveOptions, more: Sequence[str]) -> list[str]:
    limit = None if options.time_limit is None else max(1, round(options.time_limit))
    flags = _given(("--tmlim", limit), ("--mipgap", options.gap), ("--seed", options.seed))
    return ["--freemps", str(files.model), *flags, *more, "-w", str(files.solution)]


def _scip(files: Files, options: SolveOptions, more: Sequence[str]) -> list[str]:
    """Commands for SCIP's shell; a time limit, gap and seed only where given."""
    settings = _given(
        ("set limits time", options.time_limit),
        ("set limits gap", options.gap),
        ("set randomization randomseedshift", options.seed),
    )
    pairs = zip(settings[::2], settings[1::2], strict=True)
    commands = [
        f"read {files.model}", "set presolving donotmultaggr TRUE",  # `_SOUND` in scip.py
        *(f"{key} {value}" for key, value in pairs), *more,
        "optimize", f"write solution {files.solution}", "quit",
    ]  # fmt: skip
    return [part for command in commands for part in ("-c", command)]


def _highs(files: Files, options: SolveOptions, more: Sequence[str]) -> list[str]:
    """HiGHS takes its settings from a file of options, written beside the model."""
    settings = {
        "mip_rel_gap": options.gap, "time_limit": options.time_limit,
        "threads": options.workers, "random_seed": options.seed,
    }  # fmt: skip
    given = [f"{key} = {value}\n" for key, value in settings.items() if value is not None]
    files.settings.write_text("".join(given))
    return [
        "--options_file", str(files.settings), "--solution_file", str(files.solution),
        *more, str(files.model),
    ]  # fmt: skip


def _cplex(files: Files, options: SolveOptions, more: Sequence[str]) -> list[str]:
    settings = _given(
        ("set timelimit", options.time_limit), ("set mip tolerances mipgap", options.gap),
        ("set threads", options.workers), ("set randomseed", options.seed),
    )  # fmt: skip
    pairs = zip(settings[::2], settings[1::2], strict=True)
    return [
        "-c", f"read {files.model}", *(f"{key} {value}" for key, value in pairs), *more,
        "optimize", f"write {files.solution}", "quit",
    ]  # fmt: skip


def _gurobi(files: Files, options: SolveOptions, more: Sequence[str]) -> list[str]:
    settings = (
        ("TimeLimit", options.time_limit), ("MIPGap", options.gap),
        ("Threads", options.workers), ("Seed", options.seed),
    )  # fmt: skip
    given = [f"{key}={value}" for key, value in settings if value is not None]
    return [*given, *more, f"ResultFile={files.solution}", str(files.model)]


def _fscip(files: Files, options: SolveOptions, more: Sequence[str]) -> list[str]:
    limit = "" if options.time_limit is None else f"TimeLimit = {options.time_limit}\n"
    files.settings.write_text(f"Quiet = TRUE\n{limit}")
    scip = files.settings.with_suffix(".set")
    scip.write_text("presolving/donotmultaggr = TRUE\n")  # `_SOUND` in scip.py
    roles = ("-sl", "-sr", "-s")  # SCIP as load coordinator, at the root, in every solver
    return [
        str(files.settings), str(files.model), *_given(*((role, scip) for role in roles)),
        "-fsol", str(files.solution), *_given(("-sth", options.workers)), *more,
    ]  # fmt: skip


_ALL = Capability.GAP | Capability.THREADS | Capability.SEED

_CBC = Template(
    "cbc", "CBC", "cbc", _cbc,
    optimal=r"^Optimal\b",
    infeasible=r"^(Infeasible|Integer infeasible|Bound tightening: infeasibility proved)\b",
    unbounded="", ambiguous=r"^Unbounded\b|infeasible!? \(?or unbounded",
    capabilities=_ALL | Capability.START | Capability.NODES,
    version_argument="-quit", version_pattern=r"(?:Version:|CBC)\s+(devel|\d\S+)",
    install="run: apt-get install coinor-cbc",
)  # fmt: skip
_GLPSOL = Template(
    "glpsol", "GLPK", "glpsol", _glpsol,
    optimal=r"^c Status:\s+(INTEGER )?OPTIMAL",
    infeasible=r"HAS NO (PRIMAL|INTEGER) FEASIBLE|^c Status:\s+INTEGER EMPTY",
    unbounded="", ambiguous=r"HAS NO DUAL FEASIBLE|HAS UNBOUNDED|^c Status:\s+UNBOUNDED",
    capabilities=Capability.GAP | Capability.SEED, version_argument="--version",
    version_pattern=r"(?:GLPSOL\D*|Solver,? v?)(\d+\.\d+)",
    install="run: apt-get install glpk-utils",
)  # fmt: skip
_SCIP = Template(
    "scip", "SCIP", "scip", _scip,
    optimal=r"^SCIP Status\s*:.*\[(optimal solution found|gap limit reached)\]",
    infeasible=r"^SCIP Status\s*:.*\[infeasible\]", unbounded=r"^SCIP Status\s*:.*\[unbounded\]",
    ambiguous=r"^SCIP Status\s*:.*\[infeasible or unbounded\]",
    capabilities=Capability.GAP | Capability.SEED, version_argument="--version",
    version_pattern=r"SCIP version (\S+)", install="get it from https://scipopt.org",
)  # fmt: skip
_HIGHS = Template(
    "highs", "HiGHS", "highs", _highs,
    optimal=r"^Model status\s*:?\s*Optimal", infeasible=r"^Model status\s*:?\s*Infeasible",
    unbounded=r"^Model status\s*:?\s*Unbounded",
    ambiguous=r"^Model status\s*:?\s*Primal infeasible or unbounded",
    capabilities=_ALL, version_argument="--version", install="get it from https://highs.dev",
)  # fmt: skip
_CPLEX = Template(
    "cplex", "CPLEX", "cplex", _cplex,
    optimal=r"(Integer optimal|- Optimal)", infeasible=r"(Integer infeasible|- Infeasible)\.?\s*$",
    unbounded="", ambiguous=r"infeasible or unbounded|unbounded", capabilities=_ALL,
    install="it comes with IBM ILOG CPLEX Optimization Studio",
)  # fmt: skip
_GUROBI = Template(
    "gurobi_cl", "Gurobi", "gurobi_cl", _gurobi,
    optimal=r"^Optimal (solution found|objective)",
    infeasible=r"^(Model is infeasible|Infeasible model)\s*$",
    unbounded="", ambiguous=r"infeasible or unbounded|is unbounded|Unbounded model",
    capabilities=_ALL, version_argument="--version", install="get it from https://www.gurobi.com",
)  # fmt: skip
_FSCIP = Template(
    "fscip", "FiberSCIP", "fscip", _fscip,
    optimal=r"SCIP Status\s*:.*problem is solved", infeasible=r"problem is solved \[infeasible\]",
    unbounded=r"\[unbounded\]", ambiguous=r"\[infeasible or unbounded\]",
    capabilities=Capability.THREADS, install="get UG from https://ug.zib.de",
)  # fmt: skip

TEMPLATES = {t.name: t for t in (_CBC, _GLPSOL, _SCIP, _HIGHS, _CPLEX, _GUROBI, _FSCIP)}


def _no_arguments(files: Files, options: SolveOptions, more: Sequence[str]) -> list[str]:
    return []


CUSTOM = Template("", "external command", "", _no_arguments, "", "", "")
