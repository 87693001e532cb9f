"""Declarations of channels, and arrays that match their axes."""

import numpy as np
import pytest

from gaitsim.contracts import Channel, Motion

POSE = Channel(("frames", ("x", "y", "yaw")), ("m", "m", "rad"), "of the body")


def test_a_channel_describes_itself():
    assert str(POSE) == "(population, frames, [x, y, yaw]) [m, m, rad]: of the body"
    assert str(Channel((), "", "share of time")) == "(population,): share of time"
    assert [POSE.unit_of(entry) for entry in range(3)] == ["m", "m", "rad"]
    assert Channel(("frames", "feet"), "N", "").unit_of(7) == "N"


@pytest.mark.parametrize(
    ("shape", "fits"),
    [((5, 9, 3), True), ((5, 9, 2), False), ((5, 9), False), ((5, 9, 3, 1), False)],
)
def test_an_array_fits_by_number_of_axes_and_fixed_lengths(shape, fits):
    assert POSE.fits(shape) is fits


def test_time_is_the_first_axis():
    assert POSE.over_time
    assert not Channel(("feet",), "m", "").over_time
    with pytest.raises(ValueError, match="frames"):
        Channel(("feet", "frames"), "m", "")
    with pytest.raises(ValueError, match="tuple"):
        Channel("frames", "m", "")


@pytest.mark.parametrize("axes", [(), ("frames",), ("frames", ("x", "y", "z"))])
def test_units_belong_to_the_entries_of_the_last_axis(axes):
    with pytest.raises(ValueError, match="unit"):
        Channel(axes, ("m", "rad"), "")


def test_the_motion_of_one_individual_computes_its_channels_when_they_are_read():
    calls = []

    def double():
        calls.append(1)
        return {"double": 2 * np.arange(3.0), "half": np.arange(3.0) / 2}

    motion = Motion(10.0, {"x": np.arange(3.0)}, {("double", "half"): double}, {2: "it fell"})
    one, last = motion.of(1), motion.of(2)
    assert not calls
    assert [*one] == ["x", "double", "half"]
    assert one["x"].tolist() == [1]
    assert one["half"].tolist() == [0.5]
    assert not one.failures
    assert last["double"].tolist() == [4]
    assert last.failures == {0: "it fell"}
    assert len(calls) == 1
