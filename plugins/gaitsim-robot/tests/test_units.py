"""Robot files in other units than metres, kilograms and radians: warnings and scales."""

import mujoco
import numpy as np
import pytest
from small_robots import QUADRUPED, dog_urdf

import gaitsim as gs
from gaitsim.errors import ExperimentError, GaitsimError
from gaitsim.experiment import load_experiment, parse_experiment
from gaitsim_robot.importing.convert import convert
from gaitsim_robot.loading import BUNDLED
from gaitsim_robot.organism import Robot
from gaitsim_robot.units import unit_warning

INCH = 1 / 0.0254  # inches in a metre
ARRAYS = ("body_pos", "body_ipos", "body_mass", "body_inertia", "geom_size", "geom_pos", "jnt_pos")


def read(path, **scales):
    """Import a file in this process; return MuJoCo's model, the repairs and the warnings."""
    found = convert(str(path), [], **scales)
    model = mujoco.MjModel.from_xml_string(found["text"])
    return model, " | ".join(found["repairs"]), " | ".join(found["warnings"])


@pytest.fixture
def write(tmp_path):
    """Write a file `dog.urdf` in the given units and return its path."""

    def written(**units):
        path = tmp_path / "dog.urdf"
        path.write_text(dog_urdf(**units))
        return path

    return written


@pytest.mark.parametrize(
    ("units", "scales"),
    [
        ({"length": 1e3}, {"scale": 1e-3}),
        ({"length": INCH}, {"scale": 0.0254}),
        ({"mass": 1e3}, {"mass_scale": 1e-3}),
        ({"length": 1e3, "mass": 1e3}, {"scale": 1e-3, "mass_scale": 1e-3}),
    ],
)
def test_a_scaled_file_is_the_robot_in_metres_and_kilograms(write, units, scales):
    expected, no_repairs, _ = read(write())
    model, repairs, _ = read(write(**units), **scales)
    for name in ARRAYS:
        assert getattr(model, name) == pytest.approx(getattr(expected, name), rel=1e-4, abs=1e-7)
    assert "multiplied by" in repairs
    assert "inertias" not in repairs + no_repairs
    # Torques, speeds and angles stay.
    assert (model.jnt_range == expected.jnt_range).all()
    assert (model.jnt_actfrcrange == expected.jnt_actfrcrange).all()


def test_masses_that_result_from_volumes_scale_with_the_cube_of_lengths(write, tmp_path):
    small, _, _ = read(write(masses=False))
    assert read(write(masses=False, length=1e3), scale=1e-3)[0].body_mass == pytest.approx(
        small.body_mass, rel=1e-4
    )
    path = tmp_path / "dog.xml"
    path.write_text(QUADRUPED.replace('mass="4"', "") + "<!-- the trunk has MuJoCo's density -->")
    one, two = read(path)[0], read(path, scale=2.0)[0]
    assert two.body_mass[1] == pytest.approx(8 * one.body_mass[1])
    assert two.body_inertia[1] == pytest.approx(32 * one.body_inertia[1], rel=1e-4)
    assert two.body_mass[2:] == pytest.approx(one.body_mass[2:])
    assert two.body_inertia[2:] == pytest.approx(4 * one.body_inertia[2:], rel=1e-4)


def test_the_keyframe_and_rotors_are_scaled(tmp_path):
    qpos = "1 0 0.5 1 0 0 0" + 4 * " 0 0.6 -1.2" + " 0 0"
    key = f'<keyframe><key name="stand" qpos="{qpos}"/></keyframe></mujoco>'
    path = tmp_path / "dog.xml"
    path.write_text(
        QUADRUPED.replace("</mujoco>", key).replace('"FL_knee"', '"FL_knee" armature="0.01"')
    )
    model, _, _ = read(path, scale=0.5, mass_scale=2.0)
    stand = model.key("stand").qpos
    assert stand[2] == pytest.approx(0.25)
    assert stand[7:13] == pytest.approx([0, 0.6, -1.2, 0, 0.6, -1.2])
    assert model.joint("FL_knee").id
    assert model.dof_armature.max() == pytest.approx(0.01 * 2 * 0.25)


def test_an_experiment_stores_the_scaled_robot(write):
    path = write(length=1e3)
    scaled = load_experiment(str(path), {"organism.scale": 1e-3})
    body = scaled.organism
    assert (body.scale, body.anatomy.trunk) == (1.0, pytest.approx(0.4))
    assert body.warnings() == ()
    assert "lengths multiplied by 0.001" in body.imported().repairs
    path.unlink()
    assert parse_experiment(scaled.to_toml(), "the experiment").organism == body
    with pytest.raises(ExperimentError, match="a text that was already read") as caught:
        parse_experiment(scaled.to_toml(), "the experiment", {"organism.scale": 0.5})
    assert caught.value.problems[0].key == "organism.scale"
    with pytest.raises(GaitsimError, match="bundled: 'hexapod'"):
        Robot(model="hexapod", mass_scale=0.5)


@pytest.mark.parametrize(
    ("length", "mass", "expected"),
    [
        (300, 12, ["millimetres: set 'organism.scale' to 0.001"]),
        (18, 12, ["inches: set 'organism.scale' to 0.0254"]),
        (40, 12, ["centimetres: set 'organism.scale' to 0.01"]),
        (18, 3, ["centimetres or inches: set 'organism.scale' to 0.01 or 0.0254"]),
        (0.4, 1550, ["masses in the file are probably in grams: set 'organism.mass_scale'"]),
        (300, 1550, ["lengths in the file are probably in millimetres", "in grams"]),
        (300, 3e9, ["lengths in the file are probably in millimetres"]),  # 1000 kg/m³ × mm³
        (5, 300, ["check its units"]),
        (0.001, 1, ["check its units"]),
    ],
)
def test_implausible_sizes_and_masses_name_the_likely_units(length, mass, expected):
    warning = unit_warning(length, mass)
    for part in expected:
        assert part in warning
    assert ("organism.mass_scale" in warning) == any("grams" in p or "check" in p for p in expected)


@pytest.mark.parametrize(
    ("length", "mass"),
    [(0.467, 13.1), (0.2, 1.2), (0.05, 0.02), (1.1, 110), (0.9, 80), (0.4, 2.2)],
)
def test_usual_robots_are_not_warned_of(length, mass):
    assert unit_warning(length, mass) == ""


def test_bundled_robots_have_no_warnings():
    assert [Robot(model=name).warnings() for name in BUNDLED] == [()] * len(BUNDLED)


def test_a_robot_that_cannot_be_simulated_names_its_likely_units(write):
    with pytest.raises(GaitsimError, match="cannot be simulated") as caught:
        read(write(length=1e3, masses=False))
    assert "probably in millimetres: set 'organism.scale' to 0.001" in caught.value.remedy
    with pytest.raises(GaitsimError, match="cannot be simulated") as caught:
        read(write(length=1e3, mass=1e3))
    assert "'organism.mass_scale' to 0.001" in caught.value.remedy


def test_limits_in_degrees_are_warned_of(write):
    model, repairs, warnings = read(write(angle=180 / np.pi))
    assert "12 of 12 joints are probably degrees" in warnings
    assert "such as -45.84 to 45.84 of 'FL_roll'" in warnings
    assert "write them in radians: -0.8 to 0.8" in warnings
    assert "limited to ±180°" in repairs
    assert (model.jnt_range[1:, 0] < model.jnt_range[1:, 1]).all()
    assert read(write())[2] == ""


@pytest.mark.parametrize(
    ("old", "new", "what", "remedy"),
    [
        (
            '<compiler angle="radian"/>',
            "",
            "no legs",
            "all joints are within ±3°; if these limits are radians",
        ),
        (
            'size="0.2 0.08 0.05"',
            'size="200 80 50"',
            "'trunk' is 400 m long, although all joints",
            'scale="0.001 0.001 0.001"',
        ),
    ],
)
def test_one_wrong_unit_is_named(tmp_path, old, new, what, remedy):
    """Limits in radians that MuJoCo reads as degrees, and geometry in millimetres."""
    path = tmp_path / "dog.xml"
    path.write_text(QUADRUPED.replace(old, new))
    with pytest.raises(GaitsimError, match=what) as caught:
        load_experiment(str(path))
    assert remedy in str(caught.value)


def test_single_joints_that_turn_often_are_not_degrees(tmp_path):
    path = tmp_path / "dog.xml"
    path.write_text(QUADRUPED.replace('range="-3 3"', 'range="-12.6 12.6"'))
    assert read(path)[2] == ""


@pytest.mark.slow
def test_python_warns_of_a_robot_before_it_evolves(write):
    path = str(write(length=1e3))
    with pytest.warns(UserWarning, match="probably in millimetres"):
        gs.evolve(path, set={"organism.duration": 0.5})


@pytest.mark.slow
def test_a_run_warns_of_its_robot_at_the_start(gaitsim, write):
    write(angle=180 / np.pi)
    brief = "--generations", 1, "--population", 4, "--set", "organism.duration=0.5"
    assert "Warning: the limits of 12 of 12 joints" in gaitsim("run", "dog.urdf", *brief).stderr
