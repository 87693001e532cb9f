"""Rules for a fitness: its terms, and the channels that it reads."""

from collections.abc import Callable, Iterator

import numpy as np

from gaitsim.contracts import Array, Fitness, Motion, Organism
from gaitsim.registry import Entry
from gaitsim.testing.report import Finding, advice, error, reported
from gaitsim.testing.rules.bits import differing, same
from gaitsim.testing.rules.bodies import COUNT, moved_by, some_genomes
from gaitsim.testing.rules.partners import partner


class _Watched(Motion):
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


def fitness_rules(
    entry: Entry, fitness: Fitness, on_status: Callable[[str], None]
) -> Iterator[Finding]:
    """Check all rules for a fitness with its current options."""
    on_status("looking for a body with its channels")
    found = partner(entry, fitness)
    if found is None:
        yield advice(
            "needs",
            f"an installed body with the channels {', '.join(fitness.needs)}",
            "no such body; the terms were not checked",
            "correct 'needs', or install the package of a body",
        )
        return
    on_status(f"moving and evaluating {found[0]}")
    motion, watched = moved_by(*found), _Watched(moved_by(*found))
    terms: object = fitness.terms(watched)
    if (yield from reported(_terms(terms))):
        return
    assert isinstance(terms, dict)
    given = {name: np.array(term) for name, term in terms.items()}
    yield from _reading(fitness, watched)
    changed = next((name for name in motion if not same(motion[name], watched[name])), "")
    if changed:
        yield error(
            "inputs",
            "an unchanged motion",
            f"terms() changes the channel {changed}",
            "work on a copy: motion[…].copy()",
        )
    if not any(np.isfinite(sum(term[i] for term in given.values())) for i in range(COUNT)):
        yield advice(
            "finite values",
            f"a finite score for some of {COUNT} random individuals of {found[0].name}",
            "no finite score",
            "prevent overflow and division by 0",
        )
    yield from _repeats(fitness, found, given)


def _terms(terms: object) -> Iterator[Finding]:
    if not isinstance(terms, dict) or not terms:
        yield error(
            "terms",
            "terms() returns a dict with an array for each term",
            f"{terms!r:.60}",
            "return {'name of the term': array}",
        )
        return
    for name, term in terms.items():
        values = np.asarray(term)
        if not isinstance(name, str) or not name.isprintable() or not name:
            yield error("terms", "a printable name for each term", f"{name!r:.60}", "rename it")
        elif values.shape != (COUNT,) or values.dtype.kind not in "biuf":
            yield error(
                "shapes",
                f"{name}: real numbers, (population,) = ({COUNT},)",
                f"shape {values.shape}, dtype {values.dtype}",
                "reduce each individual's term to one number, for example with .sum(axis=1)",
            )


def _reading(fitness: Fitness, watched: _Watched) -> Iterator[Finding]:
    undeclared = sorted(watched.read - {*fitness.needs})
    if undeclared:
        yield error(
            "needs",
            "'needs' lists every channel that the fitness reads",
            f"also reads {', '.join(undeclared)}",
            f"needs = {(*fitness.needs, *undeclared)!r}",
        )
    unread = [name for name in fitness.needs if name not in watched.read]
    if unread:
        yield advice(
            "needs",
            "'needs' lists only channels that the fitness reads; bodies must have all of them",
            f"never reads {', '.join(unread)}",
            "remove them from 'needs'",
        )


def _repeats(
    fitness: Fitness, found: tuple[Entry, Organism], given: dict[str, Array]
) -> Iterator[Finding]:
    again = fitness.terms(moved_by(*found))
    name = differing(given, {name: np.array(term) for name, term in again.items()})
    if name:
        yield error(
            "determinism",
            "the same terms for the same motion, bit for bit",
            f"{name} differs in a second call",
            "use no random numbers, and keep no state between calls",
        )
        return
    body = found[1]
    genomes = some_genomes(body.genome_space())
    for chosen in ([2], [4, 1, 0]):
        part = fitness.terms(body.move(genomes[chosen]))
        name = differing(
            {name: term[chosen] for name, term in given.items()},
            {name: np.array(term) for name, term in part.items()},
        )
        if name:
            yield error(
                "chunks",
                "the same terms in any chunk, with values that depend only on the individual",
                f"{name} differs when individuals are evaluated in a chunk of {len(chosen)}",
                "use no values of the whole population, such as its best or its mean",
            )
            return
