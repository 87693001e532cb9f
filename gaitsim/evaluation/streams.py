"""Random streams: each purpose in each generation has one, so that no generator is saved."""

from enum import IntEnum

import numpy as np


class Purpose(IntEnum):
    """Purpose of a random stream. Other numbers would change the results of every run."""

    INITIAL = 0  # the first genomes
    SELECTION = 1
    CROSSOVER = 2
    MUTATION = 3
    ASK = 4  # all further genomes
    TELL = 5
    STATE = 6  # the first state of a search
    WORLDS = 7  # those that individuals are evaluated in
    UNSEEN_WORLDS = 8  # those that a gait is judged in
    SCREENING = 9  # seeds of the repeats by which a study chooses cells
    CONFIRMATION = 10  # seeds of the repeats by which it tests them


def stream(seed: int, generation: int, purpose: Purpose, island: int = 0) -> np.random.Generator:
    """Return the random stream of one purpose in one generation, so that no state is saved.

    Each island has streams of its own; the first one has those of a search without islands.
    """
    return np.random.default_rng([seed, generation, purpose, *([island] if island else [])])
