"""`gaitsim verify`: its output, JSON and exit codes."""

import json
from pathlib import Path

import pytest

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
    assert lines[:2] == ["runs/puppet: identical", "5 of 5 generations evolved again: 1 to 5"]
    assert lines[-2].startswith("not known to be portable")
    assert lines[-1] == "same versions and processor as on this machine"
    files = {line.split()[0] for line in lines[3:-2]}
    assert files == {path.name + "/" * path.is_dir() for path in run.iterdir()} - OTHERS
    done = gaitsim("verify", "puppet", "--all", "--workers", 1)
    assert done.stdout.splitlines() == lines
    assert done.stderr == ""


OTHERS = {"exports/", ".lock", ".lock-owner"}


def test_a_different_run_exits_with_1_and_names_file_and_generation(gaitsim, run):
    change_history(run)
    lines = gaitsim("verify", "puppet", code=1).stdout.splitlines()
    assert lines[0] == "runs/puppet: different"
    assert lines[1].startswith("  generation 3: checksums.bin: does not fit")
    assert lines[2].startswith("  generation 3: history.csv: mean is 0.5, but ")
    (run / "population.previous.pickle").write_bytes(b"")
    (run / "provenance.json").unlink()
    found = json.loads(gaitsim("verify", "puppet", "--json", code=1).stdout)
    assert found["identical"] is False
    assert {one["generation"] for one in found["differences"]} == {0, 3}
    answer = gaitsim("verify", "puppet", code=1).stdout
    assert "the run does not record the software versions" in answer


def test_another_processor_is_named_before_the_verdict_and_the_difference_after_it(
    gaitsim, monkeypatch
):
    options = ("--set", "evolution.generations=2", "--set", "evolution.population=4")
    with monkeypatch.context() as patch:
        patch.setattr(machine, "ITERATIONS", 19)  # as if the engine rounded differently
        gaitsim("run", "walker", *options, "--workers", 1)
    lines = gaitsim("verify", "walker", code=1).stdout.splitlines()
    assert lines[0] == "runs/walker: different"
    path = Path("runs/walker/provenance.json")
    path.write_text(path.read_text().replace('"processor": "', '"processor": "an older '))
    lines = gaitsim("verify", "walker", code=1).stdout.splitlines()
    assert lines[0].startswith("computed on another kind of machine; the results are engine-bound")
    assert lines[1] == "runs/walker: different"
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


def test_invalid_options_exit_with_2(gaitsim, run):
    assert "there is no run 'nothing'" in gaitsim("verify", "nothing", code=2).stderr
    assert "only adaptations" in gaitsim("verify", "puppet", "--atlas", "puppet", code=2).stderr


def test_ctrl_c_stops_it(gaitsim, run, monkeypatch):
    def stop(*_):
        raise KeyboardInterrupt

    monkeypatch.setattr("gaitsim.storage.verification.evolve_again", stop)
    done = gaitsim("verify", "puppet", "--all", code=130)
    assert (done.stdout, done.stderr) == ("", "")
