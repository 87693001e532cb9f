"""Mistakes in the options of robots that feel: one message each, which names the remedy."""

import numpy as np
import pytest

from gaitsim.errors import ExperimentError
from gaitsim.experiment import load_experiment
from gaitsim.gait import analyse_individual
from gaitsim.individual import Individual

HEADING = {"heading": {}}

MISTAKES = [
    ({"reflexes": {"headin": {}}}, "unknown reflex 'headin'", "did you mean 'heading'"),
    ({"reflexes": {"heading": {"gian": 1}}}, "unknown option of the reflex 'heading'", "'gain'"),
    ({"reflexes": {"heading": {"gain": 99}}}, "reflexes.heading.gain: 99", "≥ 0 and ≤ 50"),
    ({"reflexes": {"heading": {"gain": np.nan}}}, "heading.gain: nan", "≥ 0 and ≤ 50"),
    ({"reflexes": {"heading": {"gain": "much"}}}, "heading.gain: 'much'", "≥ 0 and ≤ 50"),
    ({"reflexes": {"heading": 4}}, "invalid organism.reflexes", "{ heading = { gain = 2.0 } }"),
    ({"reflexes": ["heading"]}, "invalid organism.reflexes", "{ heading = { gain = 2.0 } }"),
    ({"reflexes": {"contact": {}}}, "needs contacts", "contacts, load"),
    ({"reflexes": HEADING, "sensors": []}, "needs orientation", "mpu6050, bno055, ideal"),
    ({"reflexes": HEADING, "evolve": ["heading.gian"]}, "'heading.gian'", "'heading.gain'?"),
    ({"reflexes": HEADING, "evolve": ["level.gain"]}, "'level.gain'", "heading.limit"),
    ({"reflexes": HEADING, "evolve": ["heading.gain"] * 2}, "listed twice", "at most once"),
    ({"evolve": ["heading.gain"]}, "has no reflexes", "add reflexes to organism.reflexes"),
    ({"drive": [{"at": 0, "sped": 1}]}, "unknown part of a command 'sped'", "'speed'?"),
    ({"drive": [{"at": 2}, {"at": 1}]}, "1 s follows 2 s", "never decrease"),
    ({"drive": [{"at": -1}]}, "invalid at in a drive: -1", "0 to 3600"),
    ({"drive": [{"at": 0, "turn": 999}]}, "invalid turn in a drive: 999", "-720 to 720"),
    ({"drive": [{"speed": "fast"}]}, "invalid organism.drive", "at in s"),
    ({"drive": [{"speed": np.nan}]}, "is not finite", "at in s"),
    ({"drive": {"at": 0}}, "invalid organism.drive", "a list of tables"),
    ({"sensors": ["mpu6050", "bno055"]}, "one IMU", "at most one of mpu6050"),
    ({"sensors": ["mpu"]}, "unknown sensor 'mpu'", "did you mean 'mpu6050'"),
    ({"command_gains": [0, 1, 1]}, "invalid organism.command_gains", "from 0.05 to 20"),
    ({"command_gains": [1, 1]}, "invalid organism.command_gains", "three numbers"),
]


@pytest.mark.parametrize(("options", "what", "remedy"), MISTAKES, ids=str)
def test_a_mistake_is_one_message_with_its_key_and_a_remedy(options, what, remedy):
    overrides = {f"organism.{name}": value for name, value in options.items()}
    with pytest.raises(ExperimentError) as error:
        load_experiment("hexapod", overrides)
    [problem] = error.value.problems
    message = str(problem)
    assert what in message
    assert remedy in message
    assert any(f"organism.{name}" in message for name in options)


def driven(*drive):
    experiment = load_experiment("hexapod", {"organism.drive": [*drive], "organism.duration": 1.0})
    return Individual(experiment, 0.0, {}, 1, experiment.starts()["tripod"])


def limits_of(individual):
    rhythm = individual.experiment.organism.pilot(individual.genome[None]).rhythm
    return rhythm.limits[0]


def test_commands_beyond_the_gait_are_a_warning_with_its_limits():
    fast = driven({"at": 0, "speed": 0.1}, {"at": 0.5, "speed": 5, "turn": -10})
    limits = limits_of(fast)
    [warning] = fast.experiment.organism.gait_warnings(fast.genome)
    assert f"speed 5 of at most {limits[0]:.2g} m/s, turn −10 of at most" in warning
    assert f"{np.degrees(limits[1]):.2g} °/s together, at 0.5 s" in warning
    assert "sideways" not in warning
    assert warning in analyse_individual(fast).warnings


def test_strokes_of_a_straight_command_are_shortened_to_the_limit():
    most = limits_of(driven({"speed": 0.1}))[0]
    [warning] = (fast := driven({"speed": 4 * most})).experiment.organism.gait_warnings(fast.genome)
    assert warning.endswith("strokes are shortened to 25 %.")
    assert "together" not in warning


def test_commands_may_exceed_a_gait_only_together():
    speed, turn = limits_of(driven({"speed": 0.1}))[:2]
    alone = [{"speed": float(speed)}, {"speed": 0, "turn": float(np.degrees(turn))}]
    for entry in alone:
        within = driven(entry)
        assert not within.experiment.organism.gait_warnings(within.genome)
    both = driven(alone[0] | {"turn": float(np.degrees(turn))})
    [warning] = both.experiment.organism.gait_warnings(both.genome)
    assert "together" in warning
