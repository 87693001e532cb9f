"""Rules for the determinism of a body: repeated calls, other chunks, and threads."""

from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor

from gaitsim.contracts import Genomes, Motion, Organism
from gaitsim.testing.report import Finding, error
from gaitsim.testing.rules.bits import first_difference, same, select_rows


def check_determinism(body: Organism, genomes: Genomes, motion: Motion) -> Iterator[Finding]:
    """Check that motions do not depend on repetition, order or chunks.

    Also check that `move` does not change the genomes.
    """
    whole = select_rows(motion, range(len(genomes)))
    argument = genomes.copy()
    # select_rows reads all channels, and so computes the derived channels.
    again = select_rows(body.move(argument), range(len(genomes)))
    if not same(argument, genomes):
        yield error(
            "inputs",
            "unchanged genomes",
            "move() changes them",
            "work on a copy: genomes.copy()",
        )
    name = first_difference(whole, again)
    if name:
        yield error(
            "determinism",
            "the same motion for the same genomes, bit for bit",
            f"{name} differs when the same genomes move a second time",
            "draw random numbers only from a seed that is an option, and keep no state",
        )
        return  # the next rules would fail for the same reason
    order = list(reversed(range(len(genomes))))
    orders = {"in reverse order": order, "alone": [2], "in a chunk of two": [4, 1]}
    for how, indices in orders.items():
        part = body.move(genomes[indices])
        name = first_difference(
            select_rows(motion, indices), select_rows(part, range(len(indices)))
        )
        if name:
            yield error(
                "chunks",
                "each individual's motion depends only on its own genome, bit for bit",
                f"{name} differs when individuals move {how}",
                "use no values of the whole population, such as its mean; a matrix product may "
                "round differently for a different number of rows",
            )
            return
    if body.threads:
        yield from _check_threads(body, genomes, motion)


def _check_threads(body: Organism, genomes: Genomes, motion: Motion) -> Iterator[Finding]:
    all_individuals = range(len(genomes))
    with ThreadPoolExecutor(2) as pool:
        parts = pool.map(
            lambda _: select_rows(body.move(genomes.copy()), all_individuals), range(6)
        )
    whole = select_rows(motion, all_individuals)
    name = next(filter(None, (first_difference(whole, part) for part in parts)), "")
    if name:
        yield error(
            "threads",
            "the same bits when two threads move populations concurrently, as 'threads' declares",
            f"{name} differs",
            "keep no state between calls, or remove 'threads = True'",
        )
