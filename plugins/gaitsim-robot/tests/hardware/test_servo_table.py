"""Servo tables: keyframes, ranges and playback."""

import csv

import numpy as np
import pytest
from hypothesis import given, strategies as st

from gaitsim.errors import GaitsimError
from gaitsim.gait.gait_files import Gait
from gaitsim_hardware.calibration import uniform_calibration
from gaitsim_hardware.keyframes import keyframes_of, write_table

HALF_TURN = (0, -90, 90)


def gait(degrees, frame_rate=10.0):
    """A gait of two joints: 'a' has the given angles, (frames,) °, and 'b' twice as large ones."""
    angles = np.radians(np.array([[angle, 2 * angle] for angle in degrees], dtype=float))
    return Gait(angles, ("a", "b"), frame_rate, 1, 0.0)


def table_of(given, servos, keyframe_ms=None, **options):
    """Keyframes for servos with a centre, a minimum and a maximum, °."""
    calibration = uniform_calibration(given.joint_names, *servos)
    return keyframes_of(given, calibration, keyframe_ms, **options)


def read(path):
    with path.open(newline="", encoding="utf-8") as file:
        header, *rows = csv.reader(file)
    return header, rows


def test_the_table_has_each_frame_in_milliseconds_and_degrees(tmp_path):
    table = table_of(gait([0, 30, -12.344]), HALF_TURN)
    write_table(table, uniform_calibration(("a", "b"), *HALF_TURN), "servo", tmp_path / "x.csv")
    header, rows = read(tmp_path / "x.csv")
    assert header == ["time_ms", "a [deg]", "b [deg]"]
    assert rows == [["0", "0.00", "0.00"], ["100", "30.00", "60.00"], ["200", "-12.34", "-24.69"]]
    assert b"\r" not in (tmp_path / "x.csv").read_bytes()
    assert table.deviation <= 0.005 + 1e-9


def test_keyframes_lie_on_straight_lines_between_frames():
    table = table_of(gait([0, 10, 0, 10]), HALF_TURN, 50)
    assert table.milliseconds.tolist() == [0, 50, 100, 150, 200, 250, 300]
    assert table.degrees[:, 0].tolist() == [0, 5, 10, 5, 0, 5, 10]
    assert table.deviation == pytest.approx(0, abs=1e-9)


def test_the_deviation_of_fewer_keyframes_is_reported():
    table = table_of(gait([0, 10, 0, 10, 0]), HALF_TURN, 200)
    assert table.milliseconds.tolist() == [0, 200, 400]
    assert table.degrees[:, 0].tolist() == [0, 0, 0]
    assert table.deviation == pytest.approx(20)  # joint b


def test_angles_beyond_the_range_are_refused_with_joint_and_time():
    with pytest.raises(GaitsimError) as error:
        table_of(gait([0, 10, -45, 20]), (90, 30, 150))
    error.match(r"b would turn to 0.00° at 200 ms \(frame 2\)")
    error.match("30° to 150°")
    with pytest.raises(GaitsimError, match="so would 1 more joint"):
        table_of(gait([0, 10, -75, 20]), (90, 30, 150))


def test_angles_are_clipped_to_the_range_on_request():
    table = table_of(gait([0, 10, -45, 20]), (90, 30, 150), clip=True)
    assert table.clipped == 1
    assert table.degrees[2].tolist() == [45, 30]
    assert table.deviation == pytest.approx(30, abs=0.01)


@pytest.mark.parametrize(
    "bounds", [(0, 10, -10), (0, 5, 5), (200, 0, 180), (0, -np.inf, 90), (np.nan, -90, 90)]
)
def test_invalid_ranges_are_refused(bounds):
    with pytest.raises(GaitsimError, match="invalid servo range"):
        uniform_calibration(("a",), *bounds)


@given(
    st.lists(st.floats(-45, 45), min_size=2, max_size=30),
    st.sampled_from([10.0, 30.0, 60.0, 1000 / 7]),
    st.one_of(st.none(), st.integers(1, 30)),
)
def test_times_increase_and_angles_stay_in_range(degrees, rate, keyframe_ms):
    if keyframe_ms and keyframe_ms > 1000 / rate:
        keyframe_ms = None
    table = table_of(gait(degrees, rate), HALF_TURN, keyframe_ms)
    assert table.milliseconds[0] == 0
    assert (np.diff(table.milliseconds) > 0).all()
    assert table.milliseconds[-1] <= round(1000 * (len(degrees) - 1) / rate)
    assert np.abs(table.degrees).max() <= 90
    assert not np.signbit(table.degrees[table.degrees == 0]).any()


def test_too_few_or_too_close_keyframes_are_refused():
    with pytest.raises(GaitsimError, match="gives only one keyframe"):
        table_of(gait([0, 10]), HALF_TURN, 101)
    with pytest.raises(GaitsimError, match="at least 1 ms apart"):
        table_of(gait([0, 10, 20], frame_rate=5000.0), HALF_TURN)
