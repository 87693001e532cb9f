"""Driving a virtual robot, in the time of the bytes on its wire."""

from types import SimpleNamespace

import numpy as np
import pytest
from wires import Wire, quadruped, robot_on

from gaitsim.errors import GaitsimError
from gaitsim.gait.gait_files import read_gait
from gaitsim_hardware.calibration import Calibration
from gaitsim_wire.driving import GaitPlayer, SafetyLimits, Session, Stopped
from gaitsim_wire.emulator import Fault, Noise
from gaitsim_wire.robots import bus_of, calibration_of, pilot_of

SLOW = [pytest.param(bus, marks=pytest.mark.slow) for bus in ("dynamixel", "serial")]
BUSES = ["feetech", *SLOW]
WITH_SERVOS = BUSES[:2]
FULL = {"feetech": 1_000_000, "dynamixel": 1_000_000, "serial": 115_200}


@pytest.fixture(scope="module")
def pilot():
    """Return a function that returns the controller of a trot."""
    robot = quadruped().organism
    genome = next(iter(robot.starts().values()))
    return lambda imu: pilot_of(robot, genome, imu=imu)


@pytest.fixture
def connected():
    """Return a function that connects a client to a virtual robot."""

    def connect(bus, *faults, imu=True, baud=None, calibration=None, **options):
        wire = Wire(robot_on(bus, *faults, **options), FULL[bus])
        calibration = calibration or calibration_of(quadruped().organism, bus, None)
        line = bus_of(bus, wire, baud or FULL[bus], calibration, imu=imu)
        line._clock, line._sleep = wire.time, wire.sleep
        return SimpleNamespace(
            wire=wire, bus=line, calibration=calibration, body=wire.emulator.body
        )

    return connect


@pytest.fixture
def driven(connected, pilot):
    """Return a function that checks a robot and begins to drive it."""

    def begin(bus, *faults, imu=True, walk=True, limits=None, **options):
        found = connected(bus, *faults, imu=imu, **options)
        found.bus.check()
        found.player = GaitPlayer(pilot(imu), imu=imu, walk=walk)
        found.session = Session(
            found.bus, found.player, found.calibration, limits or SafetyLimits(volts=4.5),
            found.wire.time, found.wire.sleep,
        )  # fmt: skip
        return found

    return begin


@pytest.mark.parametrize("bus", BUSES)
def test_the_robot_rises_walks_and_lies_down(driven, bus, tmp_path):
    robot, phases = driven(bus), []
    rested = robot.body.angles

    def poll(status):
        phases.append(status.phase)
        if status.seconds > 4:
            robot.player.stop()

    robot.session.run(poll)
    status = robot.session.status
    assert [*dict.fromkeys(phases)] == ["rising", "driving", "lying down"]
    assert not robot.body.on.any()
    assert robot.body.place[0] > 0.05
    assert (status.late, status.clipped) == (0, 0)
    robot.session.recording.write(tmp_path / "robot.npz", tuple(robot.calibration.joints))
    gait = read_gait(tmp_path / "robot.npz")
    assert gait.frame_rate == 50
    assert gait.joint_names == quadruped().organism.joint_names()
    assert len(gait.angles) == phases.count("driving")
    with np.load(tmp_path / "robot.npz") as file:
        assert len(file["measured"]) == status.frames == len(phases)
    if bus != "serial":  # hobby servos jump to the first pose, as their angles are unknown
        with np.load(tmp_path / "robot.npz") as file:
            steps = np.abs(np.diff(file["commanded"][:100], axis=0)).max()
            assert np.abs(file["commanded"][0] - rested).max() < np.radians(1)
            assert np.isfinite(file["temperature"]).all()
        assert np.degrees(steps) < 1.5 * 45 / 50 + 0.1


STOPS = {
    "tipped": (Fault("tipped"), "tipped over"),
    "hot": (Fault("hot", 4, 80.0), "has 80 °C"),
    "battery": (Fault("battery", -1, 4.0), r"dropped to [34].\d V"),
    "dead": (Fault("dead", 7), "the servo of L2 hip pitch has not answered"),
}


@pytest.mark.parametrize("bus", WITH_SERVOS)
@pytest.mark.parametrize("stop", STOPS)
def test_the_servos_are_off_soon_after_a_fault(driven, bus, stop):
    robot, injected = driven(bus), []
    fault, reason = STOPS[stop]

    def poll(status):
        if status.frames == 60:
            robot.wire.emulator.inject(fault)
            injected.append(robot.wire.now)

    with pytest.raises(Stopped, match=reason):
        robot.session.run(poll)
    taken = robot.wire.now - injected[0]
    robot.wire.sleep(0)
    assert not robot.body.on.any()
    assert taken < (0.24 if stop == "dead" else 0.04)


def test_any_exception_switches_the_servos_off(driven):
    robot = driven("feetech")

    def poll(status):
        if status.frames == 20:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        robot.session.run(poll)
    robot.wire.sleep(0)
    assert not robot.body.on.any()


def test_a_silent_wire_stops_the_robot(driven):
    robot, cut = driven("feetech"), []

    def poll(status):
        if status.frames == 40:
            robot.wire.emulator._noise = Noise(1.0)
            cut.append(robot.wire.now)

    with pytest.raises(Stopped, match=r"nothing has answered for 0.2 s"):
        robot.session.run(poll)
    assert robot.wire.now - cut[0] < 0.24


@pytest.mark.slow
@pytest.mark.parametrize("bus", BUSES)
def test_lost_and_wrong_frames_never_give_a_wrong_angle(driven, bus):
    robot = driven(bus, noise=Noise(0.0, 0.0, np.random.default_rng(4)))
    sent, wrong, write, exchange = [], [], robot.bus.write, robot.wire.emulator.exchange

    def remembered(degrees):
        sent.append(robot.calibration.joint_angles(degrees))
        write(degrees)

    def watched(received, now):
        replies = exchange(received, now)
        goal = robot.body.goal
        if sent and not any(np.abs(goal - one).max() < 0.002 for one in sent[-40:]):
            wrong.append(now)
        return replies

    def poll(status):
        if status.frames == 40:
            robot.wire.emulator._noise = Noise(0.02, 0.03, np.random.default_rng(4))
        if status.frames == 200:
            robot.wire.emulator._noise = Noise()
            robot.player.stop()

    robot.bus.write, robot.wire.emulator.exchange = remembered, watched
    robot.session.run(poll)
    assert len(sent) > 200
    assert not wrong


def test_limits_hold_whatever_the_gait_asks(driven):
    robot = driven("feetech")
    calibration = robot.calibration
    low, high = np.full(12, -90.0), np.full(12, 10.0)
    calibration.__dict__["low"], calibration.__dict__["high"] = low, high
    commanded = []
    write = robot.bus.write

    def remembered(degrees):
        commanded.append(degrees)
        write(degrees)

    def poll(status):
        if status.seconds > 3:
            robot.player.stop()

    robot.bus.write = remembered
    robot.session.run(poll)
    assert robot.session.status.clipped > 10
    assert np.max(commanded[120:]) <= 10
    speeds = np.abs(np.diff(commanded, axis=0)).max(axis=0) * 50
    assert (speeds <= calibration.max_speeds + 1e-6).all()


BAD = {
    "twin": ((Fault("twin", 3),), "id 4 .*garbled.*two servos"),
    "missing": ((Fault("dead", 0), Fault("dead", 5)), "2 of 12 servos do not answer: id 1 "),
    "all missing": (tuple(Fault("dead", joint) for joint in range(12)), "no servo answers"),
}


@pytest.mark.parametrize("bus", ["feetech", "dynamixel"])
@pytest.mark.parametrize("bad", BAD)
def test_what_is_wrong_with_servos_is_said_before_torque_is_on(connected, bus, bad):
    faults, message = BAD[bad]
    robot = connected(bus, *faults)
    with pytest.raises(GaitsimError, match=message):
        robot.bus.check()
    assert not robot.body.on.any()


def test_reversed_servos_are_found_by_their_mode_or_their_place(connected):
    with pytest.raises(GaitsimError, match=r"id 3 .*set to turn in reverse"):
        connected("dynamixel", Fault("reversed", 2)).bus.check()
    robot = connected("feetech", Fault("reversed", 2))
    robot.calibration.__dict__["low"] = np.where(np.arange(12) == 2, 1.0, -180.0)
    found = robot.wire.emulator._degrees[2]
    assert found < -4 or found > 1
    robot.calibration.__dict__["low"] = np.where(np.arange(12) == 2, found + 20, -180.0)
    with pytest.raises(GaitsimError, match=r"id 3 .*stands at .*beyond its limits"):
        robot.bus.check()


def test_joints_beyond_their_ends_in_the_model_are_refused_as_they_are_reversed(connected):
    robot = connected("feetech", hung=True)
    robot.wire.sleep(2.0)  # the legs dangle
    robot.bus.check()
    calibration = calibration_of(quadruped().organism, "feetech", None)
    joints = dict(calibration.joints)
    joints["R2 knee"] = joints["R2 knee"].model_copy(update={"direction": -1})
    reversed_one = Calibration(joints, "robot.toml", ends=calibration.ends)
    with pytest.raises(GaitsimError, match=r"id 12 \(R2 knee\) says .* from -138° to -11°"):
        connected("feetech", calibration=reversed_one).bus.check()


def test_servos_of_another_model_and_slow_rates_are_refused(connected):
    robot = connected("feetech")
    robot.wire.emulator._set(5, robot.wire.emulator.table.model, 999)
    with pytest.raises(GaitsimError, match=r"id 5 .*model 999, not sts3215"):
        robot.bus.check()
    robot = connected("dynamixel", baud=57_600)
    with pytest.raises(GaitsimError, match=r"reading 12 servos takes .* ms of each 20 ms"):
        robot.bus.check()


def test_a_missing_imu_is_said(connected):
    robot = connected("feetech")
    robot.wire.emulator._imu = False
    with pytest.raises(GaitsimError, match="no IMU answers at the id 200"):
        robot.bus.check()


def test_a_sketch_for_other_servos_is_refused(connected):
    from varied_servos import calibrate

    robot = connected("serial", calibration=calibrate(quadruped().organism.joint_names()))
    with pytest.raises(GaitsimError, match="for other servos"):
        robot.bus.check()


def test_reflexes_need_their_sensors():
    robot = quadruped().organism.model_copy(update={"reflexes": {"heading": {}}})
    genome = next(iter(robot.starts().values()))
    with pytest.raises(GaitsimError, match="'heading' needs orientation") as raised:
        pilot_of(robot, genome, imu=False)
    assert "--imu" in raised.value.remedy
    robot = robot.model_copy(update={"reflexes": {"contact": {}}})
    with pytest.raises(GaitsimError, match="'contact' needs contacts"):
        pilot_of(robot, genome, imu=True)


@pytest.mark.slow
@pytest.mark.parametrize("bus", ["feetech", "dynamixel"])
def test_servos_that_missed_their_first_goal_do_not_jump(driven, bus):
    robot = driven(bus)
    rested = robot.body.angles
    old = robot.calibration.ticks(robot.calibration.servo_angles(rested + 0.5))
    for number, tick in zip(robot.wire.emulator._joints, old.tolist(), strict=True):
        robot.wire.emulator._set(number, robot.wire.emulator.table.goal, tick)
    lost = iter([True] * 4 + [False] * 10_000)
    exchange = robot.wire.emulator.exchange
    robot.wire.emulator.exchange = lambda data, now: exchange(
        b"" if len(data) > 40 and next(lost) else data, now
    )
    turned = []

    def poll(status):
        turned.append(np.abs(robot.body.goal - rested).max())
        if status.frames == 5:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        robot.session.run(poll)
    assert max(turned) < np.radians(3)
