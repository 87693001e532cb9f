"""Calibration files: templates, reading, errors; goal positions of servo buses."""

import csv
import os

import numpy as np
import pytest

from gaitsim.errors import GaitsimError
from gaitsim.gait.gait_files import Gait
from gaitsim_hardware.calibration import default_calibration
from gaitsim_hardware.calibration_file import format_template, read_calibration, write_template
from gaitsim_hardware.keyframes import keyframes_of, write_table

NAMES = ("L1 coxa", 'a "quoted" \\ joint', "knie µ")
REST = np.array([0.0, 0.5, -1.0])


def gait(*rows, rate=10.0):
    return Gait(np.radians(np.array(rows, float)), NAMES, rate, 1, 0.0, REST)


STEPS = gait([0, 10, -50], [10, -20, -60], [20, 30, -40])


@pytest.fixture
def file(tmp_path):
    """Write a template for a format, with replacements; return its path."""

    def write(format="arduino", **changes):
        text = format_template(STEPS, default_calibration(format, NAMES, REST), format)
        for old, new in changes.items():
            line = old.replace("_", " ")
            assert line in text
            text = text.replace(line, new, 1)
        path = tmp_path / "robot.toml"
        path.write_text(text, encoding="utf-8")
        return path

    return write


@pytest.mark.parametrize("format", ["arduino", "dynamixel", "feetech"])
def test_a_template_reads_back_as_the_default(file, format):
    made, read = (
        default_calibration(format, NAMES, REST),
        read_calibration(file(format), format, NAMES),
    )
    assert read.joints == made.joints
    # In the standing pose, the servos are at their centre.
    assert made.servo_angles(REST) == pytest.approx(np.zeros(3), abs=0.0051)


def test_a_template_never_replaces_a_file(tmp_path):
    path = tmp_path / "robot.toml"
    path.write_text("measured")
    with pytest.raises(GaitsimError, match="already exists"):
        write_template(STEPS, default_calibration("arduino", NAMES, REST), "arduino", path)
    assert path.read_text() == "measured"


@pytest.mark.parametrize(
    ("servo", "format", "ends", "degree"),
    [
        ("ax-12a", "dynamixel", (0, 1023), 3.41),
        ("xl430-w250", "dynamixel", (0, 4095), 11.378),
        ("sts3215", "feetech", (0, 4095), 11.378),
    ],
)
def test_goal_positions_match_the_data_sheets(tmp_path, servo, format, ends, degree):
    made = default_calibration(format, NAMES, 0 * REST, servo)
    low, high = next(iter(made.joints.values())).min, next(iter(made.joints.values())).max
    rows = gait([low, 0, 10], [high, 0, 20], [0, 1, 30], rate=0.1)
    write_table(keyframes_of(rows, made), made, format, tmp_path / "x.csv")
    with (tmp_path / "x.csv").open(newline="") as text:
        header, *found = csv.reader(text)
    assert header == ["time_ms", "1", "2", "3"]
    values = np.array(found, dtype=int)
    assert values[:, 0].tolist() == [0, 10_000, 20_000]
    assert tuple(values[:2, 1]) == ends
    middle = values[2, 1]
    assert middle in {(ends[1] + 1) // 2, ends[1] // 2}
    assert values[:, 3] - middle == pytest.approx(np.array([10, 20, 30]) * degree, abs=1)


def test_a_gait_beyond_a_limit_is_refused_with_joint_frame_and_value(file):
    limited = read_calibration(file(**{"max_=_90.0": "max = 15"}), "arduino", NAMES)
    with pytest.raises(GaitsimError) as error:
        keyframes_of(STEPS, limited)
    error.match(r"L1 coxa would turn to 20.00° at 200 ms \(frame 2\)")
    error.match("robot.toml")
    error.match("-90° to 15°")
    assert keyframes_of(STEPS, limited, clip=True).degrees[2, 0] == 15


def test_a_gait_too_fast_for_a_servo_is_refused_with_a_speed_that_it_reaches(file):
    named = read_calibration(file(**{'servo_=_""': 'servo = "mg995"'}), "arduino", NAMES)
    quick = gait([0, 10, -50], [0, 10, -50], [50, 10, -50])  # 500°/s; an MG995 reaches 353
    with pytest.raises(GaitsimError) as error:
        keyframes_of(quick, named)
    error.match(r"L1 coxa would turn at 500°/s at 100 ms \(frame 1\), faster than the servo mg995")
    error.match("up to 353°/s")
    speed = float(error.value.remedy.split("--speed ")[1].split()[0])
    assert speed == 0.7
    assert keyframes_of(quick, named, speed=speed).peak_speeds[0] < 353
    with pytest.raises(GaitsimError):
        keyframes_of(quick, named, speed=speed + 0.01)
    own = read_calibration(file(**{'servo_=_""': "speed = 499.0"}), "arduino", NAMES)
    with pytest.raises(GaitsimError, match="faster than the calibration allows"):
        keyframes_of(quick, own)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"channel_=_1": "channel = 0"}, "have the same channel 0 of board 0"),
        ({"channel_=_1": "channel = 99"}, ".channel: 99 ("),
        ({"channel_=_1": ""}, "is required for arduino"),
        ({"direction_=_1": "direction = 0"}, ".direction: 0 ("),
        ({"offset_=_0.0": "offset = nan"}, "nan"),
        ({"min_=_-90.0": "min = 91"}, "'min', 91, is not less than 'max', 90"),
        ({'servo_=_""': 'servo = "mg96"'}, "unknown servo"),
        ({'servo_=_""': 'servo = "ax-12a"'}, "the servo ax-12a cannot be used with arduino"),
        ({'servo_=_""': 'servo = "mg995"\nmin_ = 1'}, "unknown key"),
        ({"max_=_90.0": 'max = 120\nservo = "mg995"', 'servo_=_""': ""}, "of the servo 'mg995'"),
        ({"pulse_=_[600,_2400]": "pulse = [2400, 600]"}, "the shorter first"),
        ({'[joints."L1_coxa"]': '[joints."L1 koxa"]'}, "the gait does not have the joint"),
        ({'[joints."L1_coxa"]': '[joints."L1 koxa"]'}, "is missing"),
        ({"schema_=_1": "schema = 2"}, "invalid schema: 2"),
        ({"schema_=_1": "joints = 3", '[joints."L1_coxa"]': "[other]"}, "not valid TOML"),
        ({"schema_=_1": "]"}, "line 17"),
    ],
)  # fmt: skip
def test_an_invalid_calibration_is_refused(file, changes, message):
    with pytest.raises(GaitsimError) as error:
        read_calibration(file(**changes), "arduino", NAMES)
    assert message in str(error.value)
    assert "robot.toml" in str(error.value)


def test_files_that_are_not_text_files_are_refused(tmp_path):
    os.mkfifo(tmp_path / "pipe")
    with (tmp_path / "long").open("wb") as long:
        long.truncate(2**30)
    (tmp_path / "bytes").write_bytes(b"\xff\xfe\x00")
    for name, message in (
        ("pipe", "not a regular file"),
        ("long", "too large"),
        ("bytes", "not a text file"),
        ("missing", "file not found"),
        (".", "Is a directory"),
    ):
        with pytest.raises(GaitsimError, match=message):
            read_calibration(tmp_path / name, "arduino", NAMES)
