import json
import os
import pty
import re
import select
import signal

import pytest
from run_helpers import strict
from waiting import until

import gaitsim as gs
from gaitsim.console.printing import as_json
from gaitsim.storage.files.checkpoint import read_checkpoint, write_checkpoint

posix = pytest.mark.skipif(os.name == "nt", reason="needs POSIX signals")
SPIDER = ("spider-recurrence", "--population", 10)
SLOW = ("--set", "organism.pause=0.05", "--generations", 1000)


@pytest.fixture
def fingerprint(gaitsim):
    """Return a function that prints the fingerprint of a run, and nothing else."""

    def fingerprint(run):
        shown = gaitsim("show", run, "--fingerprint")
        assert shown.stderr == ""
        assert re.fullmatch(r"[0-9a-f]{64}\n", shown.stdout)
        return shown.stdout

    return fingerprint


def wait_for(path, generation=None):
    """Wait until a file exists, or until a history has reached a generation."""
    until(
        lambda: path.exists() and (generation is None or path.read_text().count("\n") > generation)
    )


def test_a_run_is_printed_in_plain_lines(program, puppet_file, tmp_path):
    done = program("run", puppet_file)
    assert done.stderr == ""
    assert "\x1b" not in done.stdout
    assert "\r" not in done.stdout
    lines = done.stdout.splitlines()
    assert lines[0] == "run runs/puppet"
    assert lines[1].startswith("generation 1/5  best ")
    assert any(line.startswith("generation 5/5") for line in lines)
    assert "runs/puppet: 5 generations are done" in lines
    assert any(line.startswith("  gaitsim resume runs/puppet --generations ") for line in lines)
    assert (tmp_path / "runs/puppet/experiment.toml").exists()


def test_json_is_one_line_per_generation_and_a_summary(gaitsim, puppet_file, fingerprint):
    done = gaitsim("run", puppet_file, "--json")
    assert done.stderr == ""
    *rows, summary = map(strict, done.stdout.splitlines())
    assert [row["generation"] for row in rows] == [1, 2, 3, 4, 5]
    assert [row["evaluations"] for row in rows] == [6, 12, 18, 24, 30]
    assert summary["run"] == "runs/puppet"
    assert summary["finished"] == "5 generations are done"
    assert summary["score"] == max(row["best"] for row in rows)
    assert summary["score"] == pytest.approx(sum(summary["terms"].values()))
    assert summary["fingerprint"] + "\n" == fingerprint("puppet")
    # A finished run prints only the summary.
    again = gaitsim("resume", "puppet", "--json")
    assert list(map(strict, again.stdout.splitlines())) == [summary]


FAILING = """
import numpy as np
from gaitsim_puppets import Reach
class Failing(Reach):
    def terms(self, motion):
        return {"reach": motion["reach"] * np.nan, "price": motion["reach"] * -np.inf}
"""


def test_a_run_in_which_all_fail_continues_and_reports_the_reason(
    gaitsim, puppet_file, install, monkeypatch
):
    folder = install("failing", FAILING, {"fitness": {"failing": "Failing"}})
    monkeypatch.setenv("PYTHONPATH", str(folder), prepend=os.pathsep)
    done = gaitsim("run", puppet_file, "--set", "fitness.plugin=failing")
    assert "Every individual failed" in done.stdout
    assert re.search(r"Individual 0: reach is nan, price is -?inf", done.stdout)
    done = gaitsim("resume", "puppet", "--generations", 7, "--json")
    *rows, summary = map(strict, done.stdout.splitlines())
    assert {row["best"] for row in rows} == {summary["score"]} == {None}
    assert strict(gaitsim("show", "puppet", "--json").stdout)["champion"] is None
    gaitsim("export", "puppet", code=2)


def test_spiders_are_bit_identical_when_resumed_and_with_any_workers(gaitsim, fingerprint):
    gaitsim("run", *SPIDER, "--generations", 12, "--out", "whole")
    gaitsim("run", *SPIDER, "--generations", 5, "--out", "parts", "--workers", 1)
    gaitsim("resume", "parts", "--generations", 8, "--workers", 3)
    gaitsim("resume", "parts", "--generations", 12)
    assert fingerprint("parts") == fingerprint("whole")
    gaitsim("run", *SPIDER, "--generations", 12, "--out", "other", "--seed", 1)
    assert fingerprint("other") != fingerprint("whole")


@pytest.mark.sampled
@posix
@pytest.mark.parametrize("workers", [1, pytest.param(2, marks=pytest.mark.slow)])
@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_an_interrupt_saves_the_run_and_prints_how_to_resume(
    gaitsim, start, puppet_file, tmp_path, number, workers
):
    run = tmp_path / "my run"
    process = start(
        "run", puppet_file, *SLOW, "--out", "my run", "--workers", workers, start_new_session=True
    )
    wait_for(run / "history.csv", 3)
    # As from a terminal: the workers receive the signal, too.
    os.killpg(process.pid, number)
    _, stderr = process.communicate(timeout=60)
    assert process.returncode == 130
    assert stderr.splitlines() == [
        "Stopping after this generation; press Ctrl-C again to stop at once.",
        "Stopped and saved. Continue with: gaitsim resume 'my run'",
    ]
    shown = strict(gaitsim("show", "my run", "--json").stdout)
    rows = (run / "history.csv").read_text().count("\n") - 1
    assert shown["generation"] == rows >= 3
    gaitsim("resume", "my run", "--generations", rows + 1)


ASLEEP = """
import time
from pathlib import Path
from gaitsim_puppets import Puppet
class Asleep(Puppet):
    def move(self, genomes):
        if len(genomes) > 1:  # not while it is prepared
            Path("moving").touch()
            time.sleep(1000)
        return super().move(genomes)
"""


@pytest.mark.sampled
@posix
@pytest.mark.parametrize("workers", [1, 2])
def test_a_second_interrupt_stops_immediately(
    start, puppet_file, install, monkeypatch, tmp_path, workers
):
    folder = install("asleep", ASLEEP, {"organism": {"asleep": "Asleep"}})
    monkeypatch.setenv("PYTHONPATH", str(folder), prepend=os.pathsep)
    arguments = ("--set", "organism.plugin=asleep", "--out", "run", "--workers", workers)
    process = start("run", puppet_file, *arguments)
    assert process.stdout.readline() == "run run\n"
    wait_for(tmp_path / "moving")
    process.send_signal(signal.SIGINT)
    assert "again to stop at once" in process.stderr.readline()
    process.send_signal(signal.SIGINT)
    _, stderr = process.communicate(timeout=60)
    assert process.returncode == 130
    where, how = stderr.splitlines()
    assert where.startswith("When the run was stopped, organism 'asleep' of package asleep 1.0")
    assert " was moving a population" in where
    assert how == "Stopped at the last saved generation. Continue with: gaitsim resume run"


SLEEPY = """
import time
from gaitsim_puppets import Puppet
class Sleepy(Puppet):
    def move(self, genomes):
        print("moving", len(genomes), flush=True)
        time.sleep(1000)
"""


@posix
def test_an_interrupt_during_preparation_stops_immediately(
    gaitsim, start, puppet_file, install, monkeypatch
):
    folder = install("sleepy", SLEEPY, {"organism": {"sleepy": "Sleepy"}})
    monkeypatch.setenv("PYTHONPATH", str(folder), prepend=os.pathsep)
    process = start("run", puppet_file, "--set", "organism.plugin=sleepy")
    assert process.stdout.readline() == "run runs/puppet\n"
    assert process.stderr.readline() == "moving 1\n"  # not among the results
    process.send_signal(signal.SIGINT)
    _, stderr = process.communicate(timeout=60)
    assert process.returncode == 130
    assert "Continue with: gaitsim resume runs/puppet" in stderr
    assert "Traceback" not in stderr
    assert "0/5" in gaitsim("runs").stdout


@posix
def test_workers_end_with_a_killed_program(start, puppet_file, tmp_path):
    process = start("run", puppet_file, *SLOW, "--workers", 2, "--out", "run")
    wait_for(tmp_path / "run/history.csv", 2)
    process.kill()
    process.wait()
    # The pipe closes when the last worker that holds it ends.
    assert select.select([process.stderr], [], [], 60)[0]
    while os.read(process.stderr.fileno(), 1000):
        assert select.select([process.stderr], [], [], 60)[0]


def test_a_different_version_of_a_plugin_is_used_on_request(gaitsim, finished):
    path = finished / "population.pickle"
    checkpoint = read_checkpoint(path)
    checkpoint.versions["organism puppet"] = "gaitsim-puppets 0.9"
    write_checkpoint(path, checkpoint)
    assert "--any-version" in gaitsim("resume", "puppet", "--generations", 8, code=2).stderr
    gaitsim("resume", "puppet", "--generations", 8, "--any-version")
    gaitsim("resume", "puppet", "--generations", 9)


@posix
def test_the_terminal_is_restored(start, puppet_file, tmp_path):
    ours, theirs = pty.openpty()
    streams = {"stdin": theirs, "stdout": theirs, "stderr": theirs}
    process = start("run", puppet_file, *SLOW, "--out", "run", **streams)
    os.close(theirs)
    wait_for(tmp_path / "run/history.csv", 3)
    process.send_signal(signal.SIGINT)
    seen = b""
    while select.select([ours], [], [], 60)[0]:
        try:
            data = os.read(ours, 10_000)
        except OSError:  # closed at the other end
            break
        if not data:
            break
        seen += data
    os.close(ours)
    assert process.wait() == 130
    assert "Traceback" not in seen.decode()
    assert "Continue with: gaitsim resume run" in " ".join(seen.decode().split())
    assert seen.count(b"\x1b[?25l") == seen.count(b"\x1b[?25h")  # the cursor is visible again


def test_a_run_over_worlds_ends_with_unseen_worlds(gaitsim):
    over = ("--set", "organism.duration=1", "--set", "worlds.number=2", "--workers", 1)
    run = ("run", "walker", "--population", 6, "--generations", 2, *over)
    found = json.loads(gaitsim(*run, "--json").stdout.splitlines()[-1])["unseen_worlds"]
    assert found["number"] == 10
    assert found["worst_tenth"] == found["worst"] <= found["median"]
    said = gaitsim("resume", "walker").stdout
    assert "In 10 unseen worlds: median" in said
    assert "analyse runs/walker --worlds 100" in said


def test_a_run_ends_with_the_checks_that_its_body_names(gaitsim, puppet_file):
    run = ("run", puppet_file, "--set", "organism.plugin=windy-puppet", "--generations", 2)
    found = json.loads(gaitsim(*run, "--json").stdout.splitlines()[-1])["checks"]
    assert [check["world"] for check in found["worlds"]] == [{"wind": 0.1}, {"wind": 9.0}]
    assert [check["passed"] for check in found["worlds"]] == [True, False]
    assert not found["holds"]
    assert found["depends_on"] == ["turns all joints"]
    resumed, analysed = gaitsim("resume", "puppet").stdout, gaitsim("analyse", "puppet")
    line = next(line for line in resumed.splitlines() if line.startswith("Does not hold"))
    assert line in analysed.stdout
    assert json.loads(gaitsim("analyse", "puppet", "--json").stdout)["checks"] == found
    checks = gs.load("runs/puppet").champion.checks()
    assert checks is not None
    assert json.loads(as_json(checks.to_dict())) == found
