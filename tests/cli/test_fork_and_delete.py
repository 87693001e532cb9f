"""`gaitsim fork` and `gaitsim runs --delete`."""

import json
import shutil
from functools import partial

import pytest

from gaitsim.evaluation import evaluate
from gaitsim.storage.creation import fork_run
from gaitsim.storage.snapshot import RunSnapshot
from gaitsim.storage.writer import RunWriter


@pytest.fixture
def run(gaitsim, puppet_file, tmp_path, once):
    """Evolve a run of five generations with champions."""
    return once(
        "run with champions",
        tmp_path / "runs/puppet",
        lambda: gaitsim("run", puppet_file, "--set", "evolution.fitness_threshold=0"),
    )


def files(path):
    return {item.relative_to(path) for item in path.rglob("*")}


def test_a_copy_starts_at_the_generation_of_the_run(gaitsim, run):
    (run / "exports/gait.csv").write_text("mine")
    done = gaitsim("fork", "puppet")
    assert done.stdout == "runs/puppet-2: a copy of runs/puppet at generation 5\n"
    assert done.stderr == "Continue with: gaitsim resume runs/puppet-2\n"
    copy = run.with_name("puppet-2")
    assert RunSnapshot(copy).fingerprint() == RunSnapshot(run).fingerprint()
    assert (copy / "bests.bin").read_bytes() == (run / "bests.bin").read_bytes()
    assert [*(copy / "champions").iterdir()]
    assert files(run) - files(copy) == {
        item.relative_to(run)
        for item in [
            run / ".lock",
            run / ".lock-owner",
            run / "population.previous.pickle",
            run / "exports/gait.csv",
        ]
    }


def test_a_changed_copy_equals_the_run_with_the_same_change(gaitsim, run):
    change = ("--set", "fitness.price=0.5", "--generations", 9)
    shown = json.loads(gaitsim("fork", run, "--out", "other", *change, "--json").stdout)
    assert shown == {"run": "other", "of": str(run), "generation": 5}
    before = RunSnapshot(run).fingerprint()
    gaitsim("resume", "other")
    assert RunSnapshot(run).fingerprint() == before
    gaitsim("resume", run, *change)
    assert (
        gaitsim("show", run, "--fingerprint").stdout
        == gaitsim("show", "other", "--fingerprint").stdout
    )


def test_a_run_that_is_being_written_is_copied_up_to_its_checkpoint(gaitsim, puppet, run):
    with RunWriter.open(run, generations=50) as writer:
        generations = writer.evolve(partial(evaluate, writer.experiment))
        next(generations)
        # As while a generation is being written: its records exist, but not its checkpoint.
        history, bests = (run / "history.csv"), (run / "bests.bin")
        history.write_bytes(history.read_bytes() + b"7,1,")
        bests.write_bytes(bests.read_bytes() + b"\0" * 40)
        copy = fork_run(run)
        assert RunSnapshot(copy).fingerprint() == RunSnapshot(run).fingerprint()
        assert RunSnapshot(copy).generation == 6
        assert (copy / "history.csv").read_text().count("\n") == 7
    assert (copy / "bests.bin").stat().st_size == 6 * 32


def test_runs_are_deleted_by_name_or_folder(gaitsim, run):
    shutil.copytree(run, run.parents[1] / "elsewhere")
    gaitsim("fork", run)
    done = gaitsim("runs", "--delete", "puppet-2", "--delete", "elsewhere", "--yes")
    assert done.stdout == "runs/puppet-2: in the trash\nelsewhere: in the trash\n"
    assert not (run.parents[1] / "elsewhere").exists()
    assert {path.name for path in run.parent.iterdir()} == {"puppet", ".trash"}
    shown = json.loads(gaitsim("runs", "--delete", "puppet", "--yes", "--json").stdout)
    assert shown["deleted"] == "runs/puppet"
    assert shown["trash"].startswith(f"{run.parent.resolve()}/.trash/")
    assert gaitsim("trash", "restore", "puppet").stdout == "runs/puppet: restored\n"
    done = gaitsim("runs", "--delete", "puppet", "--permanently", "--yes", "--json")
    assert json.loads(done.stdout) == {"deleted": "runs/puppet"}
    assert not run.exists()


def test_nothing_is_deleted_without_confirmation_or_if_a_run_is_missing(gaitsim, run, monkeypatch):
    assert "add --yes" in gaitsim("runs", "--delete", "puppet", code=2).stderr
    asked = ("--delete", "puppet", "--delete", "nobody", "--yes")
    assert "no run 'nobody'" in gaitsim("runs", *asked, code=2).stderr
    monkeypatch.setattr("sys.stdin.isatty", lambda: True, raising=False)
    monkeypatch.setattr("typer.confirm", lambda question: "runs/puppet " not in question)
    assert "Nothing was changed" in gaitsim("runs", "--delete", "puppet").stderr
    assert run.exists()
