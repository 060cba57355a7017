"""Small files that say a lot: cheap, or refused with the size they would have."""

from __future__ import annotations

from pathlib import Path

import pytest

from stlc.api import load, loads
from stlc.errors import MissionError
from stlc.ir.nodes import And, Linear, Node, Not, Role, Signal, walk
from stlc.milp.compile import compile_mission
from stlc.sema import scope

AGENT = "horizon 3\nagent r : double_integrator { start (1, 1); control |u| <= 1 }\n"


def doubling(first: str, step: str, levels: int) -> str:
    lets = "".join(f"let e{k + 1} = {step.format(e=f'e{k}')}\n" for k in range(levels))
    return f"{AGENT}let e0 = {first}\n{lets}"


def test_definitions_of_numbers_are_worked_out_once() -> None:
    text = doubling("r.x", "{e} + {e}", 300) + "require a: eventually e300 >= 1 m\n"
    mission = loads(text)
    leaf = mission.requirements[0].formula.children[0]
    assert isinstance(leaf, Linear)
    assert leaf.terms[0][1] == 2.0**300
    assert not mission.warnings


def test_equal_folds_are_added_up() -> None:
    text = doubling("abs(r.x)", "{e} + {e}", 100) + "require a: eventually e100 >= 1 m\n"
    assert len(loads(text).requirements[0].formula.children[0].children) == 2


def test_definitions_with_parameters_are_worked_out_once_for_each_argument() -> None:
    lets = "".join(f"let f{k + 1}(x) = f{k}(x) + f{k}(x + 1)\n" for k in range(40))
    text = f"{AGENT}let f0(x) = r.x + x\n{lets}require a: eventually f40(1) >= 1\n"
    mission = loads(text)
    assert mission.requirements[0].formula.children[0].terms[0][1] == 2.0**40
    assert not mission.warnings


def test_a_definition_that_others_use_is_used() -> None:
    text = f"{AGENT}let a = r.x >= 1 m\nlet b = a and a\nlet c = b or b\nrequire c: eventually c\n"
    assert not loads(text).warnings
    unused = loads(text.replace("eventually c", "eventually b")).warnings
    assert [w.name for w in unused] == ["c"]


def codes(text: str) -> list[str]:
    with pytest.raises(MissionError) as caught:
        loads(AGENT + text)
    assert all(d.span is not None for d in caught.value.diagnostics)
    return [d.code for d in caught.value.diagnostics]


@pytest.mark.parametrize(
    "text",
    [
        "require a: always forall i in 1..999: forall j in 1..999: r.x >= i + j - 5000",
        "require a: always (r.x >= sum i in 1..999: sum j in 1..999: i * j)",
        "".join(f"let f{k + 1}(x) = f{k}(2 * x) and f{k}(2 * x + 1)\n" for k in range(40))
        + "let f0(x) = r.x >= x\nrequire a: eventually f40(1)\nrequire b: eventually r.x >= 1",
    ],
)
def test_what_multiplies_is_refused_once(text: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(scope, "MOST_WORK", 20_000)
    assert codes(text + "\n") == ["E0224"]


def test_the_size_is_told(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(scope, "MOST_WORK", 1000)
    cube = "forall i in 1..1000: forall j in 1..1000: forall k in 1..1000: r.x >= i + j + k"
    with pytest.raises(MissionError, match="expands to 1e\\+09 instances"):
        loads(f"{AGENT}require a: always {cube}\n")


def test_folds_within_folds_are_refused_early() -> None:
    text = "let e0 = abs(r.x)\n"
    text += "".join(f"let e{k + 1} = max(e{k}, r.y) + abs(e{k})\n" for k in range(30))
    assert set(codes(text + "require a: eventually e30 >= 1 m\n")) == {"E0213"}


def test_a_long_chain_of_imports_is_no_circle(tmp_path: Path) -> None:
    for k in range(60):
        (tmp_path / f"l{k}.stl").write_text(f'import "l{k + 1}.stl"\nlet f{k}(a) = a.x >= {k}\n')
    with pytest.raises(MissionError) as caught:
        load(tmp_path / "l0.stl")
    assert caught.value.diagnostics[0].code == "E0212"


def test_formulas_that_use_others_twice_are_compared_once() -> None:
    """Told by a number of their own, two equal ones have more paths than could be walked."""

    def doubled(levels: int) -> Node:
        node: Node = Linear(((Signal("r", Role.STATE, 0), 1.0),), 0.0, "m")
        for _ in range(levels):
            node = And((node, Not(node)))
        return node

    assert doubled(3000) == doubled(3000)
    assert doubled(3000) != doubled(2999)
    chain = "".join(f"let f{k} = f{k - 1} and not f{k - 1}\n" for k in range(1, 501))
    text = f"{AGENT}let f0 = r.x >= 0\n{chain}require: f500\n"
    assert loads(text).requirements


def test_equal_formulas_are_compared_once_and_for_all(monkeypatch: pytest.MonkeyPatch) -> None:
    """Every level of two equal chains against its twin: as many comparisons as there are levels."""

    def chain(levels: int) -> list[Node]:
        nodes: list[Node] = [Linear(((Signal("r", Role.STATE, 0), 1.0),), 0.0, "m")]
        for _ in range(levels):
            nodes.append(And((nodes[-1], Not(nodes[-1]))))
        return nodes

    counted: list[Node] = []
    own = Node.own.fget
    monkeypatch.setattr(Node, "own", property(lambda node: counted.append(node) or own(node)))
    one, other = chain(300), chain(300)
    assert all(a == b for a, b in zip(reversed(one), reversed(other), strict=True))
    assert one[300] != other[299]
    assert len(counted) < 3 * 2 * 300
    assert chain(300)[-1] == one[-1] == other[-1]
    assert hash(one[-1]) == hash(other[-1])


def test_iff_within_iff_is_worked_out_once_for_each_polarity() -> None:
    """Both sides stand under both polarities: 2^60 ways down, and two meanings."""
    deep = "(r.x >= 1) iff (" * 60 + "r.y >= 0" + ")" * 60
    mission = loads(f"{AGENT}require a: eventually ({deep})\n")
    assert compile_mission(mission).model.rows > 0
    lengths = deep.replace("r.x >= 1", "distance(r, (3, 3)) >= 1").replace("60", "9")
    assert loads(f"{AGENT}require a: eventually ({lengths})\n").requirements


def test_counts_may_be_given_to_definitions() -> None:
    agents = "agent r[1..3] : double_integrator { start (i, 1); control |u| <= 1 }\n"
    let = "let enough(n) = n >= 2\n"
    rule = "require a: eventually enough(count(b in agents: b.x >= 3))\n"
    plain = "require a: eventually count(b in agents: b.x >= 3) >= 2\n"
    found, want = (loads(f"horizon 3\n{agents}{t}").requirements[0] for t in (let + rule, plain))
    assert found.formula == want.formula


def test_quantifiers_are_refused_before_they_are_written_out() -> None:
    team = "horizon 3\nagent r[1..1000] : double_integrator { start (i, 1); control |u| <= 1 }\n"
    each = "require a: always forall b in agents: (sum a in agents: a.x) >= b.x\n"
    with pytest.raises(MissionError, match="expands to 1e\\+06 instances"):
        loads(team + each)
    once = "let all = sum a in agents: a.x\nrequire a: always forall b in agents: all >= b.x - 1\n"
    assert loads(team + once).requirements


def test_long_sums_are_what_short_ones_are() -> None:
    """Added up at once from a number of terms on, with the same units and signs."""
    signals = "".join(f"signal s{k}\n" for k in range(400))
    terms = " + ".join(f"s{k}" for k in range(400))
    less = "".join(f" - 2 * s{k} + 1" for k in range(0, 400, 2))
    mission = loads(f"step 1 s\n{signals}require: always ({terms}{less} >= 0)\n")
    (found,) = (n for n in walk(mission.requirements[0].formula) if isinstance(n, Linear))
    factors = {signal.owner: factor for signal, factor in found.terms}
    assert factors == {f"s{k}": 1.0 if k % 2 else -1.0 for k in range(400)}
    assert found.constant == 200.0
    gone = f"require: always ({terms} - {terms.replace(' + ', ' - ')} >= -1)\n"
    assert loads(f"step 1 s\n{signals}{gone}").requirements
    with pytest.raises(MissionError, match="E03"):
        loads(f"step 1 s\n{signals}require: always ({terms} + 1 m + 1 s >= 0)\n")
