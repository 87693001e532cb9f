import os
import pickle
import signal
import sys
import time
from concurrent.futures import ProcessPoolExecutor
from functools import partial

import chores
import pytest

from gaitsim.errors import GaitsimError
from gaitsim.evaluation import Evaluator
from gaitsim.evaluation.executors import (
    MAX_ATTEMPTS,
    SerialExecutor,
    ThreadExecutor,
    WorkerLostError,
)
from gaitsim.evaluation.processes import ProcessExecutor, hide_main_module
from gaitsim.evaluation.serialized import SerializedExperiment

posix = pytest.mark.skipif(os.name == "nt", reason="needs signals")


@pytest.fixture(scope="module")
def processes():
    with ProcessExecutor(2) as executor:
        yield executor


@pytest.fixture(params=["here", "threads", "processes"])
def executor(request, processes):
    if request.param == "processes":
        yield processes
        return
    with SerialExecutor() if request.param == "here" else ThreadExecutor(2) as made:
        yield made


def test_results_come_in_the_tasks_order(executor):
    assert executor.map(chores.square, range(20)) == [number**2 for number in range(20)]
    assert executor.map(chores.square, []) == []
    assert dict(executor.each(chores.square, [3, 4])) == {0: 9, 1: 16}


def test_what_a_task_raises_is_raised_and_the_rest_goes_on(executor):
    with pytest.raises(ValueError, match="is too much"):
        executor.map(partial(chores.fail_at, 3), range(8))
    assert executor.map(partial(chores.fail_at, 3), range(3)) == [0, 1, 2]


def test_whoever_stops_iterating_drops_the_rest(executor):
    some = executor.each(chores.square, range(100))
    next(some)
    some.close()
    assert executor.map(chores.square, [5]) == [25]


def test_all_workers_work(processes):
    assert len(set(processes.map(chores.whose, range(6)))) == 2
    assert os.getpid() not in processes.map(chores.whose, range(2))


def marks(folder, number, count):
    for mark in range(count):
        (folder / f"{number}-{mark}").touch()


@posix
def test_the_task_of_a_killed_worker_is_done_again(tmp_path):
    marks(tmp_path, 1, MAX_ATTEMPTS - 1)
    marks(tmp_path, 3, 1)
    told = []
    with ProcessExecutor(2, told.append) as executor:
        assert executor.map(chores.die, [(n, str(tmp_path)) for n in range(6)]) == [*range(6)]
        assert len(told) == MAX_ATTEMPTS
        assert "a worker process died" in told[0]
        assert executor.map(chores.square, range(4)) == [0, 1, 4, 9]


@posix
def test_a_worker_that_is_killed_while_it_idles_is_replaced():
    told = []
    with ProcessExecutor(1, told.append) as executor:
        [worker] = executor.map(chores.whose, [0])
        os.kill(worker, signal.SIGKILL)
        [pool] = executor._idle
        while not pool._broken:
            time.sleep(0.01)
        assert executor.map(chores.square, [3, 4]) == [9, 16]
    assert told == ["a worker process died while it had nothing to do; it is replaced"]


def test_workers_that_cannot_begin_are_told_of_and_the_others_do_it(monkeypatch):
    told = []
    with ProcessExecutor(3, told.append) as executor:
        begin = ProcessPoolExecutor._spawn_process

        def few(pool):
            if len(executor._pools) > 2:
                raise OSError(24, "Too many open files")
            begin(pool)

        monkeypatch.setattr(ProcessPoolExecutor, "_spawn_process", few)
        assert executor.map(chores.square, range(6)) == [0, 1, 4, 9, 16, 25]
        assert executor.workers == 2
        [text] = told
        assert text.startswith("no more than 2 worker processes can begin: [Errno 24]")


def test_that_no_worker_can_begin_is_one_error(monkeypatch):
    def none(pool):
        raise RuntimeError("can't start new thread")

    monkeypatch.setattr(ProcessPoolExecutor, "_spawn_process", none)
    with (
        ProcessExecutor(2) as executor,
        pytest.raises(GaitsimError, match="can't start new thread"),
    ):
        executor.map(chores.square, range(6))


def test_ctrl_c_while_a_worker_begins_leaves_none(monkeypatch):
    executor = ProcessExecutor(1)
    submit = ProcessPoolExecutor.submit

    def interrupted(pool, *task):
        submit(pool, *task)
        raise KeyboardInterrupt

    monkeypatch.setattr(ProcessPoolExecutor, "submit", interrupted)
    with pytest.raises(KeyboardInterrupt):
        executor.map(chores.sleep_for, [500])
    [pool] = executor._pools
    [process] = pool._processes.values()
    executor.close()
    assert not process.is_alive()


def test_the_script_is_back_when_all_have_begun_their_workers():
    script, first, second = sys.modules["__main__"], hide_main_module(), hide_main_module()
    first.__enter__()
    second.__enter__()
    first.__exit__(None, None, None)
    assert sys.modules["__main__"] is not script
    second.__exit__(None, None, None)
    assert sys.modules["__main__"] is script


@posix
def test_a_task_that_kills_every_worker_is_given_up(tmp_path):
    marks(tmp_path, 1, MAX_ATTEMPTS)
    with ProcessExecutor(2) as executor:
        with pytest.raises(WorkerLostError, match="died 3 times over the same work"):
            executor.map(chores.die, [(n, str(tmp_path)) for n in range(3)])
        assert executor.map(chores.square, [6]) == [36]


@posix
def test_closing_does_not_wait_for_a_worker_that_is_stopped():
    with ProcessExecutor(1) as executor:
        [worker] = executor.map(chores.whose, [0])
        [pool] = executor._idle
        [process] = pool._processes.values()
        os.kill(worker, signal.SIGSTOP)
    assert not process.is_alive()


def test_closing_does_not_wait_for_what_was_dropped():
    with ProcessExecutor(2) as executor:
        some = executor.each(chores.sleep_for, [0.0, 1000.0])
        assert next(some) == (0, 0.0)
        [pool] = executor._busy.values()
        [process] = pool._processes.values()
    assert not process.is_alive()


def test_an_experiment_travels_as_its_text(puppet):
    experiment = puppet("seed=7")
    serialized = SerializedExperiment(experiment)
    assert serialized.experiment is experiment
    there = pickle.loads(pickle.dumps(serialized))
    assert there.experiment.to_toml() == experiment.to_toml()
    assert there.experiment is not experiment
    assert there.experiment is pickle.loads(pickle.dumps(serialized)).experiment  # made once


@pytest.mark.parametrize("workers", [1, 2])
def test_an_evaluator_does_other_work_with_its_experiment(puppet, workers):
    with Evaluator(puppet("seed=7"), workers) as evaluator:
        assert evaluator.map(chores.seeded, [1, 2, 3]) == [("puppet", 7, n) for n in (1, 2, 3)]


def test_workers_that_were_not_asked_for_begin_when_tasks_pay(puppet, monkeypatch):
    monkeypatch.setattr("gaitsim.evaluation.evaluator.cores", lambda: 2)
    with Evaluator(puppet()) as evaluator:
        assert {evaluator.map(chores.whose_process, [0, 0])[0] for _ in range(3)} == {os.getpid()}
        everyone = [evaluator.map(chores.whose_process, [0.7, 0.7])[0] for _ in range(6)]
    assert everyone[0] == os.getpid()
    assert everyone[-1] != os.getpid()
