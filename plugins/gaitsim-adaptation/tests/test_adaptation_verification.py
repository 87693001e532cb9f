"""`verify` finds every change in the file of an adaptation."""

import json
import shutil

import numpy as np
import pytest

import gaitsim as gs
from gaitsim.errors import RunError
from gaitsim.storage.snapshot import RunSnapshot
from gaitsim.verifying import verify_files
from gaitsim_adaptation.adaptation import open_adaptation
from gaitsim_adaptation.prior import atlas_members, cache_key, write_intact

SETTINGS = {"trials": 5, "stop": 1.5}


@pytest.fixture(params=["simulation", "robot"])
def file(request, atlas):
    """An adaptation with five trials, simulated or measured on a robot."""
    run, place = RunSnapshot(atlas), request.param
    damage = ("A lost",) if place == "simulation" else ()
    adaptation = open_adaptation(run, damage, place=place, settings=SETTINGS, workers=1)
    while adaptation.proposal is not None:
        if place == "simulation":
            next(adaptation)
        else:
            adaptation.record(0.4 + 0.01 * adaptation.proposal.member % 1)
    assert len(adaptation.trials) == 5
    return adaptation.path


def verified(path, **options):
    return verify_files(str(path), workers=1, **options)


def test_an_untouched_adaptation_is_identical(file, gaitsim):
    verdict = verified(file)
    simulated = file.stem == "A-lost"
    assert verdict.identical, verdict.differences
    assert (len(verdict.again), verdict.complete) == ((5, True) if simulated else (0, False))
    (result,) = (one.result for one in verdict.files if one.file == file.name)
    assert result == ("same" if simulated else "cannot be known")
    lines = gaitsim("verify", file, "--workers", 1).stdout.splitlines()
    assert lines[0].endswith("json: identical" if simulated else "in all that was compared")
    kept = json.loads(gaitsim("verify", file, "--json", "--workers", 1).stdout)
    assert (kept["adaptation"], kept["identical"]) == (str(file), True)


def without_a_trial(record):
    del record["trials"][2]
    for number, one in enumerate(record["trials"], 1):
        one["number"] = number


def another_member(record):
    tried = {one["member"] for one in record["trials"]}
    record["trials"][3]["member"] = min({*range(1, 9)} - tried)


def changed(name, by=1e-9, at=3):
    def change(record):
        record["trials"][at][name] += by

    return change


def result(by, at):
    def change(record):
        record["trials"][at]["values"][0] += by

    return change


def set_to(name, value, inside=None):
    def change(record):
        (record[inside] if inside else record)[name] = value

    return change


TAMPERINGS = {
    "a trial deleted": without_a_trial,
    "another member proposed": another_member,
    "an expected value": changed("expected"),
    "a result, which later proposals follow from": result(0.5, 0),
    "the last result": result(1e-9, 4),
    "the damage": set_to("damage", ["B lost"]),
    "kappa": set_to("kappa", 500.0, "settings"),
    "another atlas": set_to("atlas", "0" * 64),
}
ON_A_ROBOT = {"the last result", "the damage"}
"""Statements of the user, which nothing can check."""


@pytest.mark.sampled
@pytest.mark.parametrize("name", TAMPERINGS)
def test_tampering_is_found(file, name):
    if file.stem == "robot" and name in ON_A_ROBOT:
        pytest.skip("a statement of the user")
    record = json.loads(file.read_text())
    TAMPERINGS[name](record)
    file.write_text(json.dumps(record))
    assert not verified(file).identical


def test_known_damage_and_changed_gaits_are_replayed(atlas):
    settings = {"trials": 3, "refine": 2, "repeats": 0}
    adaptation = open_adaptation(
        RunSnapshot(atlas), ("A lost",), place="robot", settings=settings, known=True, workers=1
    )
    while adaptation.proposal is not None:
        adaptation.record(0.3 + 0.1 * adaptation.proposal.member % 0.7)
    assert [bool(trial.genome) for trial in adaptation.trials][-2:] == [True, True]
    path = adaptation.path
    verdict = verified(path)
    assert verdict.identical, verdict.differences
    record = json.loads(path.read_text())
    changed = next(one for one in record["trials"] if one["genome"])
    changed["genome"][0] += 1e-9
    path.write_text(json.dumps(record))
    assert "with other genes" in str(verified(path).differences[0])
    changed["genome"].pop()
    path.write_text(json.dumps(record))
    with pytest.raises(RunError, match="a changed gait does not fit the body"):
        verified(path)
    with pytest.raises(RunError, match="a changed gait does not fit the body"):
        open_adaptation(RunSnapshot(atlas), ("A lost",), place="robot", workers=1)


def test_proposals_after_a_correction_are_not_compared(atlas):
    adaptation = open_adaptation(RunSnapshot(atlas), (), place="robot", settings=SETTINGS)
    for value in (0.4, 0.5, 0.6):
        adaptation.record(value)
    adaptation.correct(1, 0.9)
    assert verified(adaptation.path).identical


def test_a_robot_is_not_turned_into_a_simulation(file):
    record = json.loads(file.read_text())
    other = {"simulation": "robot", "robot": "simulation"}[record["place"]]
    file.write_text(json.dumps(record | {"place": other}))
    verdict = verified(file)
    assert not verdict.complete or not verdict.identical


def test_a_forged_map_of_the_intact_body_is_found(file, atlas):
    run = RunSnapshot(atlas)
    members = atlas_members(run)
    forged = np.linspace(0, 3, len(members.scores))
    key = cache_key(run, "forward", run.experiment_at(run.generation))
    write_intact(atlas, "forward", key, forged)
    assert any("intact-forward.bin" in str(one) for one in verified(file).differences)


def test_an_atlas_that_has_evolved_since_is_another_atlas(file, atlas, gaitsim):
    gaitsim("resume", "atlas", "--generations", 6, "--workers", 1)
    answer = gaitsim("verify", file, code=1).stdout
    assert "another atlas, or to an earlier generation" in answer


def test_a_file_elsewhere_needs_its_atlas(file, atlas, tmp_path, gaitsim):
    moved = shutil.copy(file, tmp_path / "moved.json")
    assert "--atlas spider-atlas" in gaitsim("verify", moved, code=2).stderr
    assert "identical" in gaitsim("verify", moved, "--atlas", "atlas", "--workers", 1).stdout
    assert "only adaptations" in gaitsim("verify", "atlas", "--atlas", "atlas", code=2).stderr
    assert gs.verify(file).identical
    assert "verify each of its files" in gaitsim("verify", "atlas", "--workers", 1).stdout
