"""Reference gaits are named correctly from any start and in any order of the legs."""

import importlib.util
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st

from gaitsim.gait import analyse_gait

DATA = Path(__file__).parents[2] / "data"
SECONDS = 299 / 30
# Name, frequency in Hz, duty factor, speed in m/s: stroke × frequency / duty factor.
WALKS = {
    "alternating-tetrapod": ("alternating tetrapod", 1.25, 1 / 2, 0.05 * 1.25 / (1 / 2)),
    "alternating-tripod": ("alternating tripod", 1.25, 1 / 2, 0.05 * 1.25 / (1 / 2)),
    "ripple": ("ripple", 0.75, 3 / 4, 0.05 * 0.75 / (3 / 4)),
    "wave": ("wave", 0.375, 7 / 8, 0.05 * 0.375 / (7 / 8)),
}


@pytest.fixture(scope="module")
def script():
    """The module that makes the gaits."""
    spec = importlib.util.spec_from_file_location("make_gaits", DATA / "make_gaits.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def test_the_files_are_what_the_script_makes(script, reference):
    assert sorted(script.GAITS) == sorted(path.stem for path in (DATA / "gaits").iterdir())
    for name, make in script.GAITS.items():
        angles = reference(name)
        assert angles.shape == (300, 24)
        assert np.abs(angles - make()).max() < 1e-6
        with np.load(DATA / f"gaits/{name}.npz") as file:
            assert tuple(file["joint_names"]) == script.JOINTS
        assert name in (DATA / "SOURCES.md").read_text()


@pytest.mark.parametrize("file", WALKS)
def test_walks_are_named_and_measured(file, reference, played):
    name, frequency, duty, speed = WALKS[file]
    gait = analyse_gait(played(reference(file)), reference(file))
    assert gait.name.name == name
    assert gait.name.distance < 0.01
    assert gait.distances[name] == gait.name.distance == min(gait.distances.values())
    assert gait.flags == gait.missing == ()
    feet = [foot for foot in gait.footfalls.feet if foot.steps]
    assert len(feet) == (6 if "tripod" in name else 8)
    assert gait.footfalls.stride.frequency == pytest.approx(frequency, rel=1e-3)
    assert gait.footfalls.stride.periodicity > 0.99
    for foot in feet:
        # Sampled half-way between frames, a foot is down for up to a frame more.
        assert foot.duty_factor == pytest.approx(duty, abs=1 / 24)
        assert foot.stance == pytest.approx(duty / frequency, abs=1 / 30 + 1e-9)
        assert foot.stance + foot.swing == pytest.approx(1 / frequency, rel=1e-6)
    assert gait.travel.forward == pytest.approx(speed * SECONDS, rel=0.01)
    assert gait.travel.speed == pytest.approx(speed, rel=0.01)
    assert abs(gait.travel.lateral) < 0.003
    assert abs(gait.travel.yaw) < 1e-3
    assert gait.footfalls.slip.ratio < 1e-3
    assert gait.footfalls.margin.min() > 0.02
    turned = np.abs(np.diff(reference(file), axis=0)).sum()
    assert gait.travel.joint_travel == pytest.approx(turned / gait.travel.forward, rel=0.01)


def test_phases_are_those_of_the_generated_gait(reference, played):
    found = analyse_gait(played(reference("ripple"))).footfalls
    assert [foot.name for foot in found.feet] == ["L1", "L2", "L3", "L4", "R1", "R2", "R3", "R4"]
    assert found.phases == pytest.approx([0, 0.75, 0.5, 0.25, 0.5, 0.25, 0, 0.75], abs=0.01)
    assert found.consistency == pytest.approx(1)
    tripod = analyse_gait(played(reference("alternating-tripod"))).footfalls
    assert np.isnan(tripod.phases).tolist() == [False, False, True, False] * 2


def test_a_motion_near_no_reference_gait_has_no_name(reference, played):
    standing = analyse_gait(played(reference("standing")))
    assert (standing.name.name, standing.name.reason) == ("standing", "nothing moves")
    assert standing.flags == ()
    assert standing.travel.speed == 0
    assert standing.travel.straightness is standing.travel.joint_travel is None
    assert standing.footfalls.slip.ratio is None
    for name in ("noise", "flip-flop"):
        assert analyse_gait(played(reference(name))).name.name == "none"


def test_the_flip_flop_is_flagged(reference, played):
    flags = {flag.name: flag.seen for flag in analyse_gait(played(reference("flip-flop"))).flags}
    assert set(flags) == {"flip-flop", "sliding"}
    assert "14.9 Hz" in flags["flip-flop"]
    assert "L1, L2, L3, L4, R1, R2, R3, R4" in flags["flip-flop"]


@pytest.mark.slow
@settings(max_examples=5)
@given(
    file=st.sampled_from(sorted(WALKS)), shift=st.integers(0, 79), order=st.permutations(range(8))
)
def test_neither_the_start_nor_the_order_of_legs_changes_the_name(
    reference, played, file, shift, order
):
    skeleton = played(reference(file)[shift:])
    permuted = replace(
        skeleton,
        contacts=skeleton.contacts[:, order],
        touching=skeleton.touching[:, order],
        contact_names=tuple(skeleton.contact_names[index] for index in order),
    )
    gait, same = analyse_gait(permuted), analyse_gait(skeleton)
    assert gait.name.name == WALKS[file][0]
    assert gait.footfalls.feet == same.footfalls.feet
    assert gait.footfalls.margin == pytest.approx(same.footfalls.margin)


def test_a_wave_the_other_way_is_metachronal(script, played):
    phases = [0, 0.3, 0.6, 0.9, 0.5, 0.8, 0.1, 0.4]
    name = analyse_gait(played(script.stepping(phases, 0.75, 0.7, 0.05, 0.015))).name
    assert name.name == "metachronal"
    assert name.lag == pytest.approx(0.3, abs=0.011)
    assert "front to back" in name.reason
