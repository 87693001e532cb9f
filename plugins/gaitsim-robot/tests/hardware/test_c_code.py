"""Gaits with reflexes as C99: the same angles as in Python, also in the loop with the physics."""

import re
from dataclasses import replace

import numpy as np
import pytest
from c_gait import ALL, CGait, CPilot, largest_difference, robot

import gaitsim as gs
from gaitsim.contracts import Reflex
from gaitsim.errors import GaitsimError
from gaitsim.individual import Individual
from gaitsim_hardware.c_code import c_code, controller_of

ROBOTS = [
    ("hexapod", ("heading",), {}),
    ("quadruped", ("heading", "level", "contact"), {}),
    ("spider-physics", ("heading",), {"encoding": "sine"}),
]
TOLERANCE = 1e-6  # rad; foot paths are stored as floats


@pytest.mark.sampled
@pytest.mark.parametrize(("preset", "reflexes", "options"), ROBOTS)
def test_c_computes_the_same_angles(tmp_path, preset, reflexes, options):
    organism, genome = robot(preset, reflexes, **options)
    assert largest_difference(organism, genome, tmp_path, 1000) < TOLERANCE


@pytest.mark.slow
def test_c_computes_the_same_angles_for_two_minutes_with_all_reflexes(tmp_path):
    organism, genome = robot("hexapod", tuple(ALL))
    assert largest_difference(organism, genome, tmp_path, 6000) < TOLERANCE


@pytest.mark.slow
def test_float_is_precise_enough_for_servos(tmp_path):
    organism, genome = robot("hexapod", tuple(ALL))
    flags = ("-DGAIT_REAL=float", "-Wno-conversion")
    assert largest_difference(organism, genome, tmp_path, 1000, *flags) < 1e-5


@pytest.mark.slow
def test_a_robot_walks_the_same_with_c_in_the_loop(tmp_path, monkeypatch):
    told = {
        "duration": 10.0,
        "sensors": ["mpu6050"],
        "drive": [{"at": 0.5, "speed": 0.2}, {"at": 4, "turn": 30, "sideways": 0.05}, {"at": 9}],
    }
    organism, genome = robot("hexapod", ("heading", "level"), **told)
    code = c_code(organism.controller(genome), "a gait")
    walker = organism.calibrated(genome)
    expected = walker.move(genome[None])

    def pilot(*arguments):
        made = CPilot(*arguments)
        made.gait = CGait(code, tmp_path)
        return made

    monkeypatch.setattr("gaitsim_robot.organism.Pilot", pilot)
    walked = walker.move(genome[None])
    assert np.abs(expected["torso"][0, -1, :2]).max() > 0.3
    difference = np.abs(walked["torso"] - expected["torso"]).max()
    assert difference < 1e-3


@pytest.mark.slow
def test_the_size_of_the_state_is_that_of_the_summary(tmp_path):
    organism, genome = robot("hexapod", tuple(ALL))
    code = c_code(organism.controller(genome), "a gait")
    assert CGait(code, tmp_path).size == code.state
    assert f"{code.state / 1000:.1f} kB of state" in code.summary


@pytest.mark.sampled
@pytest.mark.parametrize("hostile", ["*/ int x; /*", 'a"b\\', "??/\n#error", "\u202eé@TABLES@"])
def test_names_cannot_become_code(tmp_path, hostile):
    organism, genome = robot()
    controller = organism.controller(genome)
    rhythm = controller.rhythm
    names = tuple(f"{hostile}{number}" for number in range(18))
    legs = tuple(f"{hostile}{number}" for number in range(6))
    rhythm = replace(rhythm, names=legs, joint_names=names)
    gait = CGait(c_code(replace(controller, rhythm=rhythm), hostile), tmp_path)
    texts = [(tmp_path / name).read_text() for name in ("gait.h", "gait.c")]
    assert all("\u202e" not in text for text in texts)
    senses = np.zeros(6 + 2 * 6 + 18)
    assert gait.step(senses, [0, 0, 0, 0], 18) == pytest.approx(rhythm.standing)


class Silent(Reflex):
    """A reflex without C code."""

    def step(self, state, seen, inputs, interval):
        """Do nothing."""


class Misnamed(Silent):
    """A reflex with a state that has no name in C."""

    def c99(self):
        return "s->x = 1;"


def test_a_reflex_that_cannot_be_exported_is_named():
    organism, genome = robot()
    controller = organism.controller(genome)
    with pytest.raises(
        GaitsimError, match=r"reflex 'heading' of package gaitsim-robot .* no C code"
    ):
        c_code(replace(controller, reflexes={"heading": Silent()}), "a gait")
    states = {"level": {"double": np.zeros(1)}}
    with pytest.raises(GaitsimError, match="'double', which is not a name in C"):
        c_code(replace(controller, reflexes={"level": Misnamed()}, states=states), "a gait")


def test_bodies_that_follow_no_commands_are_refused(tmp_path):
    experiment = gs.load_experiment("walker")
    genome = experiment.organism.genome_space().lower
    walker = Individual(experiment, 0.0, {}, 1, genome)
    with pytest.raises(GaitsimError, match="cannot follow commands") as error:
        gs.export(walker, tmp_path / "x", "c")
    assert "gaitsim run hexapod" in error.value.allowed
    from_file = Individual(experiment, 0.0, {}, source=tmp_path / "x.csv")
    with pytest.raises(GaitsimError, match="only joint angles"):
        controller_of(from_file)


def test_an_individual_is_exported(tmp_path):
    experiment = gs.load_experiment("hexapod")
    genome = next(iter(experiment.organism.starts().values()))
    done = gs.export(Individual(experiment, 0.0, {}, 1, genome), tmp_path / "walk", "c")
    assert "18 joints, 6 legs, reflexes: none" in done.summary
    header = (tmp_path / "walk" / "gait.h").read_text()
    speed = float(re.search(r"#define GAIT_SPEED (\S+)", header)[1])
    assert speed == pytest.approx(experiment.organism.controller(genome).rhythm.own_speed[0])


@pytest.mark.sampled
@pytest.mark.parametrize(("format", "header"), [("c", "gait.h"), ("ros2-package", "src/gait.h")])
def test_a_gait_of_the_spider_is_exported_for_its_twin(tmp_path, format, header):
    experiment = gs.load_experiment("spider")
    genome = next(iter(experiment.organism.starts().values()))
    done = gs.export(Individual(experiment, 0.0, {}, 1, genome), tmp_path / "walk", format)
    assert "24 joints, 8 legs, reflexes: heading" in done.summary
    assert "played by spider-physics" in done.notices[0]
    assert "#define GAIT_NEEDS_ORIENTATION 1" in (tmp_path / "walk" / header).read_text()
