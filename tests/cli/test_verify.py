"""`gaitsim verify`: its output, JSON and exit codes."""

import json
from pathlib import Path

import pytest

import gaitsim as gs
from gaitsim_walker import machine


@pytest.fixture
def run(gaitsim, puppet_file, tmp_path, monkeypatch):
    """Evolve a run of five generations, each saved at once."""
    monkeypatch.setattr("gaitsim.storage.writer.PERIOD", 0.0)
    gaitsim("run", puppet_file)
    return tmp_path / "runs/puppet"


def change_history(run):
    """Change one number in the third generation of the history."""
    path = run / "history.csv"
    lines = path.read_text().splitlines()
    cells = lines[3].split(",")
    cells[lines[0].split(",").index("mean")] = "0.5"
    lines[3] = ",".join(cells)
    path.write_text("\n".join(lines) + "\n")


def test_an_identical_run_exits_with_0(gaitsim, run):
    lines = gaitsim("verify", "puppet").stdout.splitlines()
    assert lines[:2] == ["runs/puppet: identical", "all 5 generations evolved again"]
    assert lines[-2].startswith("not known to be portable")
    assert lines[-1] == "same versions and processor as on this machine"
    files = {line.split()[0] for line in lines[3:-2]}
    assert files == {path.name + "/" * path.is_dir() for path in run.iterdir()} - OTHERS
    done = gaitsim("verify", "puppet", "--all", "--workers", 1)
    assert done.stdout.splitlines() == lines
    assert done.stderr == ""


OTHERS = {"exports/", ".lock", ".lock-owner"}


def test_a_part_of_a_run_is_not_called_the_whole(gaitsim, run, monkeypatch):
    some = gaitsim("verify", "puppet", "--generations", "1,3").stdout
    assert "only the files compared: 2, 4 to 5" in some
    monkeypatch.setattr("gaitsim.storage.verification.QUICK", 0.0)
    lines = gaitsim("verify", "puppet").stdout.splitlines()
    assert lines[:4] == [
        "runs/puppet: identical in all that was compared",
        "2 of 5 generations evolved again: 1, 5",
        "only the best individual evaluated again: 2 to 4",
        "a forger could have changed the others: --all evolves them again",
    ]
    found = json.loads(gaitsim("verify", "puppet", "--json").stdout)
    assert (found["identical"], found["complete"]) == (True, False)
    assert [one["unknown"] for one in found["files"] if one["file"] == "history.csv"] == [
        "the other rows; seconds"
    ]


def test_a_different_run_exits_with_1_and_names_the_generation(gaitsim, run):
    change_history(run)
    lines = gaitsim("verify", "puppet", "--generations", "1,5", code=1).stdout.splitlines()
    assert lines[0] == "runs/puppet: different, first in generation 3"
    assert lines[1].startswith("  generation 3: its row or record of history.csv, bests.bin")
    lines = gaitsim("verify", "puppet", "--all", code=1).stdout.splitlines()
    assert lines[2].startswith("  generation 3: history.csv: mean is 0.5, but ")


def test_a_run_is_as_portable_as_its_least_portable_stage(gaitsim):
    with gs.evolve("spider", fitness=lambda motion: motion["pose"][:, -1, 0], population=4,
                   generations=2, out="runs/mixed") as search:  # fmt: skip
        assert len([*search]) == 2
    gaitsim("resume", "mixed", "--set", "fitness.plugin=spider-walk", "--generations", 3)
    assert "results: not known to be portable" in gaitsim("show", "mixed").stdout


def test_json_is_one_object(gaitsim, run):
    found = json.loads(gaitsim("verify", "puppet", "--generations", "2,5", "--json").stdout)
    assert found["identical"] is True
    assert (found["reproduced"], found["best_only"], found["differences"]) == ([5], [2], [])
    assert found["not_reproduced"] == [[1, 1], [3, 4]]
    assert found["provenance"][0]["fitness puppet-reach"] == "gaitsim-puppets 1.0"
    change_history(run)
    found = json.loads(gaitsim("verify", "puppet", "--json", code=1).stdout)
    assert [one["generation"] for one in found["differences"]] == [3]


@pytest.mark.parametrize("name", ["population.pickle", "population.previous.pickle"])
def test_a_damaged_checkpoint_exits_with_1_and_is_named(gaitsim, run, name):
    path = run / name
    path.write_bytes(path.read_bytes()[:50])
    found = json.loads(gaitsim("verify", "puppet", "--json", code=1).stdout)
    assert (found["identical"], found["differences"]) == (False, [])
    assert name in found["damaged"][0]
    # Reported together with the differences in the generations.
    change_history(run)
    lines = gaitsim("verify", "puppet", "--all", code=1).stdout.splitlines()
    assert lines[0] == "runs/puppet: different, first in generation 3"
    assert lines[1].strip() == found["damaged"][0]
    assert lines[2].startswith("  generation 3: ")


def test_a_changed_experiment_file_exits_with_1_and_names_the_options(gaitsim, run):
    path = run / "experiment.toml"
    path.write_text(path.read_text().replace("seed = 1", "seed = 77"))
    assert "seed is 77 in the file, 1 in the run" in gaitsim("verify", "puppet", code=1).stdout
    found = json.loads(gaitsim("verify", "puppet", "--json", code=1).stdout)
    assert (found["identical"], found["differences"]) == (False, [])
    assert found["experiment"] == [{"option": "seed", "file": 77, "used": 1}]


def test_a_run_without_checksums_is_different(gaitsim, run):
    (run / "checksums.bin").unlink()
    (run / "provenance.json").unlink()
    answer = gaitsim("verify", "puppet", code=1).stdout
    assert "runs/puppet: different, first in generation 1; 4 more generations differ" in answer
    assert "its checksum in checksums.bin is missing" in answer
    assert "the run does not record the software versions" in answer


def test_another_processor_is_named_before_the_verdict_and_the_difference_after_it(
    gaitsim, monkeypatch
):
    options = ("--set", "evolution.generations=2", "--set", "evolution.population=4")
    with monkeypatch.context() as patch:
        patch.setattr(machine, "ITERATIONS", 19)  # as if the engine rounded differently
        gaitsim("run", "walker", *options, "--workers", 1)
    lines = gaitsim("verify", "walker", code=1).stdout.splitlines()
    assert lines[0].startswith("runs/walker: different, first in generation 1")
    path = Path("runs/walker/provenance.json")
    path.write_text(path.read_text().replace('"processor": "', '"processor": "an older '))
    lines = gaitsim("verify", "walker", code=1).stdout.splitlines()
    assert lines[0].startswith("computed on another kind of machine; the results are engine-bound")
    assert lines[1].startswith("runs/walker: different, first in generation 1")
    [difference] = [line for line in lines if "largest difference of a best score" in line]
    assert float(difference.split()[-1]) > 0
    found = json.loads(gaitsim("verify", "walker", "--json", code=1).stdout)
    assert found["results"] == "engine-bound"
    assert found["score_difference"] > 0


def test_another_processor_does_not_matter_to_portable_results(gaitsim):
    gaitsim("run", "millipede", "--set", "evolution.generations=3")
    path = Path("runs/millipede/provenance.json")
    path.write_text(path.read_text().replace('"processor": "', '"processor": "an older '))
    lines = gaitsim("verify", "millipede").stdout.splitlines()
    assert lines[0] == "runs/millipede: identical"
    assert lines[-2].startswith("portable: ")
    assert lines[-1] == "same versions as on this machine"
    assert "results: portable: " in gaitsim("show", "millipede").stdout
    assert json.loads(gaitsim("show", "millipede", "--json").stdout)["results"].startswith(
        "portable"
    )
    assert "The score is portable" in gaitsim("share", "millipede").stderr


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (("nothing",), "there is no run 'nothing'"),
        (("puppet", "--generations", "6"), "no generation 6"),
        (("puppet", "--generations", "1-3"), "'1-3'"),
        (("puppet", "--all", "--generations", "1"), "--all and --generations cannot"),
    ],
)
def test_invalid_options_exit_with_2(gaitsim, run, arguments, words):
    assert words in gaitsim("verify", *arguments, code=2).stderr


def test_ctrl_c_stops_it(gaitsim, run, monkeypatch):
    def stop(*_):
        raise KeyboardInterrupt

    monkeypatch.setattr("gaitsim.storage.verification.reproduce_all", stop)
    done = gaitsim("verify", "puppet", "--all", code=130)
    assert (done.stdout, done.stderr) == ("", "")
