"""Formulas that use a part often, `swept`: each part is looked at once."""

from __future__ import annotations

from typing import Any

import pytest

from stlc.api import loads
from stlc.ir.nodes import Node
from stlc.sema import swept

HEAD = """
horizon 3
workspace box [0, 10] x [0, 10]
agent r : single_integrator { start (1, 1); control |u| <= 1 }
let f0 = r.x >= 0 m
"""


def test_a_chain_of_formulas_each_twice_the_last_is_swept_once(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    looked: list[object] = []
    own = swept._sweep_linear

    def counted(*args: Any) -> Node:
        looked.append(args)
        return own(*args)

    monkeypatch.setattr(swept, "_sweep_linear", counted)
    lets = [f"let f{k} = f{k - 1} or not f{k - 1}" for k in range(1, 12)]
    loads("\n".join([HEAD, *lets, "require: always (f11) swept"]))
    assert 0 < len(looked) <= 2 * len(lets)
