"""Trials on a robot: `gaitsim robots evolve` and `robots adapt`, whose robot is a function."""

import io
import json

import numpy as np
import pytest

from gaitsim.sharing.challenge import Challenge
from gaitsim_wire.trials import Played, _felt

PORT = ("--port", "none", "--calibration", "none.toml")
RUN = """
name = "reach"
[evolution]
population = 6
generations = 1
[organism]
plugin = "puppet"
[fitness]
plugin = "puppet-reach"
[search]
plugin = "cma-es"
"""


@pytest.fixture
def played(monkeypatch):
    """The genomes that the robot has played."""
    genomes = []

    def play(wire, individual, path):
        genomes.append(tuple(individual.genome))
        return Played(turned=10.0, sway=0.1, tilt=2.0)

    monkeypatch.setattr("gaitsim_wire.trials.play", play)
    return genomes


@pytest.fixture
def evolve(gaitsim, tmp_path, once, played, monkeypatch):
    """Return a function that evolves on the robot, with typed lines."""
    (tmp_path / "reach.toml").write_text(RUN)
    once("reach", tmp_path / "runs/reach", lambda: gaitsim("run", "reach.toml", "--workers", 1))

    def run(lines, *words, code=0):
        stdin = io.StringIO(lines) if isinstance(lines, str) else lines
        monkeypatch.setattr("sys.stdin", stdin)
        return gaitsim("robots", "evolve", "reach", *PORT, *words, code=code)

    return run


def log_of(tmp_path):
    return json.loads((tmp_path / "reach-robot/trials.json").read_text())


def test_a_search_that_is_continued_tries_the_same_gaits(evolve, played, tmp_path):
    whole = "".join(f"\n0.{number}\n" for number in range(1, 10))
    evolve(whole, "--trials", 9, "--out", "whole")
    expected = [*played]
    assert len({*expected}) == 9
    played.clear()
    # Interrupted before a gait, and at the question for its result: the gait is played again.
    evolve("\n0.1\n\n0.2\n\n", "--trials", 9)
    evolve("undo\n\n0.2\n" + "".join(f"\n0.{number}\n" for number in range(3, 10)), "--trials", 9)
    assert played == [*expected[:3], *expected[1:]]
    assert [trial["genome"] for trial in log_of(tmp_path)["trials"]] == [*map(list, expected)]


def test_a_better_gait_is_found_and_leaves_as_a_code(evolve, played, tmp_path, monkeypatch):
    """The robot walks best with genes that the search has to find."""

    class Person(io.StringIO):
        asked = False

        def readline(self):
            self.asked = not self.asked
            distance = 2 - np.abs(np.array(played[-1:]) - 0.3).max(initial=0.0)
            return "\n" if self.asked else f"{distance:.6f}\n"

    monkeypatch.setattr("gaitsim_wire.trials.RobotSearch.expected", 2.0)
    evolve(Person(), "--trials", 60, "--step", 0.2)
    trials = log_of(tmp_path)["trials"]
    measured = [trial["values"][0] for trial in trials]
    assert np.mean(measured[-6:]) > np.mean(measured[:6]) + 0.1
    best = trials[int(np.argmax(measured))]
    challenge = Challenge.read((tmp_path / "reach-robot/best.txt").read_text())
    assert [*challenge.individual.genome] == best["genome"]


def test_answers_are_checked_and_can_be_undone(evolve, played, tmp_path):
    found = evolve("\nfar\nagain\n\n62cm\n\nundo\n\nfell 0.1\n\ncould not play\n\n\n")
    assert "far" in found.stderr
    first, second = played[0], played[2]
    assert played[:5] == [first, first, second, first, second]
    first, second = log_of(tmp_path)["trials"]
    assert (first["values"], first["outcome"]) == ([0.1], "fell")
    assert second["outcome"] == "could not play"


def test_an_improbable_distance_is_asked_about(evolve, tmp_path, monkeypatch):
    monkeypatch.setattr("gaitsim_wire.trials.RobotSearch.expected", 2.0)
    assert "Is that right?" in evolve("\n6200\nn\n0.5\n\n\n").stdout
    assert [trial["text"] for trial in log_of(tmp_path)["trials"]] == ["0.5"]


def test_other_settings_and_damaged_files_are_refused(evolve, tmp_path):
    evolve("\n0.5\n\n\n")
    assert "--step" in evolve("", "--step", 0.3, code=2).stderr
    path = tmp_path / "reach-robot/trials.json"
    log = log_of(tmp_path)
    for change in ({"genome": [0.0]}, {"values": []}, {"values": [1e300]}, {"text": "\x1b"}):
        changed = {**log, "trials": [{**log["trials"][0], **change}]}
        path.write_text(json.dumps(changed))
        assert "is damaged" in evolve("", code=2).stderr
    path.write_text("{")
    assert "is damaged" in evolve("", code=2).stderr


def test_the_measurements_of_the_imu_are_those_while_the_gait_was_played():
    yaw = np.radians([0, 170, 179, -179, -170, 0])
    orientation = np.stack([np.full(6, 0.1), [1, 0, 0, -0.2, 0, 1], yaw], axis=1)
    driving = np.array([False, True, True, True, True, False])
    found = _felt(orientation, driving)
    assert (found.turned, found.tilt) == pytest.approx((20, np.degrees(0.2)))
    assert found.sway == pytest.approx(np.sqrt(np.square(np.radians([0, 9, 11, 20])).mean()))
    assert str(_felt(np.full((6, 3), np.nan), driving)) == ""


def test_only_enter_starts_the_robot(evolve, played):
    evolve("undo\nquit\n", code=130)
    assert not played


def test_without_a_keyboard_the_robot_does_not_move(evolve, played):
    evolve("", code=130)
    evolve("\n0.1\n", code=130)
    assert len(played) == 1
