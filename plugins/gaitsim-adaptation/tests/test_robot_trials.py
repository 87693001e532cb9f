"""Trials by people: what they type, corrections, repeats, doubts, and robots of another scale."""

import io
import json

import numpy as np
import pytest

import gaitsim as gs
from gaitsim_adaptation.answers import AnswerReader
from gaitsim_adaptation.record import adaptation_file, read_record
from gaitsim_adaptation.trials import propose
from gaitsim_wire.trials import Played

METRES = AnswerReader("m")


@pytest.mark.parametrize(
    ("text", "reading", "values", "outcome"),
    [
        ("1.3", METRES, (1.3,), "walked"),
        (" 62cm ", METRES, (0.62,), "walked"),
        ("62 cm 0.6 m; 58cm", METRES, (0.62, 0.6, 0.58), "walked"),
        ("62", AnswerReader("m", "cm"), (0.62,), "walked"),
        ("2 ft", METRES, (0.6096,), "walked"),
        ("fell", METRES, (0.0,), "fell"),
        ("could not play", METRES, (0.0,), "could not play"),
        ("5", AnswerReader("m", "", 2.0, 10.0), (4.0,), "walked"),
        ("0.5min", AnswerReader("m", "", 3.0, 10.0), (1.0,), "walked"),
        ("3", AnswerReader(""), (3.0,), "walked"),
    ],
)
def test_what_people_type_is_understood(text, reading, values, outcome):
    answer = reading.read(text)
    assert answer.values == pytest.approx(values)
    assert answer.outcome == outcome


@pytest.mark.parametrize(
    "text", ["", "far", "1.2.3", "1 furlong", "nan", "1e300", "could not play 3", "1 2 x", "5 kg"]
)
def test_what_is_not_understood_is_refused(text):
    with pytest.raises(gs.GaitsimError, match=r"invalid|unknown unit"):
        METRES.read(text)
    with pytest.raises(gs.GaitsimError, match="unknown unit"):
        AnswerReader("m", "kg")
    with pytest.raises(gs.GaitsimError, match="invalid time"):
        AnswerReader("m", "", 2.0, 10.0).read("0")


def objects(done):
    return [json.loads(line) for line in done.stdout.splitlines()]


@pytest.fixture
def robot(gaitsim, atlas):
    """Call `gaitsim adapt` for the robot `mine`."""
    return lambda *given, code=0: gaitsim("adapt", "atlas", "--name", "mine", *given, code=code)


def test_results_are_corrected_repeated_and_undone(robot, atlas):
    (first,) = objects(robot("--stop", 2, "--json"))
    robot("--measured", "50cm")
    robot("--measured", "fell 0.1")
    trials = read_record(adaptation_file(atlas, "mine")).trials
    assert [(one.values, one.outcome) for one in trials] == [((0.5,), "walked"), ((0.1,), "fell")]
    corrected, following = objects(robot("--correct", 1, "0.7", "--json"))
    assert (corrected["trial"], corrected["member"], corrected["measured"]) == (
        1,
        first["member"],
        0.7,
    )
    assert following["proposal"] == 3
    repeated, _ = objects(robot("--repeat", 1, "0.5", "--json"))
    assert (repeated["measured"], repeated["lowest"], repeated["count"]) == (
        pytest.approx(0.6),
        0.5,
        2,
    )
    assert "fell, measured 0.100 m" in robot().stdout
    assert "there is no trial 9" in robot("--correct", 9, 1, code=2).stderr
    assert "--measured and --undo" in robot("--measured", 1, "--undo", code=2).stderr
    undone, again = objects(robot("--undo", "--json"))
    assert (undone["undone"], undone["measured"], again["proposal"]) == (2, 0.1, 2)
    assert "removed trial 1, measured mean of 2 0.600 m" in robot("--undo").stdout
    assert read_record(adaptation_file(atlas, "mine")).trials == ()
    assert "no result to undo" in robot("--undo", code=2).stderr


def test_every_proposal_follows_from_earlier_trials(robot, atlas):
    robot("--stop", 2, "--damage", "B lost", "--robot", "--refine", 2, "--trials", 3)
    for change in (["--measured", 0.5], ["--correct", 1, 0.9], ["--measured", "fell"]):
        robot(*change)
    for value in (0.6, 0.7, 1.1):
        robot("--measured", value)
    adaptation = gs.adapt(gs.load(atlas), robot=True, name="mine")
    assert adaptation.damage == ("B lost",)
    for at, trial in enumerate(adaptation.trials):
        found = propose(adaptation.prior, adaptation.trials[:at], adaptation.settings)
        assert vars(found).items() <= vars(trial).items()
    assert [bool(trial.genome) for trial in adaptation.trials] == [False] * 3 + [True] * 2
    # The best gait is measured twice more, and the lowest value counts.
    assert adaptation.best.number == 5
    assert adaptation.proposal.number == 5
    adaptation.record(0.2)
    assert adaptation.best.number == 1
    for _ in range(2):
        assert adaptation.proposal.number == 1
        adaptation.record("0.9")
    assert adaptation.ending == "2 changes of the best gait were tried"
    assert adaptation.best.measured == pytest.approx(0.9)


def test_an_implausible_result_is_questioned(robot, gaitsim, atlas, monkeypatch):
    robot("--format", "csv", "--unit", "m")
    refused = robot("--measured", 62, code=2).stderr
    assert "--sure" in refused
    assert "times the best expected" in refused
    monkeypatch.setattr("sys.stdin", io.StringIO("62\nn\n0.62\nundo\ncorrect 1 2\n62\ny\n\n"))
    asked = robot("--interactive")
    assert asked.stdout.count("Is that right?") == 2
    assert "there is no trial 1" in asked.stderr
    (one,) = read_record(adaptation_file(atlas, "mine")).trials
    assert one.values == (62.0,)
    # The format of the first call is remembered.
    assert [file.suffix for file in sorted((atlas / "exports").iterdir())] == [".csv", ".csv"]


def test_a_file_of_an_older_version_is_refused(robot, atlas):
    robot()
    path = adaptation_file(atlas, "mine")
    stored = json.loads(path.read_text())
    stored |= {"format": 2, "said": stored.pop("trials")}
    path.write_text(json.dumps(stored))
    assert "older version" in robot(code=2).stderr
    robot("--fresh")


@pytest.mark.parametrize("scale", [0.4, 1.5])
def test_the_scale_of_a_robot_is_learned_or_given(atlas, scale):
    run = gs.load(atlas)

    def weak(individual):
        return scale * individual.measures["forward"]

    unknown = [*gs.adapt(run, robot=weak)]
    assert len(unknown) <= 6
    assert len([*gs.adapt(run, robot=weak, scale=scale)]) == 1
    assert len([*gs.adapt(run, robot=weak, name="whole", trials=3)]) == 3
    given = gs.adapt(run, robot=weak, scale="whole")
    assert given.settings.scale == pytest.approx(scale)
    with pytest.raises(gs.GaitsimError, match="intact robot"):
        gs.adapt(run, robot=weak, scale="none")


def test_changes_of_the_best_gait_improve_it(gaitsim, atlas):
    given = ("adapt", "atlas", "--damage", "A lost", "--refine", 15)
    *trials, last = objects(gaitsim(*given, "--json"))
    changed = [trial for trial in trials if "genome" in trial]
    of_map = max(trial["measured"] for trial in trials if "genome" not in trial)
    assert len(changed) == 15
    for trial in changed:
        assert trial["measured"] == pytest.approx(np.sin(trial["genome"][1:]).sum())
    assert last["measured"] >= of_map
    assert last["genome"] in [trial["genome"] for trial in changed]
    near = 0.3  # best angle of the joints, in the middle of their range

    def robot(individual):
        return 3.0 - np.square(individual.genome - near).sum()

    adapted = gs.adapt(gs.load(atlas), robot=robot, scale=1, trials=2, refine=30)
    trials = [*adapted]
    assert 3 - adapted.best.measured < 0.7 * (3 - max(one.measured for one in trials[:2]))
    shown = gaitsim(*given).stdout
    assert "gaitsim play runs/atlas --gait" in shown
    assert (atlas / "exports/A-lost-best.mat").exists()


def test_each_proposed_gait_is_played_on_the_robot(atlas, gaitsim, monkeypatch):
    played = []

    def play(wire, individual, path):
        played.append((individual.member.number, path))
        return Played()

    monkeypatch.setattr("gaitsim_wire.trials.play", play)
    words = "robots", "adapt", atlas, "--port", "none", "--calibration", "none.toml"
    monkeypatch.setattr("sys.stdin", io.StringIO("\n0.2\n\nagain\n\n0.25\n\n\n"))
    assert "2 trials are saved" in gaitsim(*words).stderr
    assert len(played) == 4
    assert played[0] != played[1] == played[2] != played[3]
    monkeypatch.setattr("sys.stdin", io.StringIO(""))
    gaitsim(*words, code=130)
    assert len(played) == 4
