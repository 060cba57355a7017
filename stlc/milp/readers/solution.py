"""Solution files of HiGHS, CBC, SCIP, GLPK, Gurobi and CPLEX: a point by the names of the columns.

The format is told from the content. Columns that a file leaves out are 0 (CBC, SCIP and Gurobi
leave out zeros); names it has and we don't are an error, since then it belongs to another model.
"""

from __future__ import annotations

import os
import re
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TypeAlias

import numpy as np

from stlc.arrays import Floats
from stlc.errors import NoPlanError, UsageError
from stlc.inputs import InputError, read_input
from stlc.milp.writers.form import CONSTANT


@dataclass(frozen=True, slots=True)
class Line:
    """One line of the file, with its place for messages."""

    file: str
    number: int
    text: str

    def error(self, problem: str) -> UsageError:
        """A located error."""
        return UsageError(f"{self.file}:{self.number}: {problem}")


Pairs: TypeAlias = Iterator[tuple[Line, str, str]]  # (line, name, value)


def read_solution(path: str | os.PathLike[str], names: Sequence[str]) -> Floats:
    """The point x (len(names),) of a solution file, in the order of `names`.

    For a GLPK file without names (`glpsol -w`) columns count in the order they were written.
    Raises UsageError (with file and line) for a malformed file or one of another model, and
    NoPlanError when the file says that there is no solution.
    """
    lines = _lines(Path(path))
    pairs = _reader(lines)(lines, names)
    index = {name: j for j, name in enumerate(names)}
    x = np.zeros(len(names))
    seen = np.zeros(len(names), dtype=bool)
    for line, name, text in pairs:
        if name == CONSTANT:
            continue
        column = index.get(name)
        if column is None:
            raise line.error(f"the model has no column '{name}'; is this another model's solution?")
        if seen[column]:
            raise line.error(f"column '{name}' has a second value")
        x[column], seen[column] = _number(line, text), True
    return x


def _lines(path: Path) -> list[Line]:
    """The file's lines, numbered; UsageError for a file that is no text, or empty."""
    try:
        text = read_input(path).decode("utf-8-sig")
    except InputError as error:
        raise UsageError(f"cannot read {path}: {error}") from error
    except UnicodeDecodeError as error:
        raise UsageError(f"{path} is not a text file") from error
    rows = [Line(str(path), k, row) for k, row in enumerate(text.splitlines(), 1)]
    if not any(row.text.strip() for row in rows):
        raise UsageError(f"{path} is empty; the solver wrote no solution")
    return rows


def _number(line: Line, text: str) -> float:
    try:
        value = float(text)
    except ValueError:
        raise line.error(f"'{text}' is not a number") from None
    if not np.isfinite(value):
        raise line.error(f"{text} is not a finite number")
    return value


_Reader: TypeAlias = Callable[[list[Line], Sequence[str]], Pairs]


def _reader(lines: list[Line]) -> _Reader:
    first = next(line for line in lines if line.text.strip())
    head = first.text.strip()
    for pattern, reader in _FORMATS:
        if re.match(pattern, head):
            return reader
    raise first.error(
        "this is none of the solution formats known: HiGHS, CBC, SCIP, GLPK (-o, -w), Gurobi, "
        "CPLEX, MIPLIB"
    )


def _fields(line: Line, count: int) -> list[str]:
    fields = line.text.split()
    if len(fields) < count:
        raise line.error(f"expected {count} fields, found {len(fields)}: '{line.text.strip()}'")
    return fields


def _highs(lines: list[Line], names: Sequence[str]) -> Pairs:
    primal = _find(lines, r"# Primal solution values")
    if any(line.text.strip() == "None" for line in lines[primal + 1 : primal + 2]):
        raise NoPlanError(f"{lines[0].file}: HiGHS found no solution")
    at = _find(lines, r"# Columns\s+-?\d+")
    count = abs(int(lines[at].text.split()[2]))  # below 0: those that are not 0 alone
    for line in _span(lines, at + 1, count):
        name, value = _fields(line, 2)[:2]
        yield line, name, value


def _highs_table(lines: list[Line], names: Sequence[str]) -> Pairs:
    """HiGHS's table for people: values under the heading `Primal`, the name last."""
    head = _find(lines, r"\s*Index Status .*\bPrimal\b")
    end = lines[head].text.index("Primal") + len("Primal")
    for line in lines[head + 1 :]:
        if not line.text[:1].isspace():
            return
        fields = line.text[:end].split()
        if len(fields) < 2 or len(line.text.split()) < 5:
            raise line.error(f"expected a row of the table, found '{line.text.strip()}'")
        yield line, line.text.split()[-1], fields[-1]


def _miplib(lines: list[Line], names: Sequence[str]) -> Pairs:
    """Solutions of MIPLIB: `=obj= VALUE`, then `NAME VALUE`; or `=infeas=`, `=unbd=`."""
    for line in lines:
        match line.text.split():
            case ["=infeas=" | "=unbd=" as claim, *_]:
                raise NoPlanError(f"{line.file}: the file says '{claim}'")
            case [] | ["=obj=", *_]:
                continue
            case _:
                name, value = _fields(line, 2)[:2]
                yield line, name, value


def _span(lines: list[Line], start: int, count: int) -> list[Line]:
    if start + count > len(lines):
        raise lines[-1].error(f"the file ends after {len(lines) - start} of {count} columns")
    return lines[start : start + count]


def _find(lines: list[Line], pattern: str) -> int:
    for k, line in enumerate(lines):
        if re.match(pattern, line.text):
            return k
    wanted = pattern.replace(r"\s+", " ").replace(r"-?\d+", "N").replace(r"\d+", "N").strip()
    raise lines[-1].error(f"the file ends without a line '{wanted}'")


def _cbc(lines: list[Line], names: Sequence[str]) -> Pairs:
    """`NUMBER NAME VALUE COST`, rows left out; NoPlanError where CBC says that it found none."""
    head = lines[0].text
    if re.search(r"[Ii]nfeasible|[Uu]nbounded|no integer solution|Status unknown", head):
        raise NoPlanError(f"{lines[0].file}: CBC says '{head.strip()}'")
    known = set(names) | {CONSTANT}
    for line in lines[1:]:
        if not line.text.strip():
            continue
        fields = _fields(line, 3)
        if fields[0] == "**":  # CBC's mark of a value outside its bounds
            fields = fields[1:]
        if len(fields) < 3 or not fields[0].isdigit():
            raise line.error(f"expected 'NUMBER NAME VALUE COST', found '{line.text.strip()}'")
        # `printingOptions all` lists the rows first, under numbers of their own.
        if fields[1] in known or not _is_row(lines, line, fields[0]):
            yield line, fields[1], fields[2]


def _is_row(lines: list[Line], line: Line, number: str) -> bool:
    """Columns restart at 0 after the rows: a line before the last restart is a row's."""
    restarts = [other.number for other in lines[1:] if other.text.split()[:1] == ["0"]]
    return len(restarts) > 1 and line.number < restarts[-1]


def _scip(lines: list[Line], names: Sequence[str]) -> Pairs:
    """`NAME VALUE (obj:COST)`; NoPlanError where SCIP says that it found none."""
    if re.match(r"solution status:\s*(infeasible|unbounded|no solution)", lines[0].text):
        raise NoPlanError(f"{lines[0].file}: SCIP says '{lines[0].text.strip()}'")
    for line in lines:
        text = line.text.strip()
        if text == "no solution available":
            raise NoPlanError(f"{line.file}: SCIP found no solution")
        if not text or text.startswith(("solution status:", "objective value:", "#", "[")):
            continue
        name, value = _fields(line, 2)[:2]
        yield line, name, value


def _cplex(lines: list[Line], names: Sequence[str]) -> Pairs:
    """CPLEX writes XML, one `<variable name="..." ... value="..."/>` a line."""
    for line in lines:
        if not line.text.strip().startswith("<variable "):
            continue
        name = re.search(r'name="([^"]*)"', line.text)
        value = re.search(r'value="([^"]*)"', line.text)
        if name is None or value is None:
            raise line.error("this <variable> has no name or no value")
        yield line, name[1], value[1]


def _gurobi(lines: list[Line], names: Sequence[str]) -> Pairs:
    """Lines `NAME VALUE`; the columns that Gurobi makes of two-sided rows are left out."""
    known = set(names)
    for line in lines:
        if line.text.strip() and not line.text.startswith("#"):
            name, value = _fields(line, 2)[:2]
            if name in known or not name.startswith("MPS_Rg"):
                yield line, name, value


def _glpk_raw(lines: list[Line], names: Sequence[str]) -> Pairs:
    """`glpsol -w`: lines `j NUMBER VALUE ...`, named by position; `s` holds the status."""
    for line in lines:
        fields = line.text.split()
        match fields:
            case ["s", "bas", _, _, primal, *_] | ["s", "mip", _, _, primal, *_] if primal in "uin":
                raise NoPlanError(f"{line.file}: GLPK found no feasible point (status {primal})")
            case ["j", number, *values] if values:
                value = values[1] if _is_basic(lines) else values[0]
                yield line, _by_position(line, number, names), value
            case ["j", *_]:
                raise line.error(f"expected 'j NUMBER VALUE', found '{line.text.strip()}'")


def _is_basic(lines: list[Line]) -> bool:
    """Basic solutions put the basis status before the value."""
    return any(line.text.startswith("s bas") for line in lines)


def _by_position(line: Line, number: str, names: Sequence[str]) -> str:
    if not number.isdigit() or not 1 <= int(number) <= len(names) + 1:
        raise line.error(f"the model has {len(names)} columns, not a column {number}")
    return names[int(number) - 1] if int(number) <= len(names) else CONSTANT


def _glpk_printed(lines: list[Line], names: Sequence[str]) -> Pairs:
    """`glpsol -o`: a table headed `No. Column name ... Activity`; long names break the line."""
    status = next((x for x in lines if x.text.startswith("Status:")), None)
    if status is not None and re.search(r"UNDEFINED|EMPTY|INFEASIBLE|UNBOUNDED", status.text):
        raise NoPlanError(f"{status.file}: GLPK says '{status.text.split(':')[1].strip()}'")
    start = _find(lines, r"\s+No\. Column name")
    pending: list[str] = []
    for line in lines[start + 2 :]:
        fields = line.text.split()
        if not fields:
            break
        pending += fields
        if len(pending) < 3:
            continue
        _, name, *rest = pending
        values = [f for f in rest if f not in _GLPK_MARKS]
        if not values:
            raise line.error(f"no activity given for '{name}'")
        pending = []
        yield line, name, values[0]


_GLPK_MARKS = ("*", "B", "NL", "NU", "NF", "NS")

_FORMATS: tuple[tuple[str, _Reader], ...] = (
    (r"Model status", _highs),
    (r"Columns$", _highs_table),
    (r"=(obj|infeas|unbd)=", _miplib),
    (r"(Optimal|Infeasible|Integer infeasible|Unbounded|Stopped|Status unknown)\b", _cbc),
    (r"(solution status:|objective value:|no solution available|\[ Final Solution \])", _scip),
    (r"<\?xml", _cplex),
    (r"(c |s (bas|mip|ipt) )", _glpk_raw),
    (r"Problem:", _glpk_printed),
    (r"#", _gurobi),
)
