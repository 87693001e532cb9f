import numpy as np
import pytest
from in_turn import InTurn

from gaitsim.evaluation.chunking import (
    GAIN,
    LONGEST,
    STARTUP,
    CostModel,
    Overhead,
    Scheduler,
    best_plan,
    split_indices,
)


class Workers(InTurn):
    def __init__(self, workers):
        self.workers = workers


FREE, FAST, SLOW = Overhead(0, 0), Overhead(0.0005, 0.0003), Overhead(0.02, 0.003)


def cost_model(first, more):
    made = CostModel()
    made.learn(1, first)
    made.learn(11, first + 10 * more)
    return made


def scheduler(first, more, overhead=FAST, workers=2, local=1, requested=True):
    made = Scheduler(local, Workers(workers), requested)
    made.cost_model, made.overhead = cost_model(first, more), overhead
    return made


def test_the_cost_model_goes_through_the_measurements():
    made = CostModel()
    made.learn(1, 3.0)
    made.learn(1, 2.0)
    assert made.seconds(10) == 2  # the least that it can be
    made.learn(11, 7.0)
    assert made.known
    assert [made.seconds(number) for number in (1, 11, 21)] == [2, 7, 12]
    made.learn(11, 17.0)
    assert made.more == 1.0  # between the last and what was before
    made.learn(11, 3.0)  # nothing makes it faster than it is
    assert made.more == pytest.approx(0.1)
    made.learn(5, 1.0)
    assert (made.first, made.more) == (1.0, 0.0)


def sizes(individuals, chunks, workers):
    return np.diff([0, *split_indices(individuals, chunks, workers), individuals]).tolist()


def test_chunks_get_smaller_round_by_round():
    assert sizes(100, 8, 2) == [20, 20, 15, 15, 10, 10, 5, 5]
    assert sizes(90, 3, 1) == [45, 30, 15]


@pytest.mark.parametrize("chunks", [2, 3, 7, 24, 48])
@pytest.mark.parametrize("individuals", [2, 3, 10, 100, 10_001])
def test_each_individual_is_in_one_chunk_and_no_chunk_is_empty(individuals, chunks):
    made = sizes(individuals, chunks, 4)
    assert sum(made) == individuals
    assert min(made) >= 1
    assert len(made) <= chunks


@pytest.mark.parametrize(
    ("first", "more", "overhead", "pays"),
    [
        (0.01, 0.01, FAST, True),
        (0.01, 0.01, SLOW, True),
        (1e-5, 1e-5, FAST, False),
        (1e-4, 1e-4, SLOW, False),
        (0.5, 1e-5, FAST, False),  # whole arrays at once: half of them takes as long
    ],
)
def test_workers_get_a_population_only_if_they_are_faster(first, more, overhead, pays):
    decided = scheduler(first, more, overhead)
    for _ in range(10):  # until there is no doubt
        chunks = decided.chunks(100)
    assert (chunks > 1) == pays
    if pays:
        assert best_plan(100, 2, cost_model(first, more), overhead).seconds < GAIN * (
            first + 99 * more
        )


def test_chunks_of_a_long_generation_take_seconds():
    plan = best_plan(1000, 2, cost_model(5.0, 5.0), Overhead(0.01, 0.001))  # 83 minutes
    assert 1000 / plan.chunks * 5.0 <= LONGEST
    whole_arrays = best_plan(1000, 2, cost_model(60.0, 0.01), Overhead(0.01, 0.001))
    assert whole_arrays.chunks == 2  # more would repeat the minute


def test_tasks_in_many_worlds_take_seconds():
    made = scheduler(70.0, 70.0)  # 1,000 worlds
    for individuals in (1, 3, 50):
        parts = made.split_worlds(individuals, 1000)
        sizes = [len(range(1000)[part]) for part in parts]
        assert [number for part in parts for number in range(1000)[part]] == [*range(1000)]
        assert max(sizes) == max(1, 1000 * LONGEST // (individuals * 70))
    assert len(scheduler(0.001, 0.001).split_worlds(100, 1000)) == 1
    assert len(Scheduler(1, Workers(2), True).split_worlds(100, 1000)) == 1  # not yet measured


def test_workers_start_once_they_would_have_saved_time():
    undecided = scheduler(0.01, 0.01, FREE, requested=False)  # 1 s alone, 0.52 s shared
    counts = [undecided.chunks(100) for _ in range(6)]
    saved = 1 - best_plan(100, 2, undecided.cost_model, FREE).seconds
    rests = int(STARTUP / saved)
    assert counts[:rests] == [1] * rests
    assert all(count > 1 for count in counts[rests:])
    assert scheduler(1.0, 1.0, requested=False).chunks(100) > 1  # at once, as it is so much


def batches(first, more, individuals, slow=(), **options):
    """A scheduler that timed batches, and their sizes; those in `slow` took twice as long."""
    made, sizes = Scheduler(1, Workers(2), requested=True), []

    def seconds(size):
        sizes.append(size)
        return (first + (size - 1) * more) * (2 if size in slow else 1)

    made.overhead = FAST
    made.time_batches(seconds, individuals, **options)
    return made, sizes


@pytest.mark.parametrize(
    ("first", "more", "individuals", "sizes"),
    [
        (0.01, 0.01, 100, [1]),  # workers would start when it is done
        (0.1, 0.1, 100, [1, 3]),
        (2.0, 2.0, 100, [1, 3]),
        (0.1, 0.1, 20, [1]),  # three of so few would not be a small part
        (0.001, 0.001, 2000, [1, 3, 24, 192]),  # one interruption outweighs a short batch
        (0.01, 0.01, 2000, [1, 3, 24]),
    ],
)
def test_a_body_that_loops_is_shared_after_a_small_batch(first, more, individuals, sizes):
    made, timed = batches(first, more, individuals)
    assert timed == sizes
    assert (made.chunks(individuals) > 1) == (len(sizes) > 1)


@pytest.mark.parametrize("first", [0.009, 0.05, 0.3, 1.5])
@pytest.mark.parametrize("individuals", [100, 500, 2000])
@pytest.mark.parametrize("part", [0, 1e-4])
def test_a_body_that_moves_whole_arrays_keeps_its_first_population(first, individuals, part):
    made, sizes = batches(first, first * part, individuals)
    assert len(sizes) <= 4
    assert made.chunks(individuals) == 1


def test_a_body_that_turns_out_to_loop_is_shared_after_its_first_population():
    made, _ = batches(0.1, 0.1, 20)
    assert made.chunks(20) == 1
    made.cost_model.learn(20, 2.0)
    assert made.chunks(20) > 1
