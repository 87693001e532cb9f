"""Questions about guesses from a robot's file, and their answers."""

import pytest
from small_robots import CORNERS, QUADRUPED, box, dog_urdf, leg, robot, spread_leg

from gaitsim.experiment import load_experiment, parse_assignments
from gaitsim_robot.loading import BUNDLED
from gaitsim_robot.organism import Robot

PLACES = zip("abcd", CORNERS.values(), strict=True)
NAMELESS = robot(box(0.4, 0.16, 0.1, 4), *(leg(name, *place) for name, place in PLACES))
SPIDERY = [(x, side, side * 1.57) for x in (0.1, 0.0, -0.1) for side in (1, -1)]
LEGS = [spread_leg(f"leg_{n}", x, 0.06 * y, h) for n, (x, y, h) in enumerate(SPIDERY)]
WINGS = [spread_leg(f"wing_{n}", 0.05, 0.06 * y, y * 1.57) for n, y in enumerate((1, -1))]
WINGED = robot(box(0.3, 0.1, 0.04, 1), *LEGS, *WINGS)
MOTORS = "".join(
    f'<position joint="{name}_{joint}" kp="20" forcerange="-9 9"/>'
    for name in CORNERS
    for joint in ("roll", "pitch", "knee")
)
DRIVEN = QUADRUPED.replace("</mujoco>", f"<actuator>{MOTORS}</actuator></mujoco>")


@pytest.fixture
def asked(tmp_path):
    """Return the questions about a file with options, as texts by option, and the settings."""

    def found(text, *pairs):
        path = tmp_path / ("robot.urdf" if "<robot" in text else "robot.xml")
        path.write_text(text)
        questions = load_experiment(str(path), parse_assignments(pairs)).questions()
        return (
            {one.option: one.text for one in questions},
            [f"organism.{one.option}={one.value}" for one in questions],
        )

    return found


@pytest.mark.parametrize("text", [NAMELESS, WINGED, DRIVEN, dog_urdf()], ids=range(4))
def test_pasted_answers_are_valid_and_silence_all_questions(asked, text):
    texts, settings = asked(text)
    assert texts
    assert asked(text, *settings) == ({}, [])


def test_the_costliest_guesses_come_first(asked):
    texts, settings = asked(NAMELESS)
    assert [*texts] == ["facing", "motors", "torque_limit", "speed_limit", "stance"]
    assert "organism.facing=+x" in settings
    assert "all 12 joints" in texts["motors"]
    assert "facing" not in asked(NAMELESS, "organism.facing=-x")[0]


def test_names_and_motors_in_the_file_are_no_guesses(asked):
    assert [*asked(QUADRUPED)[0]][:2] == ["motors", "torque_limit"]
    assert [*asked(DRIVEN)[0]] == ["speed_limit", "stance"]


def test_limbs_that_names_exclude_are_asked_about(asked):
    assert "wing_0_tibia, wing_1_tibia not legs, as their names say" in asked(WINGED)[0]["feet"]


def test_limbs_that_hardly_reach_the_ground_are_asked_about(asked):
    legs = [leg(name, x, y) for name, (x, y) in CORNERS.items()]
    short = [
        leg(name, 0.0, y).replace("-0.2", "-0.12").replace("-0.18", "-0.1")
        for name, y in (("e", 0.2), ("f", -0.2))
    ]
    texts, settings = asked(robot(box(0.4, 0.16, 0.1, 4), *legs, *short))
    assert "e_shank, f_shank not legs, as they hardly reach the ground" in texts["feet"]
    assert 'organism.feet=["FL_shank", "FR_shank", "RL_shank", "RR_shank"]' in settings


@pytest.mark.parametrize(
    ("units", "option", "unit", "value"),
    [
        ({"length": 1e3}, "scale", "millimetres", "0.001"),
        ({"mass": 1e3}, "mass_scale", "grams", "0.001"),
    ],
)
def test_implausible_units_are_asked_about_first(asked, units, option, unit, value):
    texts, settings = asked(dog_urdf(**units))
    assert next(iter(texts)) == option
    assert f"in its file in {unit}?" in texts[option]
    assert f"organism.{option}={value}" in settings


def test_a_placeholder_is_a_guess_of_the_torque(asked):
    texts, _ = asked(DRIVEN.replace("-9 9", "-900 900"))
    assert "Assumed, as the file's 900 N m is a placeholder" in texts["torque_limit"]


@pytest.mark.parametrize("name", BUNDLED)
def test_nothing_is_asked_about_bundled_robots(name):
    assert Robot(model=name).questions() == ()
