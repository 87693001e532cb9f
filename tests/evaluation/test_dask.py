"""Dask on this machine: identical results, lost workers and lost schedulers."""

import gc
import os
import signal
import sys

import chores
import numpy as np
import pytest

from gaitsim.evaluation import Evaluator, dask as cluster, evaluate
from gaitsim.evaluation.chunking import PROCESS_OVERHEAD, Scheduler
from gaitsim.evaluation.dask import DaskExecutor
from gaitsim.evolution import first_population
from gaitsim.experiment import load_experiment

RUN = ("run", "millipede", "--population", 9, "--generations", 6)


def test_without_dask_the_error_says_how_to_install_it(gaitsim, monkeypatch, tmp_path):
    monkeypatch.setitem(sys.modules, "distributed", None)
    stderr = gaitsim(*RUN, "--dask", "local", code=2).stderr
    assert "pip install 'gaitsim[dask]'" in stderr
    assert not (tmp_path / "runs").exists()


@pytest.mark.parametrize("address", ["nowhere", "http://127.0.0.1:80", "inproc://1"])
def test_an_invalid_address_is_refused(gaitsim, tmp_path, address):
    stderr = gaitsim(*RUN, "--dask", address, code=2).stderr
    assert "cannot reach a Dask scheduler" in stderr
    assert "tcp://host:8786" in stderr
    assert not (tmp_path / "runs").exists()


def test_workers_and_the_address_of_a_cluster_exclude_each_other(gaitsim):
    stderr = gaitsim(*RUN, "--dask", "tcp://127.0.0.1:1", "--workers", 2, code=2).stderr
    assert "cannot be combined with" in stderr


distributed = pytest.importorskip("distributed")


def local(workers):
    return distributed.LocalCluster(
        n_workers=workers,
        threads_per_worker=1,
        host="127.0.0.1",
        dashboard_address="127.0.0.1:0",
        silence_logs=100,
        preload=["gaitsim.evaluation.preload"],
    )


@pytest.fixture(scope="module")
def told():
    return []


@pytest.fixture(scope="module")
def made(told):
    with DaskExecutor("local", 2, told.append) as executor:
        yield executor


@pytest.fixture
def address(made):
    return made.address


@pytest.fixture
def client(address):
    with distributed.Client(address, set_as_default=False) as client:
        yield client


@pytest.fixture
def shared(monkeypatch):
    """Workers get every population; what else is to happen then, by the number of it."""
    events = {}
    calls = []

    def chunks(self, individuals):
        calls.append(individuals)
        if len(calls) in events:
            events[len(calls)]()
        return min(3, individuals)

    monkeypatch.setattr(Scheduler, "chunks", chunks)
    monkeypatch.setattr(
        "gaitsim.evaluation.chunking.measure_overhead", lambda executor: PROCESS_OVERHEAD
    )
    return events


@pytest.fixture
def fingerprint(gaitsim):
    return lambda run: gaitsim("show", run, "--fingerprint").stdout


def test_results_come_in_the_tasks_order(made):
    assert made.workers == 2
    assert made.map(chores.square, range(7)) == [number**2 for number in range(7)]
    assert dict(made.each(chores.square, [3, 4])) == {0: 9, 1: 16}
    some = made.each(chores.square, range(10))
    next(some)
    some.close()
    with pytest.raises(TypeError):
        made.map(chores.square, [1, "a"])
    assert made.map(chores.square, [5]) == [25]


def test_a_cluster_gives_the_same_bits_as_none(made, shared):
    experiment = load_experiment("millipede", {"evolution.population": 11})
    genomes = first_population(experiment)
    with Evaluator(experiment, cluster=made) as evaluator:
        evaluator.prepare()
        there = evaluator.evaluate(genomes)
    here = evaluate(experiment, genomes)
    assert there.scores.tobytes() == here.scores.tobytes()
    assert [*there.terms] == [*here.terms]


def test_runs_are_the_same_everywhere(gaitsim, fingerprint, address, shared):
    gaitsim(*RUN, "--out", "whole", "--workers", 1)
    gaitsim(*RUN, "--out", "processes", "--workers", 2)
    gaitsim(*RUN, "--out", "cluster", "--dask", address)
    assert fingerprint("whole") == fingerprint("processes") == fingerprint("cluster")


@pytest.mark.slow
def test_a_run_is_the_same_when_a_worker_is_killed(gaitsim, fingerprint, address, client, shared):
    gaitsim(*RUN, "--out", "whole", "--workers", 1)
    pids = [*client.run(os.getpid).values()]
    shared[3] = lambda: os.kill(pids[0], signal.SIGKILL)
    gaitsim(*RUN, "--out", "hurt", "--dask", address)
    client.wait_for_workers(2, timeout=60)
    assert pids[0] not in client.run(os.getpid).values()
    assert fingerprint("hurt") == fingerprint("whole")


@pytest.fixture
def alarmed():
    """SIGALRM interrupts, as Ctrl-C does."""

    def interrupt(*_):
        raise KeyboardInterrupt

    before = signal.signal(signal.SIGALRM, interrupt)
    yield
    signal.signal(signal.SIGALRM, before)


@pytest.mark.skipif(os.name == "nt", reason="needs signals")
def test_closing_with_unfinished_tasks_prints_nothing(address, alarmed, caplog):
    with DaskExecutor(address) as another:
        signal.setitimer(signal.ITIMER_REAL, 0.3)
        with pytest.raises(KeyboardInterrupt):
            another.map(chores.sleep_for, [0.6] * 9)
    gc.collect()
    assert not caplog.records


@pytest.mark.slow
def test_packages_that_differ_are_named_with_both_versions(gaitsim, address, monkeypatch, tmp_path):
    versions = cluster.required_versions
    there = {**versions([]), "numpy": "0.1", "gaitsim-nowhere": "7.0"}
    monkeypatch.setattr(cluster, "required_versions", lambda experiments: there)
    stderr = gaitsim(*RUN, "--dask", address, code=2).stderr
    assert f"numpy is {np.__version__} on 3 processes such as the scheduler" in stderr
    assert "but 0.1 here" in stderr
    assert "gaitsim-nowhere is not installed on 3" in stderr
    assert "but 7.0 here" in stderr
    assert "pip install gaitsim-nowhere==7.0 numpy==0.1" in stderr
    assert gaitsim("show", "millipede", "--json").stdout.count('"generation": 0')


@pytest.mark.slow
def test_after_a_lost_scheduler_the_run_can_be_resumed(gaitsim, fingerprint, shared, monkeypatch):
    monkeypatch.setattr(cluster, "TIMEOUT", 2)
    gaitsim(*RUN, "--out", "whole", "--workers", 1)
    with local(1) as theirs:
        shared[4] = theirs.close
        stderr = gaitsim(*RUN, "--out", "cut", "--dask", theirs.scheduler_address, code=2).stderr
    assert "the connection to the Dask scheduler" in stderr
    assert "gaitsim resume cut" in stderr
    assert '"generation": 2' in gaitsim("show", "cut", "--json").stdout
    gaitsim("resume", "cut")
    assert fingerprint("cut") == fingerprint("whole")
