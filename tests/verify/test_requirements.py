"""Requirements, links on cells and at true positions, swept conditions, the objective."""

import json
import math
from dataclasses import replace

import numpy as np
import pytest
from support.judged import GRID, STILL, T, judged, radio
from support.missions import (
    agent,
    avoid,
    box,
    inside,
    mission,
    obstacle,
    outside,
    position,
    reach,
    roll,
)

from stlc.certificate import Certificate
from stlc.channels import ChannelTables, true_robustness, true_values
from stlc.ir.nodes import (
    Always,
    And,
    Linear,
    Link,
    Motion,
    Not,
    Or,
    Quantity,
    Relation,
    Swept,
    Until,
)
from stlc.ir.requirement import Requirement
from stlc.mission import Bound, Channel, Station
from stlc.plan import make_plan
from stlc.radio.partition import uniform_grid
from stlc.verify import verify
from stlc.verify.critical import _nearest
from stlc.verify.link_models import CellModel, TrueModel
from stlc.verify.requirement_report import RequirementReport
from stlc.verify.requirements import requirement_violations
from stlc.verify.subject import make_subject


def link(threshold, quantity=Quantity.RSSI, relation=Relation.AT_LEAST, **extra):
    ends = {"sender": "a", "receiver": "b"} | extra
    return Link("radio", quantity, relation=relation, threshold=threshold, **ends)


def test_margin_and_critical_step():
    one = agent("a", (0, 0, 1.0, 0))
    formula = reach("a", box(3, 5, -1, 1), T)
    runs = roll(one, STILL)
    for margin, fine in ((1.0, True), (1.0 + 9e-7, True), (1.1, False)):
        there = mission([one], [Requirement("go", formula, margin)], horizon=T)
        report = verify(there, make_plan(there, {"a": runs[0]}, {"a": runs[1]}))
        assert report.ok is fine
        assert report.requirements[0].robustness == 1.0
        assert report.requirements[0].critical == (4, "m")
    assert report.violations[0].amount == pytest.approx(0.1)
    assert "requirement go fails at step 4" in report.text()


def test_what_looks_past_the_horizon_cannot_be_judged():
    report = judged(Always(inside("a", box(0, 9, 0, 9)), 0, T + 1))
    assert [v.kind for v in report.violations] == ["requirement"]
    assert "can't be judged" in report.text()


def test_critical_follows_until_and_negation():
    left, right = inside("a", box(0, 9, 0, 9)), Not(inside("a", box(0, 2, 0, 9)))
    report = judged(Until(left, right, 1, 3))
    assert report.requirements[0].robustness == 0.5
    assert report.requirements[0].critical[1] == "m"


def mean(distance):
    return -12.89 - 30 * math.log10(distance)


def test_rssi_on_cells_and_at_true_positions():
    """Centres are 4 m apart; the agents stand at 4.8 m in the same cells."""
    formula = Always(link(mean(4.4)), 0, None)
    places = {"a": (2.1, 2.5), "b": (6.9, 2.5), "channels": [radio(predicate_bound=Bound.CENTRE)]}
    report = judged(formula, **places)
    assert report.ok
    assert report.requirements[0].robustness == pytest.approx(mean(4) - mean(4.4))
    assert report.requirements[0].true == pytest.approx(mean(4.8) - mean(4.4))
    assert [v.kind for v in report.approximate] == ["link"]
    assert "cell model only" in report.text()
    worst = judged(formula, **(places | {"channels": [radio()]}))
    assert [v.kind for v in worst.violations] == ["requirement"]
    assert not worst.approximate


def test_worst_bound_is_never_above_the_truth():
    """At 400 random places, for a predicate and for its negation."""
    rng = np.random.default_rng(7)
    there = mission([agent("a", (0, 0)), agent("b", (0, 0))], horizon=399, channels=[radio()])
    states = {n: np.hstack([rng.uniform(0, 10, (400, 2)), np.zeros((400, 2))]) for n in "ab"}
    plan = make_plan(there, states, {n: np.zeros((399, 2)) for n in "ab"})
    subject = make_subject(there, plan, None)
    cells = CellModel(subject)
    true = TrueModel(subject, cells).robustness(link(-30.0), True)
    assert (cells.robustness(link(-30.0), True) <= true + 1e-4).all()
    assert (cells.robustness(link(-30.0), False) >= true - 1e-4).all()
    assert (cells.robustness(link(-30.0), True) > true - 20).all()


def test_ties_take_the_best_cell():
    """On a border between two cells the nearer one counts, for a negation the farther one."""
    channels = [radio(predicate_bound=Bound.CENTRE)]
    spots = {"a": (2.5, 2.5), "b": (6.0, 2.5), "channels": channels}
    up = judged(Always(link(0.0), 0, None), **spots).requirements[0]
    down = judged(Always(Not(link(0.0)), 0, None), **spots).requirements[0]
    assert up.robustness == pytest.approx(mean(3))
    assert down.robustness == pytest.approx(-mean(4))


def test_outside_every_cell_the_link_is_lost():
    channels = [radio(predicate_bound=Bound.CENTRE)]
    report = judged(Always(link(-90.0), 0, None), b=(11.0, 2.5), channels=channels)
    assert report.requirements[0].robustness == -math.inf
    assert not report.ok
    json.loads(report.to_json())


@pytest.mark.parametrize(
    "predicate",
    [
        link(30.0, Quantity.SNR),
        link(1e-3, Quantity.BER, Relation.AT_MOST),
        link(1e-3, Quantity.BER_AT_MEAN, Relation.AT_MOST),
        link(0.9, Quantity.PRR),
        link(-40.0, probability=0.95),
        link(20.0, Quantity.SNR, probability=0.9),
        link(0.5, Quantity.COST, Relation.AT_MOST),
        link(-40.0, sender="base", receiver="a"),
    ],
)
def test_every_quantity_on_tiny_cells_is_the_true_value(predicate):
    """Where cells are small, worst, centre, mean and truth come together."""
    small = uniform_grid((2.499, 2.501), (2.499, 2.501), 1, 1)
    far = uniform_grid((6.499, 6.501), (2.499, 2.501), 1, 1)
    cells = type(small)(np.vstack([small.boxes, far.boxes]))
    stations = [Station("base", np.array([5.0, 0.0]))]
    for bound in Bound:
        channel = replace(radio(predicate_bound=bound), partition=cells)
        report = judged(Always(predicate, 0, None), channels=[channel], stations=stations)
        found = report.requirements[0]
        assert found.robustness == pytest.approx(found.true, abs=0.02)
        series = report.links[0].values
        assert {"distance", "rssi", "sigma", "snr", "ber", "prr"} <= set(series)


def test_true_values_of_a_station_may_be_asked_from_either_end():
    there = mission(
        [agent("a", (0, 0))], horizon=0, stations=[Station("s", np.array([3.0, 0]), 4.0)]
    )
    zero, post = np.zeros((1, 3)), np.array([[3.0, 0.0, 4.0]])
    one = true_values(there, radio(), ("a", "s"), zero, post)
    two = true_values(there, radio(), ("s", "a"), post, zero)
    assert one.distance.tolist() == two.distance.tolist() == [5.0]
    assert true_robustness(radio(), link(0.0), one)[0] == pytest.approx(mean(5))


def test_given_tables_are_turned_and_cut():
    table = np.arange(10_000.0).reshape(100, 100)
    channel = Channel("radio", GRID, tables={("a", "b"): table})
    station = Station("base", np.array([0.5, 9.5]))
    there = mission(
        [agent("a", (0, 0)), agent("b", (0, 0))], horizon=0, channels=[channel], stations=[station]
    )
    tables = ChannelTables(there)
    assert (tables.cost("radio", ("a", "b")) == table).all()
    assert (tables.cost("radio", ("b", "a")) == table.T).all()
    for_all = replace(channel, tables={None: table})
    there = replace(there, channels={"radio": for_all})
    assert (ChannelTables(there).cost("radio", ("a", "base")) == table[:, 9]).all()


def test_swept_is_judged_by_the_motion_itself():
    """Both samples are outside, the chord between them isn't; the node claims otherwise."""
    pillar = obstacle("pillar", box(1.2, 1.8, 1.0, 3.0))
    one = agent("a", (0.5, 2.0, 2.0, 0.0))
    x, u = roll(one, STILL)
    plain = avoid("a", pillar.frames[0][0])
    claim = Swept(Motion.OUTSIDE, "a", place="pillar")
    swept = Always(outside("a", pillar.frames[0][0], swept=claim), 0, T - 1)
    for formula, found in ((plain, []), (swept, ["swept"])):
        there = mission([one], [Requirement("r", formula)], horizon=T, obstacles=[pillar])
        report = verify(there, make_plan(there, {"a": x}, {"a": u}))
        assert [v.kind for v in report.violations] == found
    assert report.requirements[0].robustness > 0
    assert report.requirements[0].swept == pytest.approx(-0.3)
    assert "cuts 0.3 m into the body of " in report.text()
    body = next(c for c in report.clearances if c.what == "body")
    assert (body.value, body.time) == (pytest.approx(-0.3), pytest.approx(0.5))


def test_swept_separation_and_inside():
    axes = [
        Linear(((position("a", k), s), (position("b", k), -s)), -0.5, "m")
        for k in (0, 1) for s in (1.0, -1.0)
    ]  # fmt: skip
    apart = Swept(Motion.SEPARATION, "a", other="b", distances=(0.5, 0.5))
    formula = Always(Or(tuple(axes), swept=apart), 0, T - 1)
    report = judged(formula, a=(5.0, 2.5, 3.0, 0.0), channels=[radio()])
    assert [v.kind for v in report.violations] == ["swept"]
    assert report.requirements[0].swept == pytest.approx(-0.5)
    near = next(c for c in report.clearances if c.what == "distance")
    assert (near.value, near.time) == (pytest.approx(0.0, abs=1e-9), pytest.approx(0.5))
    within = Swept(Motion.INSIDE, "a", place="zone")
    zone = obstacle("zone", box(0, 4, 0, 4))
    stay = Always(And((inside("a", box(0, 4, 0, 4)),), swept=within), 0, T - 1)
    assert judged(stay, obstacles=[zone]).requirements[0].swept == pytest.approx(1.5)


def test_stale_plan_is_noted():
    one = agent("a", (0, 0))
    there = mission([one], horizon=T)
    plan = make_plan(there, {"a": roll(one, STILL)[0]}, {"a": STILL})
    report = verify(there, replace(plan, sha256="0" * 64))
    assert report.ok
    assert "has changed" in report.notes[0]


def test_annotate_fills_the_plan():
    one, two = agent("a", (2.5, 2.5)), agent("b", (6.5, 2.5))
    need = Requirement("talk", Always(link(-80.0), 0, None))
    there = mission([one, two], [need], horizon=T, channels=[radio()])
    runs = {"a": roll(one, STILL), "b": roll(two, STILL)}
    plan = make_plan(there, {k: v[0] for k, v in runs.items()}, {k: v[1] for k, v in runs.items()})
    report = verify(there, plan)
    full = report.annotate(plan, Certificate())
    assert full.requirements[0].robustness == report.requirements[0].robustness
    assert full.links[0].values["rssi"] == pytest.approx(np.full(T + 1, mean(4)))
    assert full.certificate == Certificate(verified=True)


def test_a_value_that_is_no_number_meets_nothing():
    there = mission([agent("r1", (1, 1))], horizon=1)
    for report in (
        RequirementReport("a", 0.0, math.nan),
        RequirementReport("a", 0.0, 1.0, corners=math.nan),
        RequirementReport("a", 0.0, 1.0, swept=math.nan),
    ):
        assert not report.satisfied
        assert len(list(requirement_violations(there, [report]))) == 1


def test_values_that_differ_by_rounding_are_one() -> None:
    """The first of them decides, on every machine and after a plan was read again."""
    assert _nearest([2.0, 1.0 + 4e-16, 1.0, 1.5], 1.0) == 1
    assert _nearest([np.inf, -np.inf], -np.inf) == 1
    assert _nearest([3.0, np.nan, 2.0], 1.0) == 2
