"""What a sidecar says of a model's making is read back, and nothing else is believed."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from stlc.milp.builder import ModelBuilder
from stlc.milp.writers import sidecar_path, write_model
from stlc.milp.writers.sidecar import Made, made_before

MADE = Made("f" * 64, {"n": "3"}, "bigm", ("cse",))


@pytest.fixture
def model(tmp_path: Path) -> Path:
    """A model file with its sidecar."""
    path = tmp_path / "m.mps"
    write_model(ModelBuilder("m").build(), path, made=MADE)
    return path


def test_read_back_beside_a_solution_of_that_name(model: Path) -> None:
    assert made_before(model.with_name("m.sol"), MADE.sha256) == MADE
    assert made_before(model.with_name("m.sol"), "0" * 64) is None
    assert made_before(model.with_name("other.sol"), MADE.sha256) is None


@pytest.mark.parametrize(
    "wrong", [{"params": [1]}, {"encoding": 5}, {"disable": "cse"}, {"disable": [1]}]
)
def test_values_of_other_types_are_not_passed_on(model: Path, wrong: dict[str, object]) -> None:
    path = sidecar_path(model)
    content = json.loads(path.read_text())
    content["made"] |= wrong
    path.write_text(json.dumps(content))
    assert made_before(model.with_name("m.sol"), MADE.sha256) is None
