"""Affine laws by matrices: one for all steps, or one for each, in the text or in an NPZ file."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from stlc.dynamics import Array, Law
from stlc.sema import props
from stlc.sema.channel_errors import BadData
from stlc.sema.files import Files
from stlc.sema.report import Mistake
from stlc.sema.scope import Scope
from stlc.sema.shape_errors import MatrixShape, MissingMatrix
from stlc.source import Span
from stlc.syntax import ast

_USAGE = 'laws "reference.npz"'


def given_laws(
    statement: ast.DynamicsDecl, block: props.Block, scope: Scope, files: Files
) -> list[Law]:
    """The laws of a block, by step; one where nothing varies. A Mistake at what doesn't fit."""
    item = block.get("laws")
    if item is None:
        return _of_text(statement, block, scope)
    for key in ("A", "B", "c"):
        other = block.get(key)
        if other is not None:
            raise props.bad(other, "stands beside `laws`, which has it", _USAGE)
    return _of_file(item, files)


def _of_text(statement: ast.DynamicsDecl, block: props.Block, scope: Scope) -> list[Law]:
    """`A`, `B` and `c`, each as one or as a list."""
    found = [_matrices(statement, block, key, scope) for key in ("A", "B")]
    n, m = len(found[0][0]), found[1][0].shape[1]
    _check("A", block.by_key["A"].span, found[0], (n, n))
    _check("B", block.by_key["B"].span, found[1], (n, m))
    item = block.get("c")
    drifts = [np.zeros(n)] if item is None else _vectors(item, n, scope)
    spans = [block.by_key["A"].span, block.by_key["B"].span]
    return _laws([*found, drifts], [*spans, spans[0] if item is None else item.span])


def _matrices(
    statement: ast.DynamicsDecl, block: props.Block, key: str, scope: Scope
) -> list[Array]:
    item = block.get(key)
    if item is None:
        span, name = statement.name.span, statement.name.text
        raise Mistake(MissingMatrix(span=span, name=name, matrix=key))
    return props.matrices(item, scope)


def _vectors(item: ast.Property, n: int, scope: Scope) -> list[Array]:
    """`[0, 1]`, or a list of such."""
    given = props.matrix(item, scope)
    if given.size == n:
        return [given.ravel()]
    if given.shape[1] != n:
        found = (given.size,) if 1 in given.shape else given.shape
        raise Mistake(_misfit("c", item.span, found, (n,)))
    return list(given)


def _check(key: str, span: Span, given: Sequence[Array], shape: tuple[int, int]) -> None:
    for matrix in given:
        if matrix.shape != shape:
            raise Mistake(_misfit(key, span, matrix.shape, shape))


def _misfit(key: str, span: Span, found: tuple[int, ...], expected: tuple[int, ...]) -> MatrixShape:
    texts = [" x ".join(map(str, shape)) for shape in (found, expected)]
    return MatrixShape(span=span, name=key, found=texts[0], expected=texts[1])


def _laws(parts: Sequence[Sequence[Array]], spans: Sequence[Span]) -> list[Law]:
    """One law a step; what is given once holds at all of them."""
    count = max(map(len, parts))
    for key, part, span in zip("ABc", parts, spans, strict=True):
        if len(part) not in (1, count):
            hint = "give one for all steps, or as many of each"
            found, expected = f"given for {len(part)} steps", f"for {count} like the others"
            raise Mistake(
                MatrixShape(span=span, name=key, found=found, expected=expected, hint=hint)
            )
    a, b, c = ([*part, *part * (count - len(part))] for part in map(list, parts))
    return [Law(*law) for law in zip(a, b, c, strict=True)]


def _of_file(item: ast.Property, files: Files) -> list[Law]:
    """Arrays A (T, n, n), B (T, n, m) and, if it is there, c (T, n) of an NPZ file."""
    from stlc.radio.errors import DataError
    from stlc.radio.link_table import names_in, read_array

    name = props.only(item, _USAGE)
    if not isinstance(name, ast.String):
        raise props.bad(item, "needs the name of a file", _USAGE, name.span)
    path = files.path(name.value, name.span)
    try:
        here = names_in(path)
        a, b = (read_array(path, key) for key in "AB")
        c = read_array(path, "c") if "c" in here else np.zeros(a.shape[:2])
    except DataError as error:
        hint = error.help or "write it by numpy.savez(file, A=A, B=B, c=c)"
        raise Mistake(_bad(name, error.message, hint)) from None
    return _stacked(name, a, b, c)


def _stacked(name: ast.String, a: Array, b: Array, c: Array) -> list[Law]:
    """Laws of arrays that go together."""
    shapes = ", ".join(f"{key} {part.shape}" for key, part in zip("ABc", (a, b, c), strict=True))
    fits = a.ndim == b.ndim == 3 and c.ndim == 2 and len(a) == len(b) == len(c) > 0
    fits = fits and a.shape[1] == a.shape[2] == b.shape[1] == c.shape[1] and b.shape[2] > 0
    if not fits:
        hint = "A (T, n, n), B (T, n, m) and c (T, n), one of each for every step"
        raise Mistake(_bad(name, f"the arrays are {shapes}", hint))
    return [Law(*law) for law in zip(a, b, c, strict=True)]


def _bad(name: ast.String, problem: str, hint: str) -> BadData:
    return BadData(span=name.span, path=name.value, problem=problem, hint=hint)
