"""Tables of gaits: times, units and names are those that the file states."""

import numpy as np
import pytest

from gaitsim.errors import GaitsimError
from gaitsim.gait.gait_files import Gait, GaitFile, read_gait, write_gait

TIMES = np.array([0.0, 0.1, 0.2, 0.3, 0.4])
ANGLES = np.stack([np.sin(5 * TIMES), 0.3 * TIMES], axis=1)


def written(path, times, angles, head="time_s,a,b", delimiter=",", comma="."):
    rows = [
        delimiter.join(f"{value:.6f}".replace(".", comma) for value in (time, *row))
        for time, row in zip(times, angles, strict=True)
    ]
    path.write_text("\n".join([head, *rows]) + "\n", encoding="utf-8")
    return path


@pytest.mark.parametrize(
    ("head", "clock", "factors"),
    [
        ("time_s,a,b", 1, (1, 1)),
        ("time_ms,a [deg],b (rad)", 1000, (180 / np.pi, 1)),
        ("Time [s],a_deg,b [°]", 1, (180 / np.pi, 180 / np.pi)),
        ("t,a [rad],b [mm]", 1, (1, 1000)),
        ("seconds,a,b [m]", 1, (1, 1)),
    ],
)
def test_units_are_those_of_the_names(tmp_path, head, clock, factors):
    path = written(tmp_path / "a.csv", TIMES * clock, ANGLES * factors, head)
    found = read_gait(path)
    assert found.joint_names == ("a", "b")
    assert found.angles == pytest.approx(ANGLES, abs=1e-6)
    assert found.frame_rate == pytest.approx(10)
    assert not found.notices


@pytest.mark.parametrize(("delimiter", "comma"), [(";", ","), (";", "."), ("\t", ","), ("\t", ".")])
def test_tables_of_other_countries(tmp_path, delimiter, comma):
    head = delimiter.join(["time_s", "a", "b"])
    path = written(tmp_path / "a.csv", TIMES, ANGLES, head, delimiter, comma)
    assert read_gait(path).angles == pytest.approx(ANGLES, abs=1e-6)


def test_uneven_times_are_interpolated_at_their_instants(tmp_path):
    """Rows that are missing from an even gait give the same gait, as far as it is linear there."""
    times = np.arange(0, 2.001, 0.02)
    line = np.stack([times, -2 * times], axis=1)
    kept = np.sort(np.random.default_rng(0).permutation(len(times))[:60])
    kept = np.unique([0, 1, *kept, len(times) - 1])
    found = read_gait(written(tmp_path / "a.csv", times[kept], line[kept]))
    assert found.frame_rate == pytest.approx(50)
    assert found.angles == pytest.approx(line, abs=1e-5)
    assert "uneven" in found.notices[0]


def test_rounded_times_are_even(tmp_path):
    times = np.round(np.arange(40) / 30, 2)
    found = read_gait(written(tmp_path / "a.csv", times, np.zeros((40, 2))))
    assert found.frame_rate == pytest.approx(30, rel=0.01)
    assert not found.notices
    assert len(found.angles) == 40


@pytest.mark.parametrize(
    ("head", "times", "says"),
    [
        ("time_s,a,b", [0, 0.1, 0.1, 0.2, 0.3], "0.1 s in row 3 follows 0.1 s"),
        ("time_s,a,b", [0, 0.2, 0.1, 0.3, 0.4], "do not ascend"),
        ("time,a,b", [0, 20, 40, 60, 80], "look like milliseconds"),
        ("hour,a,b", [0, 1, 2, 3, 4], "its first column is not time_s but 'hour'"),
        ("time_s,a [ticks],b", [0, 1, 2, 3, 4], "has the unit 'ticks'"),
        ("time_s,a,b", [0, 1e-5, 1, 2, 3], "more than 10,000 frames"),
    ],
)
def test_what_is_not_a_gait_is_refused(tmp_path, head, times, says):
    with pytest.raises(GaitsimError, match=says):
        read_gait(written(tmp_path / "a.csv", times, ANGLES, head))


def test_a_wide_table_is_refused_before_it_is_interpolated(tmp_path):
    path = tmp_path / "a.csv"
    path.write_text(f"time_s{',a' * 2000}\n" + "".join(f"{t}{',0' * 2000}\n" for t in (0, 1, 9e9)))
    with pytest.raises(GaitsimError, match="at most 1,000 are allowed"):
        read_gait(path)


def test_degrees_are_not_played_as_radians(tmp_path):
    path = written(tmp_path / "a.csv", TIMES, np.degrees(ANGLES))
    with pytest.raises(GaitsimError, match="no joint reaches in radians") as told:
        read_gait(path)
    assert "--gait-unit deg" in told.value.remedy
    assert read_gait(path, "deg").angles == pytest.approx(ANGLES, abs=1e-6)
    assert read_gait(path, "rad").angles == pytest.approx(np.degrees(ANGLES), abs=1e-6)
    stated = written(tmp_path / "b.csv", TIMES, ANGLES * 20, "time_s,a [rad],b [rad]")
    assert read_gait(stated, "deg").angles == pytest.approx(ANGLES * 20, abs=1e-4)


@pytest.mark.parametrize("format", ["csv", "npz", "mat"])
def test_wheels_that_turn_on_and_on_are_read_back(tmp_path, format):
    gait = Gait(ANGLES * 50, ("a", "b"), 10.0, 1, 0.5)
    write_gait(gait, tmp_path / f"a.{format}", format)
    assert read_gait(tmp_path / f"a.{format}").angles == pytest.approx(gait.angles)


def test_a_cycle_is_repeated(tmp_path):
    path = tmp_path / "a.csv"
    cycle = np.array([[0.0], [1], [2], [1]])
    assert GaitFile(path, cycle, 4.0, ("a",)).repeated(2).angles[:, 0].tolist() == [
        *[0, 1, 2, 1],
        *[0, 1, 2, 1],
    ]
    closed = np.array([[0.0], [1], [2], [0]])
    twice = GaitFile(path, closed, 4.0, ("a",)).repeated(2).angles[:, 0].tolist()
    assert twice == [0, 1, 2, 0, 1, 2, 0]
    with pytest.raises(GaitsimError, match="too many to repeat"):
        GaitFile(path, closed, 4.0, ("a",)).repeated(10_000)


def test_further_columns_are_left_over(tmp_path):
    found = read_gait(written(tmp_path / "a.csv", TIMES, ANGLES, "time_s,head,b"))
    assert found.in_order(("b",))[:, 0] == pytest.approx(ANGLES[:, 1], abs=1e-6)
    assert found.left_over(("b",)) == ["head"]
    with pytest.raises(GaitsimError, match="does not have"):
        found.in_order(("b", "c"))
