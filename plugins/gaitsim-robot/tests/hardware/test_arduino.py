"""Arduino sketches, compiled with stubs of the Arduino headers and run."""

import shutil
import subprocess
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from varied_servos import calibrate

from gaitsim.errors import GaitsimError
from gaitsim.gait.gait_files import Gait
from gaitsim_hardware.arduino import create_sketch, sketch_name, write_sketch
from gaitsim_hardware.keyframes import find_loop, keyframes_of

STUBS = Path(__file__).parent / "stubs"
COMPILER = shutil.which("g++") or shutil.which("clang++")
STEP = 0.02  # s between commands
TICK = 1e6 / 50 / 4096  # µs
JOINTS = 18  # two boards


def walking(seconds=6.0, rate=50.0, period=0.73):
    """A gait that starts from the standing pose within half a second, then repeats."""
    times = np.arange(round(seconds * rate) + 1) / rate
    delays, sizes = np.linspace(0, 2, JOINTS), np.linspace(0.1, 0.5, JOINTS)
    rest = np.linspace(-0.3, 0.3, JOINTS)
    waves = sizes * np.sin(2 * np.pi * (times[:, None] / period) + delays)
    names = tuple(f"joint {index}" for index in range(JOINTS))
    return Gait(rest + np.clip(times / 0.5, 0, 1)[:, None] * waves, names, rate, 1, 0.0, rest)


def calibrated(gait, speed=400.0):
    """A calibration of the joints of a gait."""
    return calibrate(gait.joint_names, speed=speed)


@pytest.fixture
def play(tmp_path):
    """Play a sketch; return the time of each step, s, and the pulses of all joints then, µs."""
    if COMPILER is None:
        pytest.skip("no C++ compiler")

    def played(keyframes, calibration, seconds, *commands):
        write_sketch(create_sketch(keyframes, calibration, "walk", "a gait"), tmp_path / "walk")
        flags = ["-std=c++17", "-Wall", "-Wextra", "-Werror", f"-I{STUBS}"]
        sketch = f'-DSKETCH="{tmp_path / "walk" / "walk.ino"}"'
        program = tmp_path / "play"
        source = [str(STUBS / "play.cpp"), "-o", str(program)]
        subprocess.run([COMPILER, *flags, sketch, "-x", "c++", *source], check=True)
        words = [str(program), str(seconds), *map(str, commands)]
        output = subprocess.run(words, check=True, capture_output=True, text=True).stdout
        places = [(0x40 + joint.board, joint.channel) for joint in calibration.joints.values()]
        now, rows, times = [np.nan] * len(places), [], []
        for line in output.splitlines():
            time, *place, ticks = map(int, line.split())
            if not times or time != times[-1]:
                rows.append(list(now))
                times.append(time)
            now[places.index(tuple(place))] = np.nan if ticks == 4096 else ticks
            rows[-1] = list(now)
        return np.array(times) / 1000, np.array(rows) * TICK

    return played


def gait_pulses(gait, calibration, times):
    """Return the pulses of a gait at the given times, from the equations in the docs, µs."""
    frames = np.arange(len(gait.angles)) / gait.frame_rate
    found = []
    for index, joint in enumerate(calibration.joints.values()):
        degrees = np.degrees(np.interp(times, frames, gait.angles[:, index]))
        turned = joint.direction * degrees + joint.offset
        found.append(joint.pulse[0] + (turned + 90) / 180 * (joint.pulse[1] - joint.pulse[0]))
    return np.stack(found, axis=1)


def test_the_sketch_stands_ramps_up_loops_and_stops_softly(play):
    gait = walking()
    calibration, loop = calibrated(gait), find_loop(gait.angles, gait.frame_rate)
    keyframes = keyframes_of(gait, calibration, 10, loop=loop)
    times, pulses = play(keyframes, calibration, 20, 1, "g", 14, "s")
    assert np.isnan(pulses[times < 1]).all()
    # The servos move to the standing pose one by one.
    standing = gait_pulses(gait, calibration, [0.0])[0]
    rising = pulses[(times >= 1) & np.isnan(pulses).any(axis=1)]
    assert (np.diff(np.isfinite(rising).sum(axis=1)) == 1).all()
    risen = int(np.flatnonzero(np.isfinite(pulses).all(axis=1))[0])
    assert pulses[risen] == pytest.approx(standing, abs=TICK)
    # As the gait starts in the standing pose, the ramp before it does not move.
    started = int(np.flatnonzero((np.abs(pulses[risen:] - standing) > 3 * TICK).any(axis=1))[0])
    started += risen
    assert times[started] - times[risen] >= 1.5
    # 10 s of playback equal the gait as it would continue after its 6 s.
    long = walking(13.0)
    start = times[started] - next(
        time
        for time in np.arange(0, 1, STEP)
        if (np.abs(gait_pulses(long, calibration, [time]) - standing) > 3 * TICK).any()
    )
    walked = (times >= start) & (times < 14)
    expected = gait_pulses(long, calibration, times[walked] - start)
    assert walked.sum() > 400
    # Errors: a tick of the board, a microsecond of the table, and the linear interpolation.
    assert np.abs(pulses[walked] - expected).max() <= TICK + 1.5
    # No step is faster than the servos, and the robot stands at the end.
    steps = np.abs(np.diff(pulses[risen:], axis=0)) / np.diff(times[risen:])[:, None]
    scale = np.array([np.diff(joint.pulse)[0] / 180 for joint in calibration.joints.values()])
    assert ((steps - TICK / STEP) / scale).max() <= 400
    assert pulses[-1] == pytest.approx(standing, abs=TICK)
    assert times[-1] < 18


def test_a_gait_that_does_not_repeat_is_played_once_with_the_pulses_of_each_frame(play):
    gait = walking(3.0)
    noise = np.cumsum(np.random.default_rng(1).normal(0, 0.01, gait.angles.shape), axis=0)
    gait = Gait(gait.angles + noise, gait.joint_names, gait.frame_rate, 1, 0.0, gait.standing)
    assert find_loop(gait.angles, gait.frame_rate) is None
    calibration = calibrated(gait, speed=900.0)
    keyframes = keyframes_of(gait, calibration)
    # Started with the button, which is not pressed a second time.
    _, pulses = play(keyframes, calibration, 12, 0.5, "b")
    expected = gait_pulses(gait, calibration, np.arange(len(gait.angles)) / gait.frame_rate)
    first = next(
        row
        for row in range(len(pulses) - len(expected))
        if np.abs(pulses[row] - expected[0]).max() <= TICK
        and np.abs(pulses[row + 1] - expected[1]).max() <= TICK
    )
    assert np.abs(pulses[first : first + len(expected)] - expected).max() <= TICK
    standing = gait_pulses(walking(), calibration, [0.0])[0]
    assert pulses[-1] == pytest.approx(standing, abs=TICK)


def test_a_standing_pose_beyond_the_limits_is_refused():
    gait = walking()
    gait = replace(gait, rest=gait.standing + 2)
    calibration = calibrated(gait)
    with pytest.raises(GaitsimError, match="in the standing pose"):
        create_sketch(keyframes_of(gait, calibration), calibration, "walk", "a gait")
    clipped = keyframes_of(gait, calibration, clip=True)
    assert create_sketch(clipped, calibration, "walk", "a gait").flash


def test_servos_are_switched_off_at_once(play):
    gait = walking()
    calibration = calibrated(gait)
    keyframes = keyframes_of(gait, calibration, loop=find_loop(gait.angles, gait.frame_rate))
    times, pulses = play(keyframes, calibration, 8, 0.2, "g", 5, "x")
    assert np.isfinite(pulses[times < 5][-1]).all()
    assert np.isnan(pulses[times >= 5]).all()


def test_a_gait_too_large_for_the_flash_is_refused_with_an_interval_that_fits(tmp_path):
    gait = walking(30.0)
    calibration = calibrated(gait)
    with pytest.raises(GaitsimError, match=r"54,036 bytes") as error:
        create_sketch(keyframes_of(gait, calibration), calibration, "walk", "a gait")
    interval = int(error.value.remedy.rpartition(" ")[2])
    sketch = create_sketch(keyframes_of(gait, calibration, interval), calibration, "walk", "a gait")
    assert 30_000 < sketch.flash <= 32_767
    with pytest.raises(GaitsimError, match="invalid name for an Arduino sketch: 'my gait'"):
        sketch_name(tmp_path / "my gait")


@pytest.mark.parametrize("period", [0.4, 0.4321, 1.0, 1.7])
def test_the_period_is_found_between_frames(period):
    gait = walking(5.0, 30.0, period)
    loop = find_loop(gait.angles, gait.frame_rate)
    assert loop.period == pytest.approx(period, abs=2e-4)
    assert loop.start <= 0.5
    assert np.degrees(loop.error) < 1


def test_a_still_gait_and_a_steady_rotation_have_no_period():
    times = np.linspace(0, 5, 151)[:, None]
    assert find_loop(np.zeros((151, 3)), 30.0) is None
    assert find_loop(np.hstack([times, -times]) * 0.1, 30.0) is None
