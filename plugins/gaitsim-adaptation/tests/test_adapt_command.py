"""`gaitsim adapt`: trials in simulation and on a robot, continued sessions, errors, files."""

import io
import json
import shutil

import numpy as np
import pytest
from hostile import ATTACKS

import gaitsim as gs
from gaitsim_adaptation.settings import AdaptationSettings

LOST = ("--damage", "A lost")


def objects(done):
    return [json.loads(line) for line in done.stdout.splitlines()]


@pytest.fixture
def adapt(gaitsim, atlas):
    return lambda *given, code=0: gaitsim("adapt", "atlas", *given, code=code)


@pytest.fixture
def answers(monkeypatch):
    """Answer questions with the given lines; the line "^C" presses Ctrl-C."""

    class Typed(io.StringIO):
        def readline(self):
            line = super().readline()
            if line == "^C\n":
                raise KeyboardInterrupt
            return line

    return lambda *lines: monkeypatch.setattr("sys.stdin", Typed("\n".join([*lines, ""])))


def test_trials_measure_the_damaged_body_and_the_output_ends_with_commands(adapt, gaitsim, atlas):
    *trials, last = objects(adapt(*LOST, "--json"))
    members = gs.load(atlas).members
    for trial in trials:
        genome = members.genomes[trial["member"] - 1]
        assert trial["measured"] == pytest.approx(np.sin(genome[1:]).sum())
    best = max(trials, key=lambda trial: trial["measured"])
    assert (last["member"], last["measured"]) == (best["member"], best["measured"])
    assert last["share"] == pytest.approx(best["measured"] / np.sin(members.genomes).sum(1).max())
    shown = adapt(*LOST).stdout
    assert f"gaitsim play runs/atlas --member {best['member']} --damage 'A lost'" in shown
    gaitsim("export", "atlas", "--member", best["member"])


def test_bodies_of_their_own_cannot_adapt(gaitsim):
    options = "--generations", "1", "--population", "20", "--out", "own"
    gaitsim("run", "spider-atlas", "--set", "organism.evolve=['femur']", *options)
    refused = gaitsim("adapt", "own", "--damage", "L2 lost", code=2)
    assert "one body adapts" in refused.stderr


def test_the_same_command_continues_and_never_repeats_a_trial(adapt, atlas):
    given = (*LOST, "--stop", "1.5", "--json")
    whole = objects(adapt(*given, "--trials", "6"))
    assert len(whole) == 7
    file = atlas / "adaptations/A-lost.json"
    kept = file.read_bytes()
    assert objects(adapt(*given, "--trials", "6")) == whole
    assert file.read_bytes() == kept
    assert objects(adapt(*given, "--trials", "2", "--fresh"))[:2] == whole[:2]
    assert objects(adapt(*given, "--trials", "6")) == whole
    assert file.read_bytes() == kept


@pytest.mark.parametrize("other", [("--kappa", "1"), ("--measure", "turn B"), ("--name", "A-lost")])
def test_a_file_of_a_different_adaptation_is_refused_without_fresh(adapt, other):
    adapt(*LOST, "--trials", "2")
    changed = (*other, "--damage", "B lost") if "--name" in other else (*LOST, *other)
    assert "--fresh" in adapt(*changed, code=2).stderr
    adapt(*changed, "--fresh")


def test_a_changed_atlas_is_refused(adapt, gaitsim):
    adapt(*LOST)
    gaitsim("resume", "atlas", "--generations", 6, "--workers", 1)
    assert "the atlas has changed" in adapt(*LOST, code=2).stderr


def test_an_interrupted_interactive_session_continues_where_it_was(adapt, atlas, answers):
    answers("0.5", "far", "nan", "-0.25", "^C")
    stopped = adapt("--interactive", "--stop", "1.5", code=130)
    assert "gaitsim adapt runs/atlas --interactive" in stopped.stderr
    assert stopped.stderr.count("a finite number") == 2
    answers("1", "")
    adapt("--interactive")
    stored = json.loads((atlas / "adaptations/robot.json").read_text())
    assert [one["values"] for one in stored["trials"]] == [[0.5], [-0.25], [1.0]]
    answers()  # the end of the input also ends the session
    asked = adapt("--interactive", "--format", "npz").stdout
    file = atlas / "exports/robot-trial-4.npz"
    assert str(file.relative_to(atlas.parent.parent)) in asked
    (one,) = objects(adapt("--json"))
    angles = np.load(file)["bestGait"][-1]
    np.testing.assert_array_equal(angles, gs.load(atlas).members.genomes[one["member"] - 1])


def test_a_program_gives_measured_values_one_by_one(adapt):
    assert "there is no adaptation 'robot'" in adapt("--measured", "1", code=2).stderr
    (proposal,) = objects(adapt("--json"))
    trial, following = objects(adapt("--measured", "0.4", "--stop", "1.5", "--json"))
    assert (trial["member"], trial["measured"]) == (proposal["member"], 0.4)
    assert following["proposal"] == 2
    assert "finite" in adapt("--measured", "inf", code=2).stderr
    assert objects(adapt("--json")) == [following]


@pytest.mark.parametrize(
    ("given", "message"),
    [
        (("--damage", "D lost"), "A, B, C"),
        ((*LOST, "--measure", "speed"), "unknown measure"),
        (("--visible",), "--damage"),
        (("--physics", "--interactive"), "cannot be combined"),
        (("--interactive", "--name", "../up"), "name"),
    ],
)
def test_a_mistake_gets_one_message(adapt, given, message):
    error = adapt(*given, code=2).stderr
    assert message in error


def test_runs_without_an_archive_and_bodies_without_damage_are_refused(
    gaitsim, puppet_file, tmp_path
):
    gaitsim("run", puppet_file, "--workers", 1)
    assert "not an atlas" in gaitsim("adapt", "puppet", *LOST, code=2).stderr
    puppet_file.write_text(
        puppet_file.read_text().partition("[search]")[0]
        + '[search]\nplugin = "map-elites"\naxes = { reach = [-3, 3] }\ncells = 5\n'
    )
    gaitsim("run", puppet_file, "--workers", 1, "--out", "whole")
    done = gaitsim("adapt", "whole", *LOST, "--measure", "reach", code=2)
    assert "cannot be damaged" in done.stderr
    assert (
        "no twin in rigid-body physics"
        in gaitsim("adapt", "whole", *LOST, "--physics", code=2).stderr
    )
    assert not [*tmp_path.rglob("adaptations/*")], "nothing was evaluated before"


def foreign(stored):
    stored["trials"][1]["member"] = 10**9


def repeated(stored):
    stored["trials"][1]["member"] = stored["trials"][0]["member"]


def infinite(stored):
    stored["trials"][1]["values"] = [float("nan")]


def empty(stored):
    stored["trials"][1]["values"] = []


def endless(stored):
    stored["trials"] = [{**stored["trials"][0], "number": number} for number in range(1, 1002)]


def escaping(stored):
    stored["measure"] = stored["damage"][0] = "\x1b]0;owned\x07"


def test_a_hostile_file_is_refused_and_nothing_outside_changes(adapt, atlas, tmp_path):
    given = (*LOST, "--trials", "3", "--stop", "1.5")
    adapt(*given)
    file, outside = atlas / "adaptations/A-lost.json", tmp_path / "outside"
    data = file.read_bytes()
    for attack, replace in ATTACKS.items():
        if attack in ("mutated", "missing"):  # a flipped bit may give a valid number
            continue
        outside.mkdir()
        (outside / file.name).write_bytes(data)
        (outside / "file").write_bytes(b"mine")
        file.unlink()
        replace(file, data, outside)
        adapt(*given, code=0 if attack == "hard link" else 2)
        assert (outside / "file").read_bytes() == b"mine", attack
        assert (outside / file.name).read_bytes() == data, attack
        shutil.rmtree(outside)
        file.rmdir() if file.is_dir() and not file.is_symlink() else file.unlink()
        file.write_bytes(data)
    for change in (foreign, repeated, infinite, empty, endless, escaping):
        stored = json.loads(data)
        change(stored)
        file.write_text(json.dumps(stored))
        assert "\x1b" not in adapt(*given, code=2).stderr
    file.write_text("[" * 100_000)
    assert "is damaged" in adapt(*given, code=2).stderr


def test_python_gives_the_same_trials_and_accepts_a_function_for_a_robot(adapt, atlas):
    *trials, _ = objects(adapt(*LOST, "--trials", "4", "--stop", "1.5", "--json"))
    run = gs.load(atlas)
    adaptation = gs.adapt(run, ["A lost"], trials=4, stop=1.5)
    made = [(trial.member, trial.measured) for trial in adaptation]
    assert made == [(trial["member"], trial["measured"]) for trial in trials]
    assert adaptation.best.measured == max(measured for _, measured in made)
    assert adaptation.gait.member.number == adaptation.best.member

    def robot(individual):
        return individual.measures["forward"] - 1

    first = next(gs.adapt(run, robot=robot, name="mine"))
    continued = gs.adapt(run, robot=robot, name="mine")
    assert continued.trials == (first,)
    assert first.measured == pytest.approx(first.expected - 1)
    by_hand = gs.adapt(run, stop=1.5)
    assert by_hand.record(first.measured) == first
    with pytest.raises(gs.GaitsimError, match="finite"):
        by_hand.record("far")
    with pytest.raises(gs.GaitsimError, match="robot"):
        gs.adapt(run, physics=True, robot=robot)


def test_two_processes_do_not_overwrite_each_others_trials(atlas):
    run = gs.load(atlas)
    one, other = (gs.adapt(run, name="mine") for _ in range(2))
    first = one.record(1.0)
    with pytest.raises(gs.GaitsimError, match="another process"):
        other.record(2.0)
    assert other.trials == ()
    continued = gs.adapt(run, name="mine")
    assert continued.trials == (first,)
    assert continued.record(2.0).number == 2
    assert gs.adapt(run, name="mine", fresh=True).trials == ()


@pytest.mark.slow
def test_a_report_covers_all_leg_losses_and_continues(adapt, atlas, tmp_path):
    given = ("--report", "losses", "--pairs", "--trials", 3, "--stop", 2)
    assert "**2 legs, median of 3**" in adapt(*given).stdout
    folder = tmp_path / "losses"
    report = gs.adaptation_report(
        gs.load(atlas), folder, pairs=True, settings=AdaptationSettings(3, stop=2.0)
    )
    assert [case.name for case in report.cases] == ["A", "B", "C", "A + B", "A + C", "B + C"]
    one = report.cases[0]
    alone = [*gs.adapt(gs.load(atlas), ["A lost"], trials=3, stop=2.0)]
    assert list(one.trials) == alone
    assert report.best == pytest.approx(np.sin(gs.load(atlas).members.genomes).sum(1).max())
    rows = (folder / "trials.csv").read_text().splitlines()
    assert len(rows) == 1 + 2 * sum(len(case.trials) for case in report.cases)
    assert {"kept.svg", "pairs.svg", "report.md"} <= {file.name for file in folder.iterdir()}
    file = folder / "report.json"
    made = file.read_bytes()
    kept = json.loads(made)
    kept["cases"] = kept["cases"][1:3]
    file.write_text(json.dumps(kept))
    gs.adaptation_report(
        gs.load(atlas), folder, pairs=True, settings=AdaptationSettings(3, stop=2.0)
    )
    assert file.read_bytes() == made
    assert "different options" in adapt(*given, "--kappa", 1, code=2).stderr
    file.write_text("{}")
    assert "is damaged" in adapt(*given, code=2).stderr
    assert "leg losses" in adapt("--report", "losses", *LOST, code=2).stderr
    assert "needs --report FOLDER" in adapt("--pairs", code=2).stderr
