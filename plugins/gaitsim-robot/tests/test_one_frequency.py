"""A robot's stride frequency and torque, which every command says alike."""

from dataclasses import replace

import numpy as np
import pytest

from gaitsim.console.analysis_view import print_gait
from gaitsim.encoding import split_genomes
from gaitsim.evaluation.playing import play
from gaitsim.experiment import load_experiment
from gaitsim.gait import analyse_individual
from gaitsim.gait.repertoire import gaits_of
from gaitsim.gait.report import quantities
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


def test_torque_is_said_alike_and_beside_what_servos_sustain(tripod):
    gait = analyse_individual(tripod)
    table = quantities(gait)
    for name in ("peak torque", "RMS torque"):
        assert table[name].value == pytest.approx(tripod.measures[name])
    effort = gait.effort
    assert effort.continuous == pytest.approx(0.2)
    hot = int(np.argmax(tripod.motion["rms_torque"][0]))
    assert table["RMS torque"].help.startswith(f"{effort.joints[hot]}, share")
    assert gait_to_dict(gait)["effort"][effort.joints[hot]]["rms"] == effort.rms[hot]
    assert f"{effort.joints[hot]} needs {effort.rms[hot]:.2f} of its stall torque" in effort.warning


def test_words_about_torque_follow_its_value(tripod):
    effort = replace(
        analyse_individual(tripod).effort,
        joints=("hip", "knee", "toe"),
        peak=np.array([1.0, 0.998, 0.5]),
        rms=np.array([0.1, 0.19, 0.15]),
        continuous=np.array([0.2, 0.2, 0.1]),
    )
    assert effort.peak_in_words == "at stall: hip and 1 more"
    assert "1 of 3 joints" in effort.warning
    assert "toe needs 0.15 of its stall torque, 1.5 times its rating" in effort.warning
    assert replace(effort, rms=np.zeros(3)).warning == ""
    unknown = replace(effort, continuous=np.zeros(3), peak=np.array([0.2, 0.9, 0.0]))
    assert unknown.warning == ""
    assert unknown.peak_in_words == "knee, share of its stall torque"
    assert unknown.rms_in_words == "knee, share of its stall torque"
