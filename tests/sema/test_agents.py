"""Agents: dynamics, bounds, starts, families."""

from __future__ import annotations

import numpy as np
import pytest

from stlc.api import loads
from stlc.errors import MissionError
from stlc.mission import Agent, PolygonKind


def agent(text: str, name: str = "a") -> Agent:
    return loads(f"horizon 3\n{text}\nrequire: always {name}.u[0] <= 99\n").agents[name]


def codes(text: str) -> list[str]:
    with pytest.raises(MissionError) as caught:
        agent(text)
    return [d.code for d in caught.value.diagnostics]


def test_a_double_integrator_equals_its_discretised_matrices() -> None:
    named = agent("step 0.5 s\nagent a : double_integrator { start (1, 2) }").dynamics
    matrices = agent(
        "step 0.5 s\ndynamics d { continuous; states px py vx vy; inputs ux uy\n"
        "A = [[0, 0, 1, 0], [0, 0, 0, 1], [0, 0, 0, 0], [0, 0, 0, 0]]\n"
        "B = [[0, 0], [0, 0], [1, 0], [0, 1]] }\nagent a : d { start (1, 2) }"
    ).dynamics
    assert np.allclose(named.A, matrices.A)
    assert np.allclose(named.B, matrices.B)
    assert matrices.flow is not None
    assert matrices.state_units == ("m", "m", "m/s", "m/s")
    assert matrices.position is not None
    assert named.position is not None
    assert np.array_equal(named.position, matrices.position)


def test_zero_order_hold_of_a_damped_system_with_drift() -> None:
    dynamics = agent(
        "step 2 s\ndynamics d { continuous; A = [[-0.5]]; B = [[3]]; c = [1] }\n"
        "agent a : d { start 1 }"
    ).dynamics
    decay = np.exp(-1.0)
    assert dynamics.A[0, 0] == pytest.approx(decay)
    assert dynamics.B[0, 0] == pytest.approx(3 * (1 - decay) / 0.5)
    assert dynamics.drift[0] == pytest.approx((1 - decay) / 0.5)
    assert dynamics.position is None


def test_velocity_only_inputs_are_not_a_double_integrator() -> None:
    dynamics = agent(
        "dynamics d { states px py vx vy; inputs ux uy\n"
        "A = [[1, 0, 1, 0], [0, 1, 0, 1], [0, 0, 1, 0], [0, 0, 0, 1]]\n"
        "B = [[0, 0], [0, 0], [1, 0], [0, 1]] }\nagent a : d { start (1, 2, 0.5, 0) }"
    ).dynamics
    assert dynamics.flow is not None
    assert np.allclose(dynamics.flow.B[:2], -0.5 * np.eye(2))


def test_bounds() -> None:
    found = agent(
        """
agent a : double_integrator {
  start (1, 1, 0.5, 0)
  control |u| <= 1 m/s^2
  ux <= 0.5
  px in [0, 10]
  py >= -3 m
  state |v| <= 2
  speed <= 3 polygon 8 outer
  effort_state (0, 0, 1, 2)
  effort_input 3
}"""
    )
    assert np.array_equal(found.start, [1, 1, 0.5, 0])
    assert np.array_equal(found.input_lower, [-1, -1])
    assert np.array_equal(found.input_upper, [0.5, 1])
    assert np.array_equal(found.state_lower, [0, -3, -2, -2])
    assert np.array_equal(found.state_upper, [10, np.inf, 2, 2])
    assert np.array_equal(found.effort_state, [0, 0, 1, 2])
    assert np.array_equal(found.effort_input, [3, 3])
    (norm,) = found.state_norms
    assert (norm.indices, norm.limit, norm.sides) == ((2, 3), 3.0, 8)
    assert norm.kind is PolygonKind.OUTER


def test_speed_is_inscribed_unless_said() -> None:
    (norm,) = agent("agent a : double_integrator { start (1, 1); speed <= 2 }").state_norms
    assert norm.kind is PolygonKind.INSCRIBED


def test_the_speed_of_a_single_integrator_is_its_input() -> None:
    found = agent("agent a : single_integrator { start (1, 1); speed <= 2 m/s }")
    assert found.input_norms[0].limit == 2.0


def test_a_force_is_divided_by_the_mass() -> None:
    found = agent("agent a : double_integrator { start (1, 1); mass 2 kg; control |u| <= 3 N }")
    assert np.array_equal(found.input_upper, [1.5, 1.5])


def test_bounds_of_the_dynamics_are_inherited() -> None:
    found = agent(
        "dynamics d = double_integrator { control |u| <= 1; speed <= 2 }\n"
        "agent a : d { start (1, 1); control |u| <= 5 }"
    )
    assert np.array_equal(found.input_upper, [5, 5])
    assert found.state_norms[0].limit == 2.0


def test_turn_rate() -> None:
    found = agent(
        "agent a : double_integrator { start (1, 1, 1, 0); control |u| <= 1; speed <= 2;"
        " turn_rate literal directions 12 }"
    )
    assert found.turn_rate is not None
    assert (found.turn_rate.u_max, found.turn_rate.v_max) == (1.0, 2.0)
    assert (found.turn_rate.directions, found.turn_rate.literal) == (12, True)


def test_families_use_their_number() -> None:
    mission = loads(
        "horizon 2\nagent uav[2..4] : double_integrator { start (2 * i, i) }\n"
        "require: always forall a in uav: a.x >= uav[2].x\n"
    )
    assert list(mission.agents) == ["uav[2]", "uav[3]", "uav[4]"]
    assert np.array_equal(mission.agents["uav[3]"].start, [6, 3, 0, 0])


def test_outputs_are_linear_signals() -> None:
    dynamics = agent(
        "dynamics d { A = [[1]]; B = [[1]]; states level; inputs flow\n"
        "output total = 2 * level - flow + 3 }\nagent a : d { start 1 }"
    ).dynamics
    c, d, constant, unit = dynamics.outputs["total"]
    assert (c.tolist(), d.tolist(), constant, unit) == ([2.0], [-1.0], 3.0, "")


@pytest.mark.parametrize(
    ("text", "code"),
    [
        ("dynamics d { A = [[1]]; B = [[1]]; states p q }\nagent a : d { start 1 }", "E0208"),
        ("dynamics d = circle\nagent a : d { start 1 }", "E0201"),
        ("agent a : cart { start 1 }", "E0201"),
        ("agent a : double_integrator { start (1, 1); px <= 3 dB }", "E0306"),
        ("agent a : double_integrator { start (1 s, 1) }", "E0306"),
        ("agent a : double_integrator { start (1, 1); mass -1 kg }", "E0208"),
        ("agent a : double_integrator { start (1, 1); effort_input (1, -1) }", "E0208"),
        ("dynamics d { A = [[1]]; B = [[1]]; position p q }\nagent a : d { start 1 }", "E0201"),
    ],
)
def test_mistakes(text: str, code: str) -> None:
    assert codes(text) == [code]


@pytest.mark.parametrize("step", ["0 s", "-1 s", "1e300 s", "1e-300 s"])
def test_steps_that_no_dynamics_can_have(step: str) -> None:
    with pytest.raises(MissionError, match="step"):
        loads(f"step {step}\nagent a : double_integrator {{ start (0, 0) }}\n")


def test_agents_with_mistakes_are_no_empty_list() -> None:
    text = "agent a : kart { start (1, 1) }\nrequire: forall r in agents: eventually[0, 3] r.x >= 2"
    with pytest.raises(MissionError) as caught:
        loads(text)
    assert [d.code for d in caught.value.diagnostics] == ["E0201"]


def test_a_speed_needs_a_velocity() -> None:
    text = (
        "dynamics d { A = [[1, 0], [0, 1]]; B = [[1], [0]] }\n"
        "agent a : d { start (0, 0); speed <= 2 }\nrequire: eventually[0, 3] a.x0 >= 1"
    )
    with pytest.raises(MissionError, match="needs dynamics that name their velocity"):
        loads(text)


@pytest.mark.parametrize(
    ("dimensions", "start", "state"),
    [
        (1, "2", [2, 0]),
        (1, "(2, 1)", [2, 1]),
        (2, "(1, 2)", [1, 2, 0, 0]),
        (3, "(1, 2, 3)", [1, 2, 3, 0, 0, 0]),
        (3, "(1, 2, 3, 4, 5, 6)", [1, 2, 3, 4, 5, 6]),
    ],
)
def test_a_start_may_be_a_position_in_every_dimension(dimensions, start, state) -> None:
    text = f"dynamics d = double_integrator {{ dimensions {dimensions} }}\n"
    text += f"agent r : d {{ start {start}; control |u| <= 1 }}\n"
    text += "require a: always[0, 2] r.px >= 0 m\n"
    assert loads(text).agents["r"].start.tolist() == state


KART = "agent a : double_integrator {{ start (1, 1); control |u| <= 1; {} }}"


@pytest.mark.parametrize(
    ("written", "state", "low", "high"),
    [
        ("-1 <= vx <= 1", 2, -1.0, 1.0),
        ("1 >= vx > -1", 2, -1.0, 1.0),
        ("-1 m/s <= vx <= 0.5 m/s", 2, -1.0, 0.5),
        ("|vx| <= 1", 2, -1.0, 1.0),
        ("vx >= -1", 2, -1.0, np.inf),
        ("2 >= vx", 2, -np.inf, 2.0),
        ("(-1) <= vx; vx <= 3", 2, -1.0, 3.0),
        ("-most <= vx <= most", 2, -0.5, 0.5),
        ("|vx| <= most", 2, -0.5, 0.5),
        ("-most <= vx", 2, -0.5, np.inf),
        ("-(1 + 1) <= vy <= 2 * 2", 3, -2.0, 4.0),
        ("mass 2 kg\n-1 <= vx <= 1", 2, -1.0, 1.0),
        ("integer\n|vy| <= 1", 3, -1.0, 1.0),
        ("mass 2 kg # heavy\n\n  |vx| <= 1\n", 2, -1.0, 1.0),
        ("speed <= 5\n  - 1\n0 <= px <= 4", 0, 0.0, 4.0),
    ],
)
def test_bounds_as_bare_comparisons(written: str, state: int, low: float, high: float) -> None:
    made = agent("param most = 0.5\n" + KART.format(written))
    assert (made.state_lower[state], made.state_upper[state]) == (low, high)


def test_a_comparison_that_goes_on_below_is_one_property() -> None:
    made = agent(KART.format("speed <= 5\n  - 1\n"))
    assert [norm.limit for norm in made.state_norms] == [4.0]
    made = agent("agent a : double_integrator { start (1, 1); control\n  |u| <= 2\n}")
    assert np.array_equal(made.input_upper, [2.0, 2.0])


def test_a_comparison_of_no_state_is_told() -> None:
    assert codes(KART.format("-1 <= wx <= 1")) == ["E0207"]
    assert codes(KART.format("-1 <= 3")) == ["E0207"]
    assert codes(KART.format("3 <= vx <= 1")) == ["E0410"]
    assert codes(KART.format("-1 dB <= vx <= 1")) == ["E0306"]


TANK = (
    "dynamics tank {{ A = [[0.9, 0.1], [0, 1]]; B = [[0], [1]]; states level flow; inputs pump;"
    " {} }}\nagent a : tank {{ start (1, 0); {} }}"
)


def test_dynamics_bound_their_states_and_inputs_by_name() -> None:
    made = agent(TANK.format("pump in [0, 1]; level <= 5; -2 <= flow <= 2", ""))
    assert np.array_equal(made.input_lower, [0.0])
    assert np.array_equal(made.input_upper, [1.0])
    assert np.array_equal(made.state_lower, [-np.inf, -2.0])
    assert np.array_equal(made.state_upper, [5.0, 2.0])
    own = agent(TANK.format("pump in [0, 1]; level <= 5", "level <= 9; flow >= -1"))
    assert np.array_equal(own.state_upper, [9.0, np.inf])
    assert np.array_equal(own.state_lower, [-np.inf, -1.0])
    assert np.array_equal(own.input_upper, [1.0])
    unnamed = "dynamics d { A = [[1]]; B = [[1]]; x0 <= 4; u0 in [-1, 1] }\nagent a : d { start 1 }"
    assert np.array_equal(agent(unnamed).state_upper, [4.0])


def test_named_kinds_bound_them_too() -> None:
    base = "dynamics d = double_integrator { vx <= 2; control |u| <= 1; speed <= 3 }\n"
    made = agent(base + "agent a : d { start (1, 1); control |u| <= 2 }")
    assert made.state_upper[2] == 2.0
    assert np.array_equal(made.input_upper, [2.0, 2.0])
    assert [norm.limit for norm in made.state_norms] == [3.0]


def test_what_dynamics_do_not_have_is_told_once() -> None:
    assert codes(TANK.format("levl <= 5; pump in [0, 1]", "")) == ["E0207"]
    assert codes(TANK.format("x7 <= 5; pump in [0, 1]", "")) == ["E0207"]
    both = "dynamics d { B = [[1]]; stats x; x0 <= 1 }\nagent a : d { start 1 }"
    assert sorted(codes(both)) == ["E0207", "E0409"]
    family = TANK.format("level <= 5 dB; state_units m m/s", "").replace(
        "agent a ", "agent b[1..3] "
    )
    with pytest.raises(MissionError) as caught:
        loads(f"horizon 3\n{family}\nrequire: always b[1].pump <= 9\n")
    assert [d.code for d in caught.value.diagnostics] == ["E0306"]


def test_the_number_of_a_member_in_every_property() -> None:
    text = (
        "horizon 3\nagent f[1..3] : double_integrator { start (i, 1); control |u| <= i; "
        "-i <= vx <= i; px in [0, 10 * i]; mass i; effort_input (i, 1) }\n"
        "require: always f[1].x <= 9\n"
    )
    made = loads(text).agents["f[3]"]
    assert np.array_equal(made.input_upper, [3.0, 3.0])
    assert (made.state_lower[2], made.state_upper[2], made.state_upper[0]) == (-3.0, 3.0, 30.0)
    assert np.array_equal(made.effort_input, [3.0, 1.0])
    assert made.mass == 3.0


def test_a_parameter_called_v_bounds_each_input() -> None:
    mission = loads(
        "param v = 1\nhorizon 2\n"
        "agent r : single_integrator { start (0, 0); control |u| <= v }\n"
        "require a: always r.x >= 0 m\n"
    )
    agent = mission.agents["r"]
    assert not agent.input_norms
    np.testing.assert_array_equal(agent.input_upper, [1, 1])
