"""Any solver with a command line: reads our MPS, writes a solution file, prints its verdict."""

from __future__ import annotations

import re
import shlex
import shutil
import subprocess
import time
from dataclasses import dataclass, field
from functools import cache
from pathlib import Path

from stlc.backends import cbc_log
from stlc.backends.base import Capability, Floats, Solution, SolveOptions, Status
from stlc.backends.command import last_line, run
from stlc.backends.support import (
    claimed_bound,
    ignored,
    infeasible_or_unbounded,
    require,
    trivial,
)
from stlc.backends.templates import CUSTOM, TEMPLATES, Files, Template
from stlc.errors import NoPlanError, SolverError, UsageError
from stlc.files import scratch_folder
from stlc.milp.model import Model
from stlc.milp.readers import read_solution
from stlc.milp.writers.mps import mps_chunks
from stlc.milp.writers.names import plain_texts


@dataclass(frozen=True, slots=True)
class External:
    """One command. `executable` overrides the search on PATH."""

    template: Template
    executable: str | None = None
    capabilities: Capability = field(init=False)

    def __post_init__(self) -> None:
        always = Capability.EXTRA | Capability.CANCEL | Capability.TIME_LIMIT
        object.__setattr__(self, "capabilities", self.template.capabilities | always)

    @property
    def name(self) -> str:
        """`external-cbc` and so on; `external` for a command of one's own."""
        return f"external-{self.template.name}" if self.template.name else "external"

    def available(self) -> str | None:
        """None when the command is found (always for one's own, which `extra` names)."""
        if not self.template.binary or self._found():
            return None
        return f"the command '{self.template.binary}' is not on PATH; {self.template.install}"

    def version(self) -> str:
        """What the command says about itself, or its name."""
        return _version(self._found() or "", self.template)

    def solve(self, model: Model, options: SolveOptions) -> Solution:
        """Minimise. `extra`: `executable`, `arguments` (more of them), or `command` of one's own,
        such as 'mysolver {mps} {solution}'. SolverError when it fails or writes nonsense,
        UsageError for a command that lacks these places."""
        require(self)
        if (answer := trivial(self, model, options)) is not None:
            return answer
        began = time.perf_counter()
        with scratch_folder() as folder:
            files = Files.inside(folder)
            _write(model, files, options)
            log = run(self._command(files, options), options, folder)
            x = _point(files, model)
            text = log + _head(files.solution)
        status = _verdict(self.template, text, x is not None)
        if status is None:
            status = infeasible_or_unbounded(self, model, options)
        if status is Status.OPTIMAL and x is None:
            raise SolverError(f"{self.name} claims an optimum but wrote no solution")
        x = x if status in (Status.OPTIMAL, Status.FEASIBLE) else None
        objective = None if x is None else model.objective(x)
        bound = cbc_log.bound(log) if x is not None else None
        return Solution(
            status,
            x,
            objective,
            claimed_bound(status, objective, options) if bound is None else bound,
            cbc_log.nodes(log),
            time.perf_counter() - began,
            self.name,
            self.version(),
            ignored(self, options),
            last_line(log),
        )

    def _found(self) -> str | None:
        if self.executable is not None:
            return shutil.which(self.executable)
        return shutil.which(self.template.binary) if self.template.binary else None

    def _command(self, files: Files, options: SolveOptions) -> list[str]:
        """The command's words, for no shell: those of the user's template, or of ours."""
        if not self.template.binary:
            return _own(options.extra.get("command"), files)
        executable = str(options.extra.get("executable") or self._found())
        more = shlex.split(str(options.extra.get("arguments", "")))
        return [executable, *self.template.arguments(files, options, more)]


def _own(command: object, files: Files) -> list[str]:
    """The words of the user's command; UsageError where it can't work."""
    if command is None:
        raise SolverError("backend 'external' needs a command, such as 'mysolver {mps} {solution}'")
    template = str(command).lower() if isinstance(command, bool) else str(command)
    ends = {"{mps}": "{mps}" in template, "{solution}": re.search("{sol(ution)?}", template)}
    if lost := [place for place, found in ends.items() if not found]:
        raise UsageError(f"the command {template!r} lacks {' and '.join(lost)}")
    places = {"mps": files.model, "solution": files.solution, "sol": files.solution}
    try:
        return [part.format_map(places) for part in shlex.split(template)]
    except KeyError:
        text = "has places other than {mps} and {solution}; write {{ and }} for braces"
        raise UsageError(f"the command {template!r} {text}") from None
    except (ValueError, TypeError, AttributeError) as error:
        raise UsageError(f"the command {template!r} can't be read: {error}") from None


def external(name: str, executable: str | None = None) -> External:
    """The external backend of a template: cbc, glpsol, scip, highs, cplex, gurobi_cl, fscip."""
    return External(TEMPLATES[name] if name else CUSTOM, executable)


@cache
def _version(executable: str, template: Template) -> str:
    if not executable or not template.version_argument:
        return template.binary or "external command"
    said = subprocess.run(
        [executable, template.version_argument],
        capture_output=True, text=True, timeout=30, check=False, stdin=subprocess.DEVNULL,
    )  # fmt: skip
    found = re.search(template.version_pattern, said.stdout + said.stderr)
    return f"{template.title} {found[1]}" if found else template.title


def _write(model: Model, files: Files, options: SolveOptions) -> None:
    with files.model.open("wb") as stream:
        stream.writelines(mps_chunks(model, *plain_texts(model)))
    if options.start is not None:
        rows = enumerate(options.start.tolist())
        head = "Stopped on time - objective value 0\n"
        files.start.write_text(head + "".join(f"{j} c{j} {v!r} 0\n" for j, v in rows))


def _point(files: Files, model: Model) -> Floats | None:
    if not files.solution.exists() or not files.solution.stat().st_size:
        return None
    try:
        return read_solution(files.solution, [f"c{j}" for j in range(model.columns)])
    except NoPlanError:
        return None
    except UsageError as error:
        raise SolverError(f"the solution file is not readable: {error}") from error


def _head(solution: Path) -> str:
    if not solution.exists():
        return ""
    with solution.open(errors="replace") as stream:
        return "\n" + stream.read(2000)


def _verdict(template: Template, text: str, has_point: bool) -> Status | None:
    """None when the solver cannot tell infeasible from unbounded."""
    if template.ambiguous and re.search(template.ambiguous, text, re.MULTILINE):
        return None
    for pattern, status in (
        (template.infeasible, Status.INFEASIBLE),
        (template.unbounded, Status.UNBOUNDED),
        (template.optimal, Status.OPTIMAL),
    ):
        if pattern and re.search(pattern, text, re.MULTILINE):
            return status
    return Status.FEASIBLE if has_point else Status.NO_SOLUTION
