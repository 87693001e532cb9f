"""`gaitsim share`, `verify CODE` and `run --from CODE`."""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import gaitsim as gs
from gaitsim.errors import ExperimentError
from gaitsim.sharing.challenge import Challenge, code_of, verify_challenge
from gaitsim.storage.provenance import read_provenance
from gaitsim.storage.snapshot import RunSnapshot

CODES = Path(__file__).with_name("codes")


@pytest.mark.parametrize("name", sorted(path.stem for path in CODES.iterdir()))
def test_codes_of_portable_bodies_hold_on_every_processor(name):
    checked = gs.verify((CODES / f"{name}.txt").read_text())
    assert checked.score == checked.challenge.score
    assert checked.challenge.experiment.portability.startswith("portable")
    # Versions may differ, but another processor does not count.
    assert not [text for text in checked.version_differences if "processor" in text]


@pytest.fixture
def code(gaitsim, finished):
    """The code of the champion of a run of five generations."""
    return gaitsim("share", "puppet").stdout.strip()


def forged(code, **changes):
    """Return a code with another content and a checksum that fits."""
    return replace(Challenge.read(code), **changes).code


def test_a_shared_score_is_true_to_the_bit(gaitsim, code, tmp_path):
    champion = gs.load("puppet").champion
    assert gs.load("puppet").share() == code
    checked = gs.verify(code)
    assert checked.identical
    assert (checked.score, checked.version_differences) == (champion.score, ())
    assert checked.terms == champion.terms
    played = gs.Challenge.read(code).individual
    assert np.array_equal(played.motion["reach"], champion.motion["reach"])
    shown = gaitsim("verify", f"“{code}”.").stdout
    assert "puppet: reproduced, the score is" in shown
    assert "not checked: that it is the best of generation 5, as the code's author st" in shown
    (tmp_path / "code.txt").write_text(f"\n{code[:20]}\n{code[20:]}\n")
    found = json.loads(gaitsim("verify", "code.txt", "--json").stdout)
    assert (found["identical"], found["claimed"]) == (True, champion.score)


def test_a_changed_digit_of_the_score_is_found(gaitsim, code):
    score = Challenge.read(code).score
    claimed = float(np.nextafter(score, np.inf))
    shown = gaitsim("verify", forged(code, score=claimed), code=1).stdout
    assert f"claimed: {claimed!r}" in shown
    assert f"here:    {score!r}" in shown
    assert "the claimed score is not the score of this individual" in shown
    found = json.loads(gaitsim("verify", forged(code, score=9.5), "--json", code=1).stdout)
    assert (found["identical"], found["claimed"], found["score"]) == (False, 9.5, score)


def test_other_versions_are_named(gaitsim, code):
    versions = Challenge.read(code).versions | {"numpy": "1.0", "processor": "abacus"}
    shown = gaitsim("verify", forged(code, score=0.5, versions=versions), code=1).stdout
    assert "numpy: 1.0 then" in shown
    assert "processor: abacus then" in shown
    assert ": reproduced" in gaitsim("verify", forged(code, versions=versions)).stdout
    assert "does not record" in gaitsim("verify", forged(code, versions={})).stdout


def test_damaged_codes_and_options_of_runs_end_with_2(gaitsim, code, tmp_path):
    assert "is damaged" in gaitsim("verify", code[:-1], code=2).stderr
    (tmp_path / "code.txt").write_text(code[:-1])
    found = json.loads(gaitsim("verify", "code.txt", "--json", code=2).stdout)
    assert (found["identical"], "is damaged" in found["error"]["what"]) == (None, True)
    assert "has no parts" in gaitsim("verify", code, "--all", code=2).stderr
    (tmp_path / "note.txt").write_text("hello")
    assert "note.txt" in gaitsim("verify", "note.txt", code=2).stderr


def test_a_plugin_that_is_not_installed_is_named(code):
    challenge = Challenge.read(code)
    text = challenge.text.replace('"puppet-reach"', '"leap"')
    gone = replace(challenge, text=text, versions={"fitness leap": "gaitsim-leap 2.0"})
    with pytest.raises(ExperimentError) as error:
        verify_challenge(gone)
    assert "leap" in str(error.value)
    assert "pip install gaitsim-leap==2.0" in str(error.value)


def test_a_run_starts_from_a_code(gaitsim, code, tmp_path):
    gaitsim("run", "--from", code, "--set", "evolution.generations=2", "--out", "a")
    gaitsim("run", "puppet.toml", "--from", "puppet", "--generations", 2, "--out", "b")
    one, other = RunSnapshot(tmp_path / "a"), RunSnapshot(tmp_path / "b")
    assert one.fingerprint() == other.fingerprint()
    assert one.start is not None
    assert one.start.score == Challenge.read(code).score
    assert one.experiment.name == "puppet"
    (tmp_path / "code.txt").write_text(code)
    gaitsim("run", "puppet.toml", "--from", "code.txt", "--generations", 2, "--out", "c")
    assert RunSnapshot(tmp_path / "c").fingerprint() == one.fingerprint()
    [origin] = read_provenance(tmp_path / "c")
    assert origin.first == 1


def test_a_run_records_the_true_score_of_a_forged_code(gaitsim, code, tmp_path):
    run = gaitsim("run", "--from", forged(code, score=77.0), "--generations", 1, "--out", "d")
    assert "claims the score 77.0" in run.stderr
    start = RunSnapshot(tmp_path / "d").start
    assert start is not None
    assert start.score == Challenge.read(code).score


def test_scores_over_worlds_and_of_members_are_true():
    worlds = {"worlds.number": 2, "worlds.redraw": 2, "evolution.population": 6}
    search = gs.evolve("walker", generations=3, set={**worlds, "organism.duration": 1.0})
    for generation in search:
        best = generation.best
        assert search.champion is not None
        made = replace(
            search.champion,
            score=float(generation.scores[best]),
            genome=generation.genomes[best],
            generation=generation.number,
        )
        assert gs.verify(code_of(made)).identical
