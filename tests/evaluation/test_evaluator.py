import os
import sys

import numpy as np
import pytest
from in_turn import InTurn

from gaitsim.errors import GaitsimError, PluginError
from gaitsim.evaluation import Evaluator, evaluate, evaluator as module
from gaitsim.evaluation.chunking import Scheduler
from gaitsim.evaluation.executors import Executor
from gaitsim.evolution import first_population
from gaitsim.experiment import load_experiment


@pytest.fixture
def installed(monkeypatch, puppets):
    """Puppets are installed for worker processes, too."""
    monkeypatch.setenv("PYTHONPATH", os.path.dirname(puppets.__file__), os.pathsep)  # noqa: PTH120


def assert_same(one, other):
    assert one.scores.tobytes() == other.scores.tobytes()
    assert list(one.terms) == list(other.terms)
    for part, same in ((one.terms, other.terms), (one.values, other.values)):
        for name, values in part.items():
            assert values.tobytes() == same[name].tobytes()
    assert one.reasons == other.reasons


@pytest.mark.parametrize("workers", [2, 3, 50])
@pytest.mark.parametrize("population", [2, 7, 100])
def test_threads_give_the_same_bits_as_none(workers, population):
    experiment = load_experiment("spider-recurrence", {"evolution.population": population})
    genomes = first_population(experiment)
    genomes.setflags(write=False)
    with Evaluator(experiment, 1) as one, Evaluator(experiment, workers) as many:
        many.prepare()
        for _ in range(8):  # in all ways of dividing the population
            assert_same(one.evaluate(genomes), many.evaluate(genomes))


def test_the_quickest_way_to_divide_a_population_is_chosen_by_measurement():
    ways, seconds = module._Ways(2), {(2, 100): 3.0, (1, 100): 2.0, (2, 200): 5.0, (1, 200): 4.0}
    seconds |= {(2, 50): 7.0, (1, 50): 6.0}
    chosen = []
    for _ in range(module.AGAIN - 1):
        chosen.append(ways.choose(300))
        ways.learn(300, chosen[-1], seconds[chosen[-1]] / 1000)
    assert set(chosen[:6]) == set(seconds)
    assert set(chosen[6:]) == {(1, 100)}
    seconds[1, 100] = 9.0  # another program slows it down for good
    for _ in range(10 * module.AGAIN):
        chosen.append(ways.choose(300))
        ways.learn(300, chosen[-1], seconds[chosen[-1]] / 1000)
    assert chosen[-1] == (2, 100)
    ways.learn(9, ways.choose(9), 2 * module.LONG)
    assert {ways.choose(9) for _ in range(100)} == {(2, 100)}


def test_no_chunk_is_empty_and_none_outgrows_the_cache(puppet, puppets, monkeypatch):
    monkeypatch.setattr(puppets.Puppet, "threads", True)
    sizes = []

    def evaluated(experiment, genomes, **_):
        sizes.append(len(genomes))
        return evaluate(experiment, genomes)

    monkeypatch.setattr(module, "evaluate", evaluated)
    for population, workers in [(5, 8), (64, 1), (64, 2), (65, 1), (65, 2), (1000, 3)]:
        sizes.clear()
        with Evaluator(puppet(), workers) as evaluator:
            assert len(evaluator.evaluate(np.zeros((population, 3))).scores) == population
        assert sum(sizes) == population
        assert 0 < min(sizes) <= max(sizes) <= module.IN_CACHE
        few = [size for size in sizes if size < module.IN_CACHE]  # the rest, shared equally
        assert len(few) <= workers
        assert np.ptp(few or [0]) <= 1


@pytest.fixture
def shared(monkeypatch):
    """Workers get every population, even if they are slower."""
    monkeypatch.setattr(Scheduler, "chunks", lambda self, individuals: min(individuals, 3))


def test_processes_give_the_same_bits_as_none(puppet, installed, shared):
    genomes = first_population(puppet("evolution.population=7"))
    with Evaluator(puppet(), 2) as evaluator:
        assert_same(evaluator.evaluate(genomes), evaluate(puppet(), genomes))


@pytest.fixture
def split(monkeypatch):
    """Sets the size of the parts of the worlds that tasks get."""

    def set_size(size):
        monkeypatch.setattr(
            Scheduler,
            "split_worlds",
            lambda self, individuals, worlds: [
                slice(first, first + size) for first in range(0, worlds, size)
            ],
        )

    return set_size


@pytest.mark.sampled
@pytest.mark.parametrize("combine", ["mean", "worst tenth"])
def test_chunks_and_parts_of_the_worlds_give_the_same_bits_as_none(
    puppet, split, monkeypatch, combine
):
    experiment = puppet(
        "organism.plugin=windy-puppet",
        "worlds.number=99",
        f"worlds.combine={combine}",
        "constraints.at_least.score=-3",
    )
    genomes = first_population(puppet("evolution.population=7"))
    genomes[2] = 2.0  # blown away in some worlds
    whole = evaluate(experiment, genomes)
    assert 2 in whole.reasons
    assert len(whole.reasons) < 7
    for size in (1, 10, 99):
        split(size)
        for chunks in (2, 3, 7):  # of one individual at last
            monkeypatch.setattr(Scheduler, "chunks", lambda self, count, chunks=chunks: chunks)
            with Evaluator(experiment, cluster=InTurn()) as evaluator:
                assert_same(evaluator.evaluate(genomes), whole)


SLOW = """
import os, time
from gaitsim.contracts import option
from gaitsim_puppets import Puppet
class Slow(Puppet):
    cost: float = option(0.0, "of moving an individual", unit="s", ge=0)
    def move(self, genomes):
        time.sleep(self.cost * len(genomes))
        return super().move(genomes)
"""


@pytest.fixture
def slow(puppet, installed, install, monkeypatch):
    folder = install("slow", SLOW, {"organism": {"slow": "Slow"}})
    monkeypatch.setenv("PYTHONPATH", str(folder), prepend=os.pathsep)
    return lambda cost: puppet("organism.plugin=slow", f"organism.cost={cost}")


@pytest.fixture
def chunks(monkeypatch):
    """Evaluates a population of puppets; returns how many chunks workers got, 1 for none."""
    counts, map_ = [], Executor.map

    def counted(executor, function, tasks, *more):
        if isinstance(tasks, list):
            counts.append(len(tasks))
        return map_(executor, function, tasks, *more)

    def evaluated(evaluator):
        counts.clear()
        evaluator.evaluate(np.zeros((40, 3)))
        return sum(counts) or 1

    monkeypatch.setattr(Executor, "map", counted)
    return evaluated


def test_cheap_bodies_are_not_shared_with_one_warning(puppet, chunks):
    told = []
    with Evaluator(puppet(), 2, told.append) as evaluator:
        evaluator.prepare()
        assert [chunks(evaluator) for _ in range(50)] == [1] * 50
    assert len(told) == 1
    assert told[0].startswith("2 workers would not be faster")


@pytest.mark.slow
def test_no_more_processes_start_than_there_are_cores(puppet, installed, shared, monkeypatch):
    monkeypatch.setattr(module, "cores", lambda: 3)
    genomes = first_population(puppet("evolution.population=7"))
    told = []
    with Evaluator(puppet(), 1000, told.append) as evaluator:
        assert evaluator.workers == 3
        assert_same(evaluator.evaluate(genomes), evaluate(puppet(), genomes))
    assert told == ["1,000 workers exceed the cores of this machine; 3 are used"]
    with Evaluator(puppet(), 1000, told.append, InTurn()) as evaluator:
        assert evaluator.workers == 1  # a cluster has what it has
    with Evaluator(puppet(), 3, told.append) as evaluator:
        assert evaluator.workers == 3
    assert len(told) == 1


def test_a_plugin_that_fails_in_a_worker_is_named(puppet, installed, shared):
    with Evaluator(puppet(), 2) as evaluator:
        with pytest.raises(PluginError, match=r"package gaitsim-puppets 1\.0") as error:
            evaluator.evaluate(np.zeros((4, 2)).astype(str))
        assert error.value.remedy
        # The workers are as good as new.
        assert evaluator.evaluate(np.zeros((4, 3))).scores.tolist() == [0, 0, 0, 0]


def test_a_worker_that_cannot_begin_says_why(puppet, capfd, monkeypatch, shared):
    experiment = puppet()
    monkeypatch.setattr(sys, "path", [path for path in sys.path if "puppets" not in path])
    with (
        Evaluator(experiment, 2) as evaluator,
        pytest.raises(GaitsimError, match="unknown organism plugin 'puppet'"),
    ):
        evaluator.evaluate(np.zeros((4, 3)))
    assert "Traceback" not in capfd.readouterr().err


@pytest.mark.sampled
@pytest.mark.parametrize("workers", [1, 2])
@pytest.mark.parametrize("size", [1, 4])
def test_the_share_of_a_population_that_is_scored_is_reported(
    puppet, installed, shared, split, workers, size
):
    split(size)
    experiment = puppet("organism.plugin=windy-puppet", "worlds.number=4")
    found = []
    with Evaluator(experiment, workers) as evaluator:
        evaluator.on_share = found.append
        evaluator.evaluate(np.zeros((9, 3)))
    assert found == sorted(set(found))
    # Worlds in this process; in others, three chunks in parts of the worlds.
    assert len(found) == (4 if workers == 1 else 3 * 4 / size)
    assert found[-1] == pytest.approx(1.0)


def test_a_failure_while_preparing_names_the_plugin(puppet, puppets, monkeypatch):
    monkeypatch.setattr(puppets.Reach, "terms", lambda self, motion: 1 / 0)
    with (
        Evaluator(puppet()) as evaluator,
        pytest.raises(PluginError, match=r"fitness 'puppet-reach'.* evaluating"),
    ):
        evaluator.prepare()


@pytest.mark.skipif(os.name == "nt", reason="needs limits of memory")
def test_too_little_memory_is_a_user_error(puppet, monkeypatch):
    import resource

    monkeypatch.setattr(resource, "getrlimit", lambda what: (500_000_000, -1))
    with Evaluator(puppet(), 1) as evaluator, pytest.raises(GaitsimError, match="only 500 MB"):
        evaluator.prepare()
    monkeypatch.setattr(resource, "getrlimit", lambda what: (resource.RLIM_INFINITY, -1))
    with Evaluator(puppet(), 1) as evaluator:
        evaluator.prepare()
