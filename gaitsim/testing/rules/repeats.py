"""Rules for the determinism of a body: repeated calls, other chunks, and threads."""

from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor

from gaitsim.contracts import Genomes, Motion, Organism
from gaitsim.testing.report import Finding, error
from gaitsim.testing.rules.bits import differing, rows, same


def repeated(body: Organism, genomes: Genomes, motion: Motion) -> Iterator[Finding]:
    """Check that motions do not depend on repetition, order or chunks, nor change genomes."""
    whole = rows(motion, range(len(genomes)))
    lent = genomes.copy()
    # Reading all channels computes those that are derived.
    again = rows(body.move(lent), range(len(genomes)))
    if not same(lent, genomes):
        yield error(
            "inputs",
            "unchanged genomes",
            "move() changes them",
            "work on a copy: genomes.copy()",
        )
    name = differing(whole, again)
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
    for how, chosen in orders.items():
        part = body.move(genomes[chosen])
        name = differing(rows(motion, chosen), rows(part, range(len(chosen))))
        if name:
            yield error(
                "chunks",
                "each individual's motion depends only on its own genome, bit for bit",
                f"{name} differs when individuals move {how}",
                "use no values of the whole population, such as its mean; note that a matrix "
                "product may round differently for another number of rows",
            )
            return
    if body.threads:
        yield from _threads(body, genomes, motion)


def _threads(body: Organism, genomes: Genomes, motion: Motion) -> Iterator[Finding]:
    everyone = range(len(genomes))
    with ThreadPoolExecutor(2) as pool:
        parts = pool.map(lambda _: rows(body.move(genomes.copy()), everyone), range(6))
    whole = rows(motion, everyone)
    name = next(filter(None, (differing(whole, part) for part in parts)), "")
    if name:
        yield error(
            "threads",
            "the same bits when two threads move populations concurrently, as 'threads' declares",
            f"{name} differs",
            "keep no state between calls, or remove 'threads = True'",
        )
