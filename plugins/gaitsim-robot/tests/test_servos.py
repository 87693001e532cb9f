"""Servos against the closed forms of a DC motor, and on robots of all sizes."""

import math
from typing import get_args

import mujoco
import numpy as np
import pytest
from small_robots import QUADRUPED
from stick import quadruped_spec, servoed_stick, simulation_of, standing_quadruped

from gaitsim.legged import SERVOS
from gaitsim_robot.finding import find_anatomy
from gaitsim_robot.loading import describe_robot
from gaitsim_robot.rollout import delayed_commands
from gaitsim_robot.servos import DAMPING_TIME, FROM_FILE, NARROW, STABLE, ServoName, joint_servos

EVERY = [*SERVOS.values()]


@pytest.mark.parametrize("servo", EVERY, ids=lambda servo: servo.name)
def test_an_unloaded_servo_accelerates_like_a_dc_motor(servo):
    inertia = 0.01
    model, data = servoed_stick(servo, dt=2e-4, inertia=inertia)
    data.ctrl[:] = 1e3
    time_constant = (inertia + servo.armature) * servo.no_load_speed / servo.stall_torque
    for _ in range(round(3 * time_constant / 2e-4)):
        mujoco.mj_step(model, data)
        torque = servo.stall_torque * (1 - data.qvel[0] / servo.no_load_speed)
    speed = servo.no_load_speed * (1 - math.exp(-data.time / time_constant))
    assert data.qvel[0] == pytest.approx(speed, rel=0.01)
    assert data.actuator_force[0] == pytest.approx(torque, rel=0.02)


@pytest.mark.parametrize("servo", EVERY, ids=lambda servo: servo.name)
def test_a_blocked_servo_holds_its_stall_torque(servo):
    model, data = servoed_stick(servo, dt=0.004, inertia=1e9)
    data.ctrl[:] = 1e3
    mujoco.mj_step(model, data, 20)
    assert data.actuator_force[0] == pytest.approx(servo.stall_torque)


@pytest.mark.parametrize("servo", EVERY, ids=lambda servo: servo.name)
def test_a_constant_load_deflects_a_servo_by_torque_over_stiffness(servo):
    load = servo.stall_torque / 4
    model, data = servoed_stick(servo, dt=0.004, inertia=0.01)
    data.qfrc_applied[:] = load
    mujoco.mj_step(model, data, 1000)
    assert data.qpos[0] == pytest.approx(load / servo.stiffness, rel=1e-3)


@pytest.mark.parametrize("dt", [0.001, 0.004, 0.005])
@pytest.mark.parametrize("latency", [0.0, 0.001, 0.02, 0.034])
def test_a_command_takes_effect_after_the_latency(latency, dt):
    simulation, _ = standing_quadruped("sts3215", dt=dt, latency=latency)
    commands = np.tile(simulation.rest[simulation.ctrl] + 0.1, (1, 11, 1))
    commanded = delayed_commands(simulation, commands, 0, 10)[0]
    late = math.ceil(latency / dt - 1e-9)
    assert commanded.shape == (10 * simulation.steps + 1, simulation.model.nu)
    np.testing.assert_array_equal(commanded[:late], np.tile(simulation.rest, (late, 1)))
    np.testing.assert_array_equal(
        commanded[late:, simulation.ctrl], commands[:1, 0].repeat(len(commanded) - late, 0)
    )


@pytest.mark.parametrize("servo", EVERY, ids=lambda servo: servo.name)
@pytest.mark.parametrize("inertia", [1e-6, 0.01])
def test_servos_are_stable_and_never_exceed_their_no_load_speed(servo, inertia):
    model, data = servoed_stick(servo, dt=0.004, inertia=inertia)
    random = np.random.default_rng(0)
    for _ in range(50):
        data.ctrl[:] = random.uniform(-2, 2)
        mujoco.mj_step(model, data, 10)
        assert abs(data.qvel[0]) < 1.05 * servo.no_load_speed
    mujoco.mj_step(model, data, 1000)
    np.testing.assert_allclose(data.qpos, data.ctrl, atol=1e-3)


@pytest.mark.parametrize("servo", ["model", "ideal"])
@pytest.mark.parametrize("size", [0.55, 1.0, 4.45])
def test_robots_of_0_3_to_150_kg_stand_with_servos_of_unknown_limits(size, servo):
    simulation, _ = standing_quadruped(servo, size=size, limits=False)
    data = mujoco.MjData(simulation.model)
    mujoco.mj_setState(
        simulation.model, data, simulation.start, mujoco.mjtState.mjSTATE_FULLPHYSICS
    )
    data.ctrl[:] = simulation.rest
    mujoco.mj_step(simulation.model, data, 500)
    assert data.qpos[2] > 0.95 * simulation.anatomy.stance[2]
    assert np.abs(data.qvel[:3]).max() < 0.01
    load = data.sensordata[simulation.load[:, 2]].sum()
    assert load == pytest.approx(9.81 * simulation.anatomy.mass, rel=0.005)


@pytest.mark.parametrize("name", get_args(ServoName))
def test_servos_never_exceed_their_torque_at_a_given_speed(name):
    simulation, servos = standing_quadruped(name)
    model, data = simulation.model, mujoco.MjData(simulation.model)
    mujoco.mj_setState(model, data, simulation.start, mujoco.mjtState.mjSTATE_FULLPHYSICS)
    each = [servos[model.actuator(index).name] for index in range(model.nu)]
    stall = np.array([servo.stall_torque for servo in each])
    fastest = np.array([servo.no_load_speed for servo in each])
    lower, upper = model.actuator_ctrlrange.T
    random = np.random.default_rng(1)
    largest = 0.0
    for step in range(400):
        if step % 25 == 0:
            data.ctrl[:] = random.uniform(lower, upper)
        mujoco.mj_forward(model, data)
        torque, speed = data.actuator_force, data.actuator_velocity
        assert (np.abs(torque) <= stall * (1 + 1e-12)).all()
        driving = torque * speed > 0
        left = stall * (1 - np.abs(speed) / fastest)
        assert (np.abs(torque)[driving] <= np.maximum(left, 0)[driving] + 1e-9).all()
        largest = max(largest, (np.abs(torque) / stall).max())
        mujoco.mj_step(model, data)
    assert largest > 0.5


def test_servos_have_the_limits_of_the_robot_s_text():
    _, servos = standing_quadruped("model")
    assert {(servo.stall_torque, servo.no_load_speed) for servo in servos.values()} == {(1.9, 5.45)}


@pytest.mark.parametrize(
    ("gains", "passive", "damping"),
    [
        ((40.0, 0.9), 0.0, 0.9),
        ((40.0, 0.9), 0.5, 0.9),
        ((40.0,), 0.5, 0.0),  # the joint's own damping suffices
        ((40.0,), 0.0, DAMPING_TIME * 40),
        ((40.0, 0.01), 0.0, STABLE * 40),
    ],
)
def test_servos_have_the_stiffness_and_damping_of_the_robot_s_text(gains, passive, damping):
    spec = quadruped_spec(speed=6.0, gains=gains)
    for joint in spec.joints:
        joint.damping = [passive, 0, 0]
    _, servos = simulation_of(spec.copy(), "model")
    for servo in servos.values():
        assert (servo.stiffness, servo.damping) == (40.0, pytest.approx(damping))
        assert servo.stall_torque == 1.9
        assert "stiffness 40 N m/rad" in servo.source
    _, servos = simulation_of(spec, "model", stiffness=9.0)
    assert {servo.stiffness for servo in servos.values()} == {9.0}
    assert not any("stiffness" in servo.source for servo in servos.values())


@pytest.mark.parametrize("inertia", [1e-6, 0.01])
@pytest.mark.parametrize("dt", [0.004, 0.01])
def test_the_stiffest_servos_of_a_file_are_stable(dt, inertia):
    _, servos = standing_quadruped("model", speed=6.0, gains=(1e6, 1e-6))
    servo = next(iter(servos.values()))
    assert servo.stiffness == pytest.approx(servo.stall_torque / NARROW)
    assert "stiffness reduced: the file's 1e+06 N m/rad is a placeholder" in servo.source
    model, data = servoed_stick(servo, dt=dt, inertia=inertia)
    data.ctrl[:] = 0.5
    mujoco.mj_step(model, data, round(4 / dt))
    np.testing.assert_allclose(data.qpos, 0.5, atol=1e-6)
    np.testing.assert_allclose(data.qvel, 0, atol=1e-6)


def test_options_replace_the_values_of_a_servo():
    options = {"torque_limit": 1.0, "speed_limit": 4.0, "latency": 0.01, "stiffness": 8.0}
    for name in get_args(ServoName):
        _, servos = standing_quadruped(name, **options)
        for servo in servos.values():
            assert (servo.stall_torque, servo.no_load_speed) == (1.0, 4.0)
            assert (servo.latency, servo.stiffness) == (0.01, 8.0)


def test_unrealistically_high_limits_are_lowered():
    _, servos = standing_quadruped("model", torque=1e4, speed=1e3)
    weight = 9.81 * 1.7
    for servo in servos.values():
        assert servo.stall_torque < weight
        assert servo.no_load_speed == 50.0


def test_goal_positions_agree_with_the_data_sheets():
    turns = {name: servo.travel for name, servo in SERVOS.items() if servo.ticks}
    assert {name: round(math.degrees(turn)) for name, turn in turns.items()} == {
        "ax-12a": 300,  # 0 to 1023 over 300°
        "sts3215": 360,  # 0 to 4095, with 4096 per turn
        "xl430-w250": 360,
    }
    assert SERVOS["ax-12a"].tick * 1023 == pytest.approx(turns["ax-12a"])
    assert SERVOS["xl430-w250"].tick * 4096 == pytest.approx(turns["xl430-w250"])
    assert [SERVOS[name].centre_tick for name in turns] == pytest.approx([511.5, 2048, 2048])


def test_limits_that_are_not_those_of_the_file_are_described_as_assumed():
    head, tail = QUADRUPED.split('<joint name="FL_knee"')
    limit = '<joint name="FL_knee" actuatorfrcrange="{0} {1}" '
    for torque, expected in ((7, ""), (1e4, "the file's 1e+04 N m is a placeholder")):
        text = head + limit.format(-torque, torque) + tail
        model = mujoco.MjModel.from_xml_string(text)
        servos = joint_servos(model, find_anatomy(model))
        assert "speed assumed" in servos["FL_knee"].source
        assert ("torque" in servos["FL_knee"].source) == bool(expected)
        assert expected in servos["FL_knee"].source
        assert "torque assumed" in servos["FR_knee"].source
    facts = describe_robot(simulation_of(mujoco.MjSpec.from_string(text), "model")[0], servos, {})[
        "Servos"
    ]
    assumed = [limits for joints, limits in facts.items() if joints.startswith("FL_roll")]
    assert "N m, 10 rad/s (torque assumed" in assumed[0]
    given = joint_servos(model, find_anatomy(model), torque_limit=3, speed_limit=5)
    assert {servo.source for servo in given.values()} == {FROM_FILE}
