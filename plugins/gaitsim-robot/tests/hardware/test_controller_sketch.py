"""Arduino sketches of gaits with reflexes, compiled with stubs of the headers and run."""

import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest
from c_gait import COMPILER, pilot_of, robot
from varied_servos import calibrate

import gaitsim as gs
from gaitsim.errors import GaitsimError
from gaitsim.experiment import with_overrides
from gaitsim.individual import Individual
from gaitsim_hardware.arduino import create_controller_sketch, write_sketch
from gaitsim_robot.feeling import Truth

STUBS = Path(__file__).parent / "stubs"
CXX = shutil.which("g++") or shutil.which("clang++")
TICK = 1e6 / 50 / 4096  # µs


@pytest.fixture(scope="module")
def hexapod():
    """Return a hexapod that keeps its heading, and its genome."""
    return robot("hexapod", ("heading",))


def play(folder, organism, genome, seconds, *commands):
    """Return the times of control steps, (steps,) s, and the joint angles then, (steps, joints).

    Angles of servos that are off are NaN.
    """
    if CXX is None or COMPILER is None:
        pytest.skip("no C++ compiler")
    controller = organism.controller(genome)
    calibration = calibrate(controller.rhythm.joint_names)
    walk = folder / "walk"
    write_sketch(create_controller_sketch(controller, calibration, "walk", "a gait"), walk)
    flags = ["-Wall", "-Wextra", "-Werror", "-DARDUINO=10819", f"-I{STUBS}"]
    gait, program = str(folder / "gait.o"), str(folder / "play")
    c = [COMPILER, "-std=c99", *flags, "-c", str(walk / "gait.c"), "-o", gait]
    subprocess.run(c, check=True)
    sketch = [f'-DSKETCH="{walk / "walk.ino"}"', f"-I{walk}", "-x", "c++", str(STUBS / "play.cpp")]
    cxx = [CXX, "-std=c++17", *flags, *sketch, "-x", "none", gait, "-o", program]
    subprocess.run(cxx, check=True)
    told = [one if str(one).startswith("!") else f"{one}\n" for one in commands[1::2]]
    pairs = zip(map(str, commands[::2]), told, strict=True)
    words = [program, str(seconds), *(word for pair in pairs for word in pair)]
    output = subprocess.run(words, check=True, capture_output=True, text=True).stdout
    places = [(0x40 + joint.board, joint.channel) for joint in calibration.joints.values()]
    now, rows, times = np.full(len(places), np.nan), [], []
    for line in output.splitlines():
        time, *place, ticks = map(int, line.split())
        if not times or time != times[-1]:
            rows.append(now)
            times.append(time)
        now = now.copy()
        now[places.index(tuple(place))] = np.nan if ticks == 4096 else ticks
        rows[-1] = now
    low, high = np.array([joint.pulse for joint in calibration.joints.values()]).T
    offset, direction = calibration._values("offset"), calibration._values("direction")
    degrees = (np.array(rows) * TICK - low) / (high - low) * 180 - 90
    return np.array(times) / 1000, np.radians((degrees - offset) / direction)


def walked(organism, genome, yaw, *commands):
    """Return the angles in Python, (frames, joints) rad, with a measured yaw in each frame."""
    pilot = pilot_of(organism, genome)
    joints, legs = len(pilot.rhythm.joint_names), len(pilot.rhythm.names)
    angles = []
    for frame, one in enumerate(yaw):
        target = next((np.array(told) for start, told in reversed(commands) if frame >= start))
        truth = Truth(
            np.array([[0.0, 0.0, one]]), np.zeros((1, 3)), np.zeros((1, legs)),
            np.zeros((1, joints)),
        )  # fmt: skip
        angles.append(pilot.step(frame, target[None], truth)[0].copy())
    return np.array(angles)


RESOLUTION = np.radians(0.35)  # ticks of the board


@pytest.mark.slow
def test_the_sketch_stands_up_calibrates_and_obeys(tmp_path, hexapod):
    times, angles = play(tmp_path, *hexapod, 15, 0.5, "g", 5, "s 0.2", 8, "t 20", 12, "0")
    assert np.isnan(angles[times < 0.5]).all()
    # The servos move to the standing pose one by one.
    rising = angles[(times >= 0.5) & np.isnan(angles).any(axis=1)]
    assert (np.diff(np.isfinite(rising).sum(axis=1)) == 1).all()
    walks = times > 4.99
    moments, seen = times[walks], angles[walks]
    assert np.diff(moments) == pytest.approx(0.02)
    first = int(np.searchsorted(moments, 5.0))
    expected = walked(
        *hexapod, np.zeros(len(seen) - first), (0, [0.2, 0, 0, 0]),
        (150, [0.2, np.radians(20), 0, 0]), (350, [0, 0, 0, 0]),
    )  # fmt: skip
    # The measured yaw remains 0, so the reflex turns more and more in both.
    assert np.abs(seen[first:] - expected).max() < RESOLUTION
    assert np.abs(seen[-1] - hexapod[0].standing_pose()).max() < RESOLUTION
    assert np.ptp(expected, axis=0).max() > 0.2


@pytest.mark.slow
def test_the_gyroscope_is_integrated_without_its_bias(tmp_path, hexapod):
    _, straight = play(tmp_path, *hexapod, 10, 0.5, "g", 5, "s 0.2")
    times, turned = play(tmp_path, *hexapod, 10, 0.5, "g", 5, "s 0.2", 6, "!turn 0.1", 9, "!turn 0")
    moments = times[times >= 4.999]
    yaw = np.clip(moments - 6, 0, 3) * 0.1
    expected = walked(*hexapod, yaw, (0, [0.2, 0, 0, 0]))
    assert np.abs(turned[times >= 4.999] - expected).max() < 2 * RESOLUTION
    assert np.nanmax(np.abs(turned - straight[: len(turned)])) > 5 * RESOLUTION


@pytest.mark.slow
@pytest.mark.sampled
@pytest.mark.parametrize("event", ["!fail", "silence", "!roll", "x"])
def test_the_robot_stops(tmp_path, hexapod, event):
    told = () if event == "silence" else (7, event)
    times, angles = play(tmp_path, *hexapod, 18, 0.5, "g", 5, "w", *told)
    assert np.ptp(angles[(times > 6) & (times < 7)], axis=0).max() > 0.2
    if event in ("!roll", "x"):  # servos off, and not switched on again
        assert np.isnan(angles[-1]).all()
        assert times[-1] < 8
    else:
        until = 8.5 if event == "!fail" else 16.5
        assert np.ptp(angles[times > until], axis=0).max() == 0
        assert np.abs(angles[-1] - hexapod[0].standing_pose()).max() < RESOLUTION
        if event == "silence":  # the robot walks until the time is out
            assert np.ptp(angles[(times > 13) & (times < 15)], axis=0).max() > 0.2


@pytest.mark.slow
def test_a_gait_without_reflexes_needs_no_sensor(tmp_path):
    told = (0, "!fail", 0.5, "g", 5, "s 0.2", 8, "0")
    organism, genome = robot("hexapod", ())
    times, angles = play(tmp_path, organism, genome, 12, *told)
    expected = walked(organism, genome, np.zeros(150), (0, [0.2, 0, 0, 0]))
    first = int(np.searchsorted(times, 4.999))
    assert np.abs(angles[first : first + 150] - expected).max() < RESOLUTION
    assert np.ptp(angles[times > 11], axis=0).max() == 0


@pytest.fixture
def individual():
    """Return a function that makes an individual of the hexapod with options."""

    def made(**options):
        told = {"organism.duration": 3.0, **options}
        experiment = with_overrides(gs.load_experiment("hexapod"), told)
        return Individual(experiment, 0.0, {}, 1, next(iter(experiment.organism.starts().values())))

    return made


def test_gaits_with_reflexes_are_exported_as_controllers(tmp_path, individual):
    felt = individual(**{
        "organism.reflexes": {"contact": {}}, "organism.sensors": ["mpu6050", "contacts"],
    })  # fmt: skip
    done = gs.export(felt, tmp_path / "walk", "arduino", clip=True)
    names = {"gait.c", "gait.h", "servos.h", "walk.ino"}
    assert {path.name for path in (tmp_path / "walk").iterdir()} == names
    assert "follows commands" in done.summary
    assert any("CONTACT_PINS" in notice for notice in done.notices)
    with pytest.raises(GaitsimError, match="has no speed"):
        gs.export(felt, tmp_path / "walk", "arduino", clip=True, speed=0.5)
    # A gait without reflexes replaces all files, as Arduino would compile others.
    gs.export(individual(), tmp_path / "walk", "arduino", clip=True)
    assert {path.name for path in (tmp_path / "walk").iterdir()} == {"gait.h", "walk.ino"}
