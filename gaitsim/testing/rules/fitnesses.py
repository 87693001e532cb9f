"""Rules for a fitness: its terms, and what it reads."""

from collections.abc import Callable, Iterator, Sequence

import numpy as np

from gaitsim.contracts import Array, Fitness, Motion, Organism
from gaitsim.registry import Entry
from gaitsim.testing.report import Finding, advice, error
from gaitsim.testing.rules.bits import differing, same
from gaitsim.testing.rules.bodies import COUNT, moved_by, some_genomes
from gaitsim.testing.rules.partners import partner


class _Watched(Motion):
    """A motion that notes which channels are read."""

    def __init__(self, motion: Motion) -> None:
        # The body's own arrays: a copy may lie in memory otherwise, and then sum up to another
        # last bit.
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
    """All rules for a fitness, as its options are."""
    on_status("looking for a body that it can judge")
    found = partner(entry, fitness)
    if found is None:
        yield advice(
            "needs",
            f"an installed body with the channels {', '.join(fitness.needs)}",
            "there is none, so that the terms were not looked at",
            "correct 'needs', or install the package of the body",
        )
        return
    on_status(f"evaluating {found[0]}, or that was still moving")
    motion, watched = moved_by(*found), _Watched(moved_by(*found))
    terms: object = fitness.terms(watched)
    problems = list(_terms(terms))
    yield from problems
    if problems:
        return
    assert isinstance(terms, dict)
    given = {name: np.array(term) for name, term in terms.items()}
    yield from _reading(fitness, watched)
    changed = next((name for name in motion if not same(motion[name], watched[name])), "")
    if changed:
        yield error(
            "inputs",
            "a motion as it was given",
            f"terms() changes the channel {changed}",
            "work on a copy: motion[…].copy()",
        )
    if not any(np.isfinite(sum(term[i] for term in given.values())) for i in range(COUNT)):
        yield advice(
            "finite values",
            f"a finite score for some of {COUNT} random individuals of {found[0].name}",
            "none has one",
            "guard what overflows or divides by 0",
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
                "bring each individual's term down to one number, as by .sum(axis=1)",
            )


def _reading(fitness: Fitness, watched: _Watched) -> Iterator[Finding]:
    untold = sorted(watched.read - {*fitness.needs})
    if untold:
        yield error(
            "needs",
            "every channel that is read named in 'needs'",
            f"reads {', '.join(untold)}, too",
            f"needs = {(*fitness.needs, *untold)!r}",
        )
    unread = [name for name in fitness.needs if name not in watched.read]
    if unread:
        yield advice(
            "needs",
            "only channels that are read in 'needs', as bodies without them are refused",
            f"never reads {', '.join(unread)}",
            "take them out",
        )


def _repeats(
    fitness: Fitness, found: tuple[Entry, Organism], given: dict[str, Array]
) -> Iterator[Finding]:
    again = fitness.terms(moved_by(*found))
    name = differing(given, {name: np.array(term) for name, term in again.items()})
    if name:
        yield error(
            "determinism",
            "the same terms for the same motion, to the bit",
            f"{name} differs the second time",
            "use no random numbers, and remember nothing between calls",
        )
        return
    body = found[1]
    genomes = some_genomes(body.genome_space())
    for chosen in ([2], [4, 1, 0]):
        part = fitness.terms(body.move(genomes[chosen]))
        name = differing(
            {name: _rows(term, chosen) for name, term in given.items()},
            {name: np.array(term) for name, term in part.items()},
        )
        if name:
            yield error(
                "chunks",
                "terms of the same names, in which an individual's depend on itself alone",
                f"{name} differs when individuals are judged in a chunk of {len(chosen)}",
                "use nothing of the whole population, such as its best or its mean",
            )
            return


def _rows(term: Array, chosen: Sequence[int]) -> Array:
    rows: Array = term[list(chosen)]
    return rows
