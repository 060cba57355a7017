"""Built-in encodings hold what every encoding has to; so does a package's, and searches use it."""

from __future__ import annotations

from importlib.metadata import EntryPoint

import numpy as np
import pytest

from stlc.api import loads
from stlc.arrays import Floats, Ints
from stlc.conformance import _PAIR, check_formula_encoding, check_table_encoding
from stlc.milp import encodings
from stlc.milp.builder import ModelBuilder
from stlc.milp.compile import CompileOptions, compile_mission
from stlc.milp.context import Affine, Context
from stlc.milp.formulas import selectors
from stlc.milp.layout import Literals, PairColumns
from stlc.milp.tables import registry
from stlc.milp.tables.cells import cell_columns
from stlc.milp.tables.encoding import Size
from stlc.milp.tables.link import Link
from stlc.milp.tables.simplex import Kind
from stlc.solve.heuristics.dive import find_start
from stlc.solve.relaxation.recognise import recognise
from stlc.solve.restricted.frame import Frame

TABLES = sorted(registry.ENCODINGS.keys() - {"literal"})
"""`literal` is the paper's, with M = 99999: what it calls optimal is not within 1e-5."""


@pytest.mark.parametrize("name", sorted(selectors.SELECTORS))
def test_formula_encodings(name: str) -> None:
    check_formula_encoding(name)


@pytest.mark.parametrize("name", TABLES)
def test_table_encodings(name: str) -> None:
    check_table_encoding(name)


class Chain:
    """A choice by counting: q_j = 1 where one of the first j alternatives is taken."""

    name, kind = "chain", "stl"
    add_rows = selectors.ONE_HOT.add_rows

    def literals(self, builder: ModelBuilder, size: int) -> Literals:
        z = builder.add_columns("pick", (size,), 0.0, 1.0)
        q = builder.binary("upto", (size,))
        for j in range(size):
            cols = [q[j], *z[: j + 1]]
            builder.add_dense_rows("count", cols, [1.0, *[-1.0] * (j + 1)], 0.0, 0.0)
        return Literals(z, self.receipt(q))

    def receipt(self, q: Ints) -> Ints:
        return q


class Forgetful(Chain):
    """It does not say what follows from its literals."""

    name = "forgetful"

    def receipt(self, q: Ints) -> Ints:
        return q[:0]


class Crossed:
    """Cell pairs by products of one-hot cells: lambda_ij >= s_i + t_j - 1, adding up to 1."""

    name, kind = "crossed", "link"

    def value(self, ctx: Context, link: Link, table: Floats) -> Affine:
        first, second = (cell_columns(ctx, place, Kind.ONE_HOT) for place in link.places)
        shape = len(first), len(second)
        pair = ctx.builder.add_columns("crossed", shape, 0.0, 1.0)
        i, j = (k.ravel() for k in np.indices(shape))
        ctx.builder.add_dense_rows(
            "both", np.column_stack([pair.ravel(), first[i], second[j]]), [1.0, -1.0, -1.0],
            -1.0, np.inf,
        )  # fmt: skip
        ctx.builder.add_dense_rows("one", pair.ravel()[None], 1.0, 1.0, 1.0)
        cells = tuple(place.reach(ctx).cells for place in link.places)
        receipt = PairColumns(
            (link.ends[0], link.ends[1]), link.step, link.spans.key, (cells[0], cells[1]), pair,
            (False, False),
        )  # fmt: skip
        ctx.layout.pairs.append(receipt)
        return Affine(pair.ravel(), link.reachable(ctx, table).ravel())

    below = value

    def size(self, shapes: object) -> Size:
        return Size(0, 0, 0)


OFFERED = {e.name: e for e in (Chain(), Forgetful(), Crossed())}


@pytest.fixture(autouse=True)
def packages(monkeypatch: pytest.MonkeyPatch) -> None:
    points = tuple(EntryPoint(name, f"x:{name}", registry.ENTRY_POINTS) for name in OFFERED)
    monkeypatch.setattr(EntryPoint, "load", lambda self: OFFERED[self.name])
    for module in (selectors, encodings, registry):
        monkeypatch.setattr(module, "entry_points", lambda group: points)


def test_a_foreign_formula_encoding_conforms() -> None:
    check_formula_encoding("chain")


def test_a_missing_receipt_is_told() -> None:
    with pytest.raises(AssertionError, match="no receipt speaks of the integer columns"):
        check_formula_encoding("forgetful")


def test_a_foreign_table_encoding_conforms_and_the_search_sees_its_cell_pairs() -> None:
    check_table_encoding("crossed")
    compiled = compile_mission(loads(_PAIR), CompileOptions(link="crossed"))
    problem = recognise(compiled)
    assert problem is not None
    blocks = Frame(compiled, problem).blocks[0, 1]
    assert [block.step for block in blocks] == [1, 2, 3]
    names = {compiled.model.col_name(int(c)).partition("_")[0] for c in blocks[0].columns.ravel()}
    assert names == {"crossed"}


def test_the_start_search_uses_a_foreign_encoding() -> None:
    text = _PAIR.partition("channel")[0] + (
        "region far = box [4.5, 6] x [4.5, 6]\nobstacle block = box [2, 3] x [0, 5]\n"
        "require go: eventually[2, 3] a in far\nrequire clear: always a outside block\n"
        "maximize robustness\n"
    )
    text = text.replace("horizon 3", "horizon 6").replace("[2, 3] a in", "[4, 6] a in")
    starts = [
        find_start(compile_mission(loads(text), CompileOptions(stl=name)))
        for name in ("unary", "chain")
    ]
    assert starts[0] is not None
    assert starts[1] is not None
    assert starts[0].objective == pytest.approx(starts[1].objective, abs=1e-4)
