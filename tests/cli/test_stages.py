"""Training in stages, and starting from a saved individual, on the command line."""

import json

import pytest

CLIMB = ("--set", "fitness.plugin=puppet-climb", "--set", "search.elites=1")


@pytest.fixture(autouse=True)
def installed(climb):
    """Install a second fitness for puppets."""


@pytest.fixture
def plain_run(finished):
    """A run of five generations."""
    return finished


def test_a_stage_is_shown_in_plain_lines(gaitsim, plain_run):
    done = gaitsim("resume", "puppet", *CLIMB, "--generations", 8)
    assert done.stderr == ""
    lines = done.stdout.splitlines()
    assert lines[:2] == [
        "run runs/puppet",
        "stage 2, from generation 6: fitness.plugin: puppet-reach, now puppet-climb; "
        "search.elites: 2, now 1",
    ]
    assert lines[2].startswith("generation 6/8")
    champion = next(line for line in lines if line.startswith("score = "))
    assert "height" in champion
    assert "price" not in champion
    assert "stage" not in gaitsim("resume", "puppet", "--generations", 9).stdout


def test_a_stage_is_shown_as_json(gaitsim, plain_run):
    done = gaitsim("resume", "puppet", *CLIMB, "--generations", 8, "--json")
    begun, *rows, summary = map(json.loads, done.stdout.splitlines())
    assert (begun["stage"], begun["first"], len(begun["changes"])) == (2, 6, 2)
    assert [(row["generation"], row["stage"]) for row in rows] == [(6, 2), (7, 2), (8, 2)]
    assert {"height", "mean:height", "lower quartile", "upper quartile"} <= rows[0].keys()
    assert "price" not in rows[0]
    assert set(summary["terms"]) == {"height", "reach"}
    shown = json.loads(gaitsim("show", "puppet", "--json").stdout)
    assert shown["stages"] == [
        {"stage": 1, "first": 1, "last": 5, "changes": []},
        {"stage": 2, "first": 6, "last": 8, "changes": begun["changes"]},
    ]
    assert (shown["pending"], shown["start"]) == ([], None)
    assert shown["champion"]["generation"] >= 6
    assert shown["champion"]["score"] == max(row["best"] for row in rows)


def test_a_run_starts_from_a_saved_individual(gaitsim, plain_run, puppet_file, tmp_path):
    champion = json.loads(gaitsim("show", "puppet", "--json").stdout)["champion"]
    gaitsim("run", puppet_file, "--from", "puppet", "--seed", 8, "--out", "a")
    gaitsim("run", puppet_file, "--from", plain_run, "--seed", 8, "--out", "b")
    number = champion["generation"]
    gaitsim("run", puppet_file, "--from", f"puppet@{number}", "--seed", 8, "--out", "c")
    gaitsim("run", puppet_file, "--from", "a/start.pickle", "--seed", 8, "--out", "d")
    prints = {gaitsim("show", run, "--fingerprint").stdout for run in "abcd"}
    assert len(prints) == 1
    shown = json.loads(gaitsim("show", "a", "--json").stdout)
    assert shown["start"] == {"generation": number, "score": champion["score"]}
    assert shown["champion"]["score"] >= champion["score"]
    assert f"individual of generation {number}" in gaitsim("show", "a").stdout
