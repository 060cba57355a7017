"""Solution files: each format, and a located error for each way to spoil it."""

from pathlib import Path

import numpy as np
import pytest

from stlc.errors import NoPlanError, UsageError
from stlc.milp.readers import read_solution

NAMES = ["x_0", "x_1", "n"]

GOOD = {
    "highs": "Model status\nOptimal\n\n# Primal solution values\nFeasible\nObjective 3\n"
    "# Columns 4\nx_0 1.5\nx_1 0\nn 2\nobjective.constant 1\n# Rows 1\nr 3\n",
    "cbc": "Optimal - objective value 3.00000000\n      0 x_0  1.5  0\n      2 n  2  1\n",
    "cbc outside its bounds": "Stopped on time - objective value 3\n**  0 x_0 1.5 0\n  2 n 2 1\n",
    "cbc with rows": "Optimal - objective value 3\n 0 r 3 0\n 1 s 3 0\n 0 x_0 1.5 0\n 2 n 2 1\n",
    "scip": "solution status: optimal solution found\nobjective value:   3\n"
    "x_0      1.5 \t(obj:1)\nn    2 \t(obj:1)\nobjective.constant 1 (obj:2)\n",
    "fscip": "[ Final Solution ]\nobjective value:   3\nx_0   1.5 (obj:1)\nn 2 (obj:1)\n",
    "gurobi": "# Solution for model m\n# Objective value = 3\nx_0 1.5\nx_1 0\nn 2\n",
    "glpk -w mip": "c Problem: m\nc Status: INTEGER OPTIMAL\ns mip 1 3 o 3\ni 1 3\n"
    "j 1 1.5\nj 2 0\nj 3 2\nj 4 1\ne o f\n",
    "glpk -w lp": "c Problem: m\ns bas 1 3 f f 3\ni 1 b 3 0\nj 1 b 1.5 0\nj 2 l 0 1\nj 3 b 2 0\n",
    "glpk -o": "Problem:    m\nStatus:     INTEGER OPTIMAL\n\n   No.   Row name   Activity\n"
    "------\n     1 r   3\n\n   No. Column name       Activity     Lower bound   Upper bound\n"
    "------ ------------    -------------\n     1 x_0                    1.5             0\n"
    "     2 x_1          *              0             0\n     3 n\n"
    "                    *              2             0             9\n\nInteger feasibility\n",
    "highs, style 1": "Columns\n    Index Status        Lower        Upper       Primal         "
    "Dual  Type        Name\n"
    "        0                   0            9          1.5               Continuous  x_0\n"
    "        1 LB                0            9            0            1  Continuous  x_1\n"
    "        2                   0            9            2               Integer     n\n"
    "Rows\n    Index Status        Lower        Upper       Primal         Dual  Name\n",
    "highs, style 4": "Model status\nOptimal\n\n# Primal solution values\nFeasible\nObjective 3\n"
    "# Columns -2\nx_0 1.5 0\nn 2 2\n# Rows -1\nr 3 0\n",
    "miplib": "=obj= 3\nx_0 1.5\nn 2\n",
    "cplex": '<?xml version = "1.0"?>\n<CPLEXSolution>\n'
    '  <variable name="x_0" index="0" value="1.5"/>\n'
    '  <variable name="n" index="2" value="2"/>\n</CPLEXSolution>\n',
}

BAD = {
    "an unknown column": ("# s\nx_0 1\ny 2\n", "s.sol:3: the model has no column 'y'"),
    "a column twice": ("# s\nx_0 1\nx_0 2\n", "s.sol:3: column 'x_0' has a second value"),
    "no number": ("# s\nx_0 one\n", "s.sol:2: 'one' is not a number"),
    "not a number": ("# s\nx_0 nan\n", "s.sol:2: nan is not a finite number"),
    "a missing value": ("# s\nx_0\n", "s.sol:2: expected 2 fields, found 1"),
    "another format": ("hello\n", "s.sol:1: this is none of the solution formats known"),
    "nothing": ("\n", "s.sol is empty"),
    "HiGHS cut short": (GOOD["highs"][:90], "s.sol:9: the file ends after 2 of 4 columns"),
    "HiGHS without columns": (GOOD["highs"][:30], "the file ends without a line"),
    "CBC without number": (
        "Optimal - objective value 3\n x_0 1.5 0\n",
        "s.sol:2: expected 'NUMBER",
    ),
    "GLPK beyond the columns": ("c Problem: m\ns mip 1 3 o 3\nj 9 1\n", "not a column 9"),
    "CPLEX without value": ('<?xml?>\n<variable name="n"/>\n', "s.sol:2: this <variable>"),
}

NONE = {
    "highs": "Model status\nInfeasible\n\n# Primal solution values\nNone\n\n# Dual\nNone\n",
    "cbc": "Infeasible - objective value 0\n 0 x_0 1 0\n",
    "cbc at its limit": "Stopped on time (no integer solution - continuous used) - objective\n",
    "cbc that presolved it away": "Status unknown - objective value 0\n 0 x_0 0 0\n",
    "scip": "no solution available\n",
    "glpk": "c Problem: m\ns mip 1 3 u 0\nj 1 0\n",
    "miplib": "=infeas=\n",
    "glpk printed": "Problem:    m\nStatus:     INTEGER UNDEFINED\n",
}


@pytest.mark.parametrize("kind", GOOD)
def test_reads(kind: str, tmp_path: Path) -> None:
    path = tmp_path / "s.sol"
    path.write_text(GOOD[kind])
    assert np.array_equal(read_solution(path, NAMES), [1.5, 0, 2])


@pytest.mark.parametrize("kind", GOOD)
def test_reads_what_windows_made_of_it(kind: str, tmp_path: Path) -> None:
    path = tmp_path / "s.sol"
    path.write_bytes(b"\xef\xbb\xbf" + GOOD[kind].replace("\n", "\r\n").encode())
    assert np.array_equal(read_solution(path, NAMES), [1.5, 0, 2])


@pytest.mark.parametrize("kind", BAD)
def test_malformed_files_get_a_located_error(kind: str, tmp_path: Path) -> None:
    text, message = BAD[kind]
    path = tmp_path / "s.sol"
    path.write_text(text)
    with pytest.raises(UsageError) as error:
        read_solution(path, NAMES)
    assert message in str(error.value)


@pytest.mark.parametrize("kind", NONE)
def test_files_that_say_there_is_no_solution(kind: str, tmp_path: Path) -> None:
    path = tmp_path / "s.sol"
    path.write_text(NONE[kind])
    with pytest.raises(NoPlanError):
        read_solution(path, NAMES)


def test_missing_and_binary_files(tmp_path: Path) -> None:
    with pytest.raises(UsageError, match="cannot read"):
        read_solution(tmp_path / "none.sol", NAMES)
    (tmp_path / "b.sol").write_bytes(b"\xff\xfe\x00")
    with pytest.raises(UsageError, match="not a text file"):
        read_solution(tmp_path / "b.sol", NAMES)
