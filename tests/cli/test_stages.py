"""Training in stages, and starting from a saved individual, on the command line."""

import itertools
import json
import os
import random
import shutil
import time

import pytest
from waiting import until

from gaitsim.runs.snapshot import RunSnapshot

posix = pytest.mark.skipif(os.name == "nt", reason="needs POSIX signals")
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
    assert begun == {
        "stage": 2,
        "first": 6,
        "changes": [
            "fitness.plugin: puppet-reach, now puppet-climb",
            "search.elites: 2, now 1",
        ],
    }
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
    assert shown["evaluations"] == 9 * 6


def test_the_stages_of_a_run_are_shown(gaitsim, plain_run):
    before = gaitsim("show", "puppet").stdout
    assert "stage" not in before
    gaitsim("resume", "puppet", *CLIMB, "--generations", 8)
    text = (plain_run / "experiment.toml").read_text()
    (plain_run / "experiment.toml").write_text(text.replace("weight = 0.5", "weight = 0.25"))
    shown = gaitsim("show", "puppet").stdout
    lines = [line.split() for line in shown.splitlines()]
    assert ["stage", "generations", "best", "changed"] in lines
    assert any(line[:4] == ["1", "1", "to", "5"] for line in lines)
    assert any(line[:4] == ["2", "6", "to", "8"] for line in lines)
    assert "from generation 9: fitness.weight: 0.5, now 0.25" in shown
    assert "stopped" in gaitsim("runs").stdout.replace("finished", "stopped")
    done = gaitsim("resume", "puppet", "--generations", 9)
    assert "Warning: experiment.toml was changed after generation 8" in done.stderr
    assert "stage 3, from generation 9: fitness.weight: 0.5, now 0.25" in done.stdout


def test_a_run_that_reached_its_target_continues_with_a_different_fitness(
    gaitsim, puppet_file, tmp_path
):
    gaitsim("run", puppet_file, "--set", "evolution.target_score=0.1", "--generations", 50)
    row = json.loads(gaitsim("runs", "--json").stdout)
    assert row["state"] == "finished"
    path = tmp_path / "runs/puppet/experiment.toml"
    path.write_text(path.read_text().replace("price = 0.1", "price = 0.2"))
    assert json.loads(gaitsim("runs", "--json").stdout)["state"] == "stopped"
    gaitsim("resume", "puppet")
    assert json.loads(gaitsim("runs", "--json").stdout)["generation"] == row["generation"] + 1


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        (CLIMB, "no generation would be evolved with these changes: 5 generations are done"),
        (("--set", "evolution.population=9"), "population size of a run cannot change"),
        (
            ("--set", "organism.plugin=bit-puppet"),
            "has 3 genes of the kind 'real' of the body 'puppet'",
        ),
        (("--set", "fitness.plugin=climbing"), "unknown fitness plugin 'climbing'"),
        (("--set", "evolution.generations=3"), "is already at generation 5"),
        (("--set", "fitness"), "is not KEY=VALUE"),
        (("--set", "mutation.rate=\udcff"), "is not valid UTF-8"),
    ],
    ids=str,
)
def test_an_invalid_change_is_one_message_and_changes_nothing(gaitsim, plain_run, arguments, says):
    before = {path: path.read_bytes() for path in plain_run.rglob("*") if path.is_file()}
    done = gaitsim("resume", "puppet", *arguments, code=2)
    assert says in done.stderr
    assert done.stdout == ""
    for path, data in before.items():
        assert path.read_bytes() == data


@pytest.mark.slow
@posix
@pytest.mark.parametrize("workers", [pytest.param(1, marks=pytest.mark.slow), 2])
def test_a_repeatedly_killed_staged_run_is_bit_identical(
    gaitsim, start, puppet_file, tmp_path, workers
):
    gaitsim("run", puppet_file, "--set", "organism.pause=0.02", "--out", "whole")
    killed = tmp_path / "killed"
    shutil.copytree(tmp_path / "whole", killed)
    gaitsim("resume", "whole", *CLIMB, "--generations", 30)
    # Killed at start-up, during the re-evaluation, at the first row, and later.
    rng = random.Random(workers)
    moments = [rng.uniform(0.1, 1.5) for _ in range(6 if workers == 1 else 2)]
    for moment, row in itertools.chain(
        ((seconds, None) for seconds in moments), ((0, 6), (0, 8), (0, 20))
    ):
        begun = "puppet-climb" in (killed / "experiment.toml").read_text()
        change = () if begun else (*CLIMB, "--generations", 30)
        process = start("resume", killed, *change, "--workers", workers)
        if row is None:
            time.sleep(moment)
        else:
            until(lambda row=row: (killed / "history.csv").read_text().count("\n") >= row)
        process.kill()
        process.wait()
    begun = "puppet-climb" in (killed / "experiment.toml").read_text()
    gaitsim("resume", killed, *(() if begun else (*CLIMB, "--generations", 30)))
    one, other = RunSnapshot(killed), RunSnapshot(tmp_path / "whole")
    assert one.fingerprint() == other.fingerprint()
    assert [stage.last for stage in one.stages] == [5, 30]
    assert (killed / "bests.bin").read_bytes() == (tmp_path / "whole/bests.bin").read_bytes()


def test_spiders_in_stages_are_bit_identical_with_any_workers(gaitsim):
    spider = ("spider-recurrence", "--population", 10, "--generations", 4)
    stage = ("--set", "mutation.rate=0.3", "--set", "fitness.variance_scalar=1000")
    prints = set()
    for workers in (1, 2):
        gaitsim("run", *spider, "--out", f"w{workers}", "--workers", workers)
        gaitsim("resume", f"w{workers}", *stage, "--generations", 8, "--workers", 3 - workers)
        prints.add(gaitsim("show", f"w{workers}", "--fingerprint").stdout)
    assert len(prints) == 1


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


@pytest.mark.parametrize(
    ("reference", "says"),
    [
        ("nobody", "there is no run 'nobody'"),
        ("puppet@9", "has no generation 9"),
        ("puppet.toml", "cannot read puppet.toml as a checkpoint"),
        ("runs/puppet/population.pickle", "is not a valid champion"),
        ("bits", "the genome has 3 genes of the kind 'bit' of the body 'bit-puppet'"),
    ],
)
def test_an_incompatible_start_creates_no_run(
    gaitsim, plain_run, puppet_file, tmp_path, reference, says
):
    gaitsim("run", puppet_file, "--set", "organism.plugin=bit-puppet", "--out", "bits")
    done = gaitsim("run", puppet_file, "--from", reference, "--out", "new", code=2)
    assert says in done.stderr
    assert done.stdout == ""
    assert not (tmp_path / "new").exists()


@pytest.mark.slow
@posix
def test_a_run_from_an_individual_killed_at_the_start_is_bit_identical(
    gaitsim, start, plain_run, puppet_file, tmp_path
):
    arguments = (puppet_file, "--from", "puppet@2", "--set", "organism.pause=0.5")
    gaitsim("run", *arguments, "--generations", 2, "--out", "whole")
    process = start("run", *arguments, "--generations", 2, "--out", "killed")
    assert process.stdout.readline() == "run killed\n"
    process.kill()
    process.wait()
    assert "No generation is finished" in gaitsim("show", "killed").stdout
    gaitsim("resume", "killed")
    assert (
        RunSnapshot(tmp_path / "killed").fingerprint()
        == RunSnapshot(tmp_path / "whole").fingerprint()
    )
