"""A robot's stride frequency and torque, which every command says alike."""

import numpy as np
import pytest

from gaitsim.console.analysis_view import print_gait
from gaitsim.encoding import split_genomes
from gaitsim.evaluation.playing import play
from gaitsim.experiment import load_experiment
from gaitsim.gait import analyse_individual
from gaitsim.gait.repertoire import gaits_of
from gaitsim.gait.to_dict import gait_to_dict
from gaitsim.individual import Individual

EXPERIMENT = load_experiment("hexapod", {"organism.duration": 4.0})
TRIPOD = EXPERIMENT.organism.starts()["tripod"]


@pytest.fixture(scope="module")
def tripod():
    return Individual.of_motion(EXPERIMENT, EXPERIMENT.organism.move(TRIPOD[None]))


def test_one_frequency_is_said_everywhere(tripod, capsys):
    groups = EXPERIMENT.organism._encoding.groups
    gene = split_genomes(TRIPOD[None], groups)[-1][0, 0]
    commanded = float(tripod.motion["stride_frequency"][0])
    assert commanded <= gene
    gait = analyse_individual(tripod)
    assert tripod.measures["stride frequency"] == gait.footfalls.stride.frequency == commanded
    assert gait_to_dict(gait)["stride"]["frequency"] == commanded
    [[listed]] = [[*group] for group in gaits_of(EXPERIMENT, TRIPOD[None], 1)]
    assert (listed.frequency, listed.name.name) == (commanded, "alternating tripod")
    duty = tripod.measures["duty factor"]
    assert listed.duty_factor == pytest.approx(duty)
    assert np.mean([foot.duty_factor for foot in gait.footfalls.feet]) == pytest.approx(duty)
    tape = Individual.of_motion(EXPERIMENT, play(EXPERIMENT, tripod.joint_angles[None]))
    assert tape.measures["stride frequency"] == pytest.approx(commanded, rel=0.01)
    assert analyse_individual(tape).name.name == gait.name.name == "alternating tripod"
    print_gait(tripod, gait)
    shown = capsys.readouterr().out
    assert f"Stride frequency {commanded:.2f} Hz as commanded" in shown
    touches = 1 + tripod.measures["chatter"]
    assert touches > 1.5
    assert f"the feet touch the ground {touches:.1f} times per stride" in shown
    assert "Servos would overheat" in shown
