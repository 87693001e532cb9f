"""Calibrating virtual robots by hand: a person who sees their joints recovers planted values."""

import errno
import termios
import time
from threading import Thread

import numpy as np
import pytest
from waiting import app_until
from wires import Wire, quadruped, robot_on

from gaitsim.errors import ExperimentError, GaitsimError
from gaitsim.tui.app import GaitsimApp
from gaitsim_hardware.calibration_file import read_calibration, write_joint
from gaitsim_wire.calibrating import Calibrator
from gaitsim_wire.calibration_screen import CalibrationScreen
from gaitsim_wire.emulator import Fault
from gaitsim_wire.robots import FORMATS, calibration_of

ROBOT = quadruped().organism
NAMES = ROBOT.joint_names()


@pytest.fixture
def planted(tmp_path):
    """Return a function that writes a calibration with other ids, directions and offsets."""

    def plant(bus):
        found, path = calibration_of(ROBOT, bus, None), tmp_path / "planted.toml"
        stands = found.joint_angles(np.zeros(12))
        for number, (name, joint) in enumerate(found.joints.items()):
            direction = -1 if number % 3 == 1 else 1
            offset = 7 * number % 23 - 11 - direction * np.degrees(stands[number])
            swapped = {1: 2, 2: 1}.get(number, number)
            changes = {"id": 20 + swapped, "direction": direction, "offset": round(offset, 2)}
            write_joint(path, name, joint.model_copy(update=changes))
        return path

    return plant


class Person:
    """A person at the keys, who sees the joints of a virtual robot, and its picture."""

    pace = 0.0

    def __init__(self, bus, file, path, *faults, **options):
        self.wire = Wire(robot_on(bus, *faults, calibration=file, hung=True))
        self.body = self.wire.emulator.body
        clock = {"clock": self.wire.time, "sleep": self.sleep}
        self.calibrator = Calibrator(ROBOT, bus, self.wire, 1_000_000, path, **clock, **options)

    def sleep(self, seconds):
        self.wire.sleep(seconds)
        time.sleep(self.pace * seconds)

    def seen(self, joint):
        return np.degrees(self.body.angles[joint])

    def until(self, holds):
        """Wait, in frames of the wire, until a condition holds."""
        for _ in range(1000):
            if holds():
                return
            yield
        raise AssertionError("in vain")

    def press(self, *turns):
        for turn in turns:
            self.calibrator.jog(turn)
            for _ in range(15):
                yield

    def turn(self, joint, angle):
        """Turn a joint with keys until it looks as wanted."""
        for _ in range(100):
            away = angle - self.seen(joint)
            if abs(away) < 0.5:
                return
            yield from self.press(np.copysign(5.0 if abs(away) > 6 else 0.5, away))
        raise AssertionError("in vain")

    def calibrate(self, joint):
        """Answer the questions about a joint."""
        found = self.calibrator
        assert found.name == NAMES[joint]
        while True:
            yield from self.until(lambda: np.isfinite(found.angle))
            yield from self.press(0.5)  # it may still swing
            if self.body.on[joint]:
                break
            found.other()
        yield from self.press(5.0, 5.0)
        above = self.seen(joint)
        yield from self.press(-5.0, -5.0, -5.0)
        if self.seen(joint) > above:
            found.flip()
        found.accept()
        yield from self.turn(joint, np.degrees(ROBOT.standing_pose()[joint]))
        found.accept()
        found.keep()
        assert NAMES[joint] in found.done, found.problem
        yield

    def checked(self):
        """Let the robot sway, and see that each joint turns up first."""
        found, start = self.calibrator, self.body.seconds
        assert found.step == "done"
        found.check()
        yield from self.until(lambda: not found.checking)
        assert not found.problem
        assert found.checked == pytest.approx(12.02, abs=0.1)
        assert self.body.seconds - start > 16

    def act(self, *deeds):
        """Serve the robot while the person acts."""
        script = (None for deed in deeds for _ in deed)

        def poll():
            assert np.count_nonzero(self.body.on) <= 1 or self.calibrator.checking
            if next(script, self) is self:
                self.calibrator.closed = True

        self.calibrator.closed = False
        self.calibrator.run(poll)
        self.wire.sleep(0)
        assert not self.body.on.any()


SLOW = pytest.param("dynamixel", 12, marks=pytest.mark.slow)


@pytest.mark.parametrize(("bus", "count"), [("feetech", 3), SLOW])
def test_planted_values_are_recovered_joint_by_joint(planted, tmp_path, bus, count):
    file, path = planted(bus), tmp_path / "robot.toml"
    right = read_calibration(file, FORMATS[bus], NAMES)
    for name in NAMES[count:]:
        write_joint(path, name, right.joints[name])
    person = Person(bus, file, path)
    person.act(person.calibrate(0), person.calibrate(1))
    with pytest.raises(ExperimentError, match="is missing" if count == 3 else "are missing"):
        read_calibration(path, FORMATS[bus], NAMES)
    again = Person(bus, file, path)
    assert again.calibrator.name == NAMES[2]
    again.act(*(again.calibrate(joint) for joint in range(2, count)), again.checked())
    found = read_calibration(path, FORMATS[bus], NAMES)
    for name in NAMES:
        one, other = found.joints[name], right.joints[name]
        assert (one.id, one.direction, one.servo) == (other.id, other.direction, other.servo)
        assert one.offset == pytest.approx(other.offset, abs=1.0)
        assert -180 <= one.min < one.max < 180


def test_space_a_hot_servo_and_a_dead_one_switch_off_at_once(planted, tmp_path):
    person = Person("feetech", planted("feetech"), tmp_path / "robot.toml")
    found, emulator = person.calibrator, person.wire.emulator

    def stopped(what, message):
        yield from person.until(lambda: np.isfinite(found.angle))
        yield from person.press(5.0)
        assert person.body.on.sum() == 1
        before = person.wire.now
        what()
        yield
        yield from person.until(lambda: not found.on)
        yield
        assert not person.body.on.any()
        assert person.wire.now - before < 0.3
        assert message in found.problem
        yield

    person.act(
        stopped(found.off, ""),
        stopped(lambda: found.turn_to(1), ""),  # the servo of the third joint has the next id
        stopped(lambda: emulator.inject(Fault("hot", 2, 80.0)), "has 80 °C. The servos are off."),
        (found.turn_to(1) for _ in range(1)),
        stopped(lambda: emulator.inject(Fault("dead", 1)), "Nothing has answered for 0.2 s"),
    )
    assert not (tmp_path / "robot.toml").exists()


def test_an_unplugged_port_is_reported(planted, tmp_path, monkeypatch):
    person = Person("feetech", planted("feetech"), tmp_path / "robot.toml")
    found = person.calibrator

    def unplugged():
        raise termios.error(errno.EIO, "Input/output error")

    def pull():
        yield from person.until(lambda: np.isfinite(found.angle))
        yield from person.press(5.0)
        monkeypatch.setattr(person.wire, "reset_input_buffer", unplugged)
        yield from person.until(lambda: not found.on)
        assert "port was lost" in found.problem
        found.jog(5.0)
        yield
        assert not found.on

    person.act(pull())


def test_wrong_ends_are_refused_and_questions_are_asked_again(planted, tmp_path):
    person = Person("feetech", planted("feetech"), tmp_path / "robot.toml")
    found = person.calibrator

    def answer():
        yield from person.until(lambda: np.isfinite(found.angle))
        found.accept()
        found.accept()
        yield from person.press(5.0, 5.0)
        found.accept()
        yield from person.press(5.0)
        found.accept()
        assert (found.step, found.problem) == ("low", found.problem)
        assert "is not between" in found.problem
        found.back()
        assert (found.step, found.problem) == ("stand", "")

    person.act(answer())
    assert not found.done


def test_a_robot_with_a_servo_missing_is_refused(planted, tmp_path):
    with pytest.raises(GaitsimError, match=r"1 of 12 servos does not answer: id 1 \(R2 knee\)"):
        Person("feetech", planted("feetech"), tmp_path / "robot.toml", Fault("dead", 4))
    with pytest.raises(GaitsimError, match="unknown joint 'L9 knee'"):
        Person("feetech", planted("feetech"), tmp_path / "robot.toml").calibrator.choose("L9 knee")


@pytest.mark.slow
async def test_keys_turn_and_calibrate_a_joint_beside_its_picture(planted, tmp_path):
    person = Person("feetech", planted("feetech"), tmp_path / "robot.toml")
    person.pace = 0.2  # or the screen would have to wait
    found, serving = person.calibrator, Thread(target=person.calibrator.run)
    app = GaitsimApp(first=lambda: CalibrationScreen(found, "gaitsim robots calibrate", "next"))
    async with app.run_test(size=(80, 24)) as pilot:
        serving.start()
        screen = app.screen

        async def shows(holds):
            await app_until(pilot, lambda: screen._show() or holds())

        def text(name):
            return str(screen.query_one(f"#calibration-{name}").render())

        try:
            await shows(lambda: np.isfinite(found.angle))
            standing = -round(found._ends[NAMES[0]][0])
            await pilot.press("up", "up")
            await shows(lambda: "torque      on" in text("facts"))
            await shows(lambda: screen.picture.frame > standing + 1)
            assert any("hip" in name for name in screen.picture.skeleton.damaged)
            await pilot.press("d")
            await shows(lambda: screen.picture.frame < standing - 1)
            await pilot.press("space")
            await shows(lambda: "torque      off" in text("facts"))
            assert not person.body.on.any()
            await pilot.press("n")
            await shows(lambda: np.isfinite(found.angle))
            await pilot.press("enter", "enter", "k")
            await shows(lambda: "1 of 12 calibrated" in text("facts"))
            assert "Does the marked joint turn" in text("task")
            assert screen.obstacle("check") == "11 joints are not calibrated yet."
        finally:
            found.closed = True
            serving.join()
    assert read_calibration(found.path, "feetech", NAMES, partial=True).joints.keys() == {NAMES[0]}
