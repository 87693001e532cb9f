import multiprocessing
import os
import pickle
import signal
import subprocess
import sys
from functools import partial
from multiprocessing.context import SpawnProcess

import chores
import pytest
from waiting import until

from gaitsim.errors import GaitsimError, PluginError
from gaitsim.evaluation import Evaluator
from gaitsim.evaluation.executors import MAX_ATTEMPTS, WorkerLostError
from gaitsim.evaluation.processes import ProcessExecutor, hide_main_module
from gaitsim.evaluation.serialized import SerializedExperiment

posix = pytest.mark.skipif(os.name == "nt", reason="needs signals")


@pytest.fixture(scope="class")
def processes():
    with ProcessExecutor(2) as executor:
        yield executor


class TestUse:
    def test_results_come_in_the_tasks_order(self, processes):
        assert processes.map(chores.square, range(20)) == [number**2 for number in range(20)]
        assert processes.map(chores.square, []) == []
        assert dict(processes.each(chores.square, [3, 4])) == {0: 9, 1: 16}

    def test_an_exception_of_a_task_leaves_the_workers_usable(self, processes):
        with pytest.raises(ValueError, match="is too much"):
            processes.map(partial(chores.fail_at, 3), range(8))
        assert processes.map(partial(chores.fail_at, 3), range(3)) == [0, 1, 2]

    def test_whatever_a_task_raises_or_returns_the_worker_goes_on(self, processes):
        with pytest.raises(EOFError, match="no more input"):
            processes.map(chores.exit_like_a_user, [0])
        with pytest.raises(Exception, match="pickle"):
            processes.map(chores.return_a_function, [0])
        with pytest.raises(Exception, match=r"Can't (pickle|get) local object"):
            processes.map(chores.square, [lambda: None])
        assert processes.map(chores.square, [5]) == [25]

    def test_a_plugin_does_not_end_its_worker(self, processes):
        with pytest.raises(PluginError, match="failed while moving: SystemExit"):
            processes.map(chores.leave, [0])


@pytest.mark.slow
def test_workers_that_nobody_closed_end_with_the_program(tmp_path):
    code = (
        "import chores; from gaitsim.evaluation.processes import ProcessExecutor\n"
        "executor = ProcessExecutor(1); print(executor.map(chores.square, [3]))"
    )
    folders = os.pathsep.join([os.path.dirname(chores.__file__), *sys.path])  # noqa: PTH120
    done = subprocess.run(
        [sys.executable, "-c", code], env=os.environ | {"PYTHONPATH": folders},
        capture_output=True, text=True, timeout=60, check=True,
    )  # fmt: skip
    assert (done.stdout, done.stderr) == ("[9]\n", "")


@posix
def test_workers_start_where_stderr_has_no_number_as_in_the_terminal_ui():
    code = (
        "import sys; from types import SimpleNamespace\n"
        "sys.stderr = SimpleNamespace(fileno=lambda: -1, flush=print)\n"
        "from gaitsim.evaluation.processes import block_signals\n"
        "with block_signals(): print('started')"
    )
    done = subprocess.run(
        [sys.executable, "-c", code], check=False, capture_output=True, text=True, timeout=60
    )
    assert "started" in done.stdout


def marks(folder, number, count):
    for mark in range(count):
        (folder / f"{number}-{mark}").touch()


@pytest.mark.slow
@posix
def test_another_worker_repeats_the_task_of_a_killed_one(tmp_path):
    marks(tmp_path, 1, MAX_ATTEMPTS - 1)
    marks(tmp_path, 3, 1)
    told = []
    with ProcessExecutor(2, told.append) as executor:
        assert executor.map(chores.die, [(n, str(tmp_path)) for n in range(6)]) == [*range(6)]
        assert len(told) == MAX_ATTEMPTS
        assert "a worker process died" in told[0]
        assert executor.map(chores.square, range(4)) == [0, 1, 4, 9]


@pytest.mark.slow
@posix
def test_a_worker_that_is_killed_while_idle_is_replaced():
    told = []
    with ProcessExecutor(1, told.append) as executor:
        [worker] = executor.map(chores.whose, [0])
        os.kill(worker, signal.SIGKILL)
        until(lambda: not multiprocessing.active_children())
        assert executor.map(chores.square, [3, 4]) == [9, 16]
    assert told == ["an idle worker process died; a new one replaces it"]


def test_if_no_worker_can_start_there_is_one_error(monkeypatch):
    def none(process):
        raise OSError(11, "Resource temporarily unavailable")

    monkeypatch.setattr(SpawnProcess, "start", none)
    with ProcessExecutor(2) as executor, pytest.raises(GaitsimError, match="temporarily"):
        executor.map(chores.square, range(6))


@posix
def test_ctrl_c_while_a_worker_starts_leaves_none(monkeypatch):
    executor, start = ProcessExecutor(1), SpawnProcess.start

    def interrupted(process):
        signal.raise_signal(signal.SIGINT)
        start(process)

    monkeypatch.setattr(SpawnProcess, "start", interrupted)
    with pytest.raises(KeyboardInterrupt):
        executor.map(chores.sleep_for, [500])
    assert multiprocessing.active_children()
    executor.close()
    assert not multiprocessing.active_children()


def test_the_main_module_is_back_when_all_have_started_their_workers():
    script, first, second = sys.modules["__main__"], hide_main_module(), hide_main_module()
    first.__enter__()
    second.__enter__()
    first.__exit__(None, None, None)
    assert sys.modules["__main__"] is not script
    second.__exit__(None, None, None)
    assert sys.modules["__main__"] is script


@posix
@pytest.mark.slow
def test_a_task_that_kills_every_worker_is_given_up(tmp_path):
    marks(tmp_path, 1, MAX_ATTEMPTS)
    with ProcessExecutor(2) as executor:
        with pytest.raises(WorkerLostError, match="died 3 times on the same task"):
            executor.map(chores.die, [(n, str(tmp_path)) for n in range(3)])
        assert executor.map(chores.square, [6]) == [36]


@posix
def test_closing_does_not_wait_for_a_worker_that_is_stopped():
    with ProcessExecutor(1) as executor:
        [worker] = executor.map(chores.whose, [0])
        os.kill(worker, signal.SIGSTOP)
        assert multiprocessing.active_children()
    assert not multiprocessing.active_children()


def test_an_experiment_is_pickled_as_its_toml(puppet):
    experiment = puppet("seed=7")
    serialized = SerializedExperiment(experiment)
    assert serialized.experiment is experiment
    there = pickle.loads(pickle.dumps(serialized))
    assert there.experiment.to_toml() == experiment.to_toml()
    assert there.experiment is not experiment
    assert there.experiment is pickle.loads(pickle.dumps(serialized)).experiment  # made once


@pytest.mark.sampled
@pytest.mark.parametrize("workers", [1, 2])
def test_an_evaluator_does_other_work_with_its_experiment(puppet, workers):
    with Evaluator(puppet("seed=7"), workers) as evaluator:
        assert evaluator.map(chores.seeded, [1, 2, 3]) == [("puppet", 7, n) for n in (1, 2, 3)]
