"""Checks of a fitness: its terms, and the channels that it reads."""

from typing import Any

import numpy as np
import pytest

from gaitsim.plugin import Array, Entry, Fitness, Motion, Organism
from gaitsim_testing.finding import advise, require, require_unchanged
from gaitsim_testing.results import find_body
from gaitsim_testing.samples import COUNT, first_difference, same, sample_genomes, sample_motion

KINDS = ("fitness",)


class _RecordingMotion(Motion):
    """A motion that records which channels are read."""

    def __init__(self, motion: Motion) -> None:
        # The body's own arrays: a copy may have a different memory layout, which changes the last
        # bit of a sum.
        super().__init__(
            motion.frame_rate, {name: motion[name] for name in motion}, None, motion.failures
        )
        self.read: set[str] = set()

    def __getitem__(self, name: str) -> Array:
        self.read.add(name)
        return super().__getitem__(name)


@pytest.fixture(scope="session")
def fitness(plugin: Any) -> Fitness:
    """The fitness with its options."""
    assert isinstance(plugin, Fitness)
    return plugin


@pytest.fixture(scope="session")
def found(entry: Entry, fitness: Fitness) -> tuple[Entry, Organism]:
    """A body with the channels that the fitness reads."""
    found = find_body(entry, fitness)
    advise(
        found,
        f"no installed body has the channels {', '.join(fitness.needs)}; the terms are not checked",
        "an installed body with the channels in 'needs'",
        "correct 'needs', or install the package of a body",
    )
    if found is None:
        pytest.skip("no body has the channels")
    return found


@pytest.fixture(scope="session")
def terms(fitness: Fitness, found: tuple[Entry, Organism]) -> dict[str, Array]:
    """The terms of a few individuals, each of the right shape."""
    motion, recording = sample_motion(*found), _RecordingMotion(sample_motion(*found))
    terms: object = fitness.terms(recording)
    if not isinstance(terms, dict):
        terms = {}
    require(
        terms,
        "terms() does not return a dict with terms",
        "a dict with an array for each term",
        "return {'name of the term': array}",
    )
    for name, term in terms.items():
        values = np.asarray(term)
        require(
            isinstance(name, str) and name.isprintable() and name,
            f"a term has the name {name!r:.60}",
            "a printable name for each term",
            "rename the term",
        )
        require(
            values.shape == (COUNT,) and values.dtype.kind in "biuf",
            f"the term {name} has the shape {values.shape}, dtype {values.dtype}",
            f"real numbers, (population,) = ({COUNT},)",
            "reduce each individual's term to one number, for example with .sum(axis=1)",
        )
    given = {name: np.array(term) for name, term in terms.items()}
    _check_needs(fitness, recording.read)
    changed = next((name for name in motion if not same(motion[name], recording[name])), "")
    require_unchanged(not changed, "terms()", f"the channel {changed}")
    return given


def _check_needs(fitness: Fitness, read: set[str]) -> None:
    undeclared = sorted(read - {*fitness.needs})
    require(
        not undeclared,
        f"the fitness also reads {', '.join(undeclared)}",
        "every channel that the fitness reads is in 'needs'",
        f"needs = {(*fitness.needs, *undeclared)!r}",
    )
    unread = [name for name in fitness.needs if name not in read]
    advise(
        not unread,
        f"the fitness never reads {', '.join(unread)}",
        "'needs' lists only channels that the fitness reads; bodies must have all of them",
        "remove them from 'needs'",
    )


def test_terms(terms: dict[str, Array]) -> None:
    """The terms are valid, and some score is finite."""
    advise(
        any(np.isfinite(sum(term[i] for term in terms.values())) for i in range(COUNT)),
        "no finite score",
        f"a finite score for some of {COUNT} random individuals",
        "prevent overflow and division by 0",
    )


def test_determinism(
    fitness: Fitness, found: tuple[Entry, Organism], terms: dict[str, Array]
) -> None:
    """Terms do not depend on repetition or chunks."""
    again = fitness.terms(sample_motion(*found))
    name = first_difference(terms, {name: np.array(term) for name, term in again.items()})
    require(
        not name,
        f"{name} differs in a second call",
        "the same terms for the same motion, bit for bit",
        "use no random numbers, and keep no state between calls",
    )
    body = found[1]
    genomes = sample_genomes(body.genome_space())
    for rows in ([2], [4, 1, 0]):
        part = fitness.terms(body.move(genomes[rows]))
        name = first_difference(
            {name: term[rows] for name, term in terms.items()},
            {name: np.array(term) for name, term in part.items()},
        )
        require(
            not name,
            f"{name} differs when individuals are evaluated in a chunk of {len(rows)}",
            "the same terms in any chunk, with values that depend only on the individual",
            "use no values of the whole population, such as its best or its mean",
        )
