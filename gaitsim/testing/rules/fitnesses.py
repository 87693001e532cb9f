"""Rules for a fitness: its terms, and the channels that it reads."""

from collections.abc import Callable, Iterator
from contextlib import suppress

import numpy as np

from gaitsim import toml
from gaitsim.contracts import Array, Fitness, Motion, Organism
from gaitsim.errors import GaitsimError
from gaitsim.experiment.combination import compatible
from gaitsim.registry import EXPERIMENTS, Entry, entries, load_entry, plugin_errors
from gaitsim.registry.loading import read_preset
from gaitsim.registry.options import PLUGIN
from gaitsim.testing.report import Finding, advice, any_error, error
from gaitsim.testing.rules.bodies import COUNT, sample_genomes, sample_motion
from gaitsim.testing.rules.common import first_difference, same
from gaitsim.testing.rules.declared import build_plugin


def find_body(entry: Entry, fitness: Fitness) -> tuple[Entry, Organism] | None:
    """Return an installed body with the channels that the fitness reads; None if there is none.

    The order is: bodies of the fitness's own package, bodies of gaitsim, all others. A body that
    cannot be loaded is skipped.
    """
    for body, values in _candidates(entry):
        with suppress(GaitsimError, ValueError):
            model = load_entry(body)
            with plugin_errors(body, "validating its options"):
                organism = build_plugin(model, values)
            assert isinstance(organism, Organism)
            if compatible(type(fitness), organism.channels, None):
                return body, organism
    return None


def _candidates(entry: Entry) -> Iterator[tuple[Entry, dict[str, object]]]:
    bodies = {name: claims[0] for name, claims in entries("organism").items() if len(claims) == 1}
    # First the bodies of the package's own presets, as the channels may depend on their options.
    for name, claims in entries(EXPERIMENTS).items():
        if claims[0].package == entry.package:
            with suppress(GaitsimError, KeyError, TypeError, AttributeError):
                table = toml.parse(read_preset(name), name)
                section = dict(table["organism"])
                if table["fitness"][PLUGIN] == entry.name:
                    yield bodies[section.pop(PLUGIN)], section
    for body in sorted(
        bodies.values(),
        key=lambda body: (body.package != entry.package, body.package != "gaitsim", body.name),
    ):
        yield body, {}


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


def fitness_rules(
    entry: Entry, fitness: Fitness, on_status: Callable[[str], None]
) -> Iterator[Finding]:
    """Check all rules for a fitness with its current options."""
    on_status("looking for a body with its channels")
    found = find_body(entry, fitness)
    if found is None:
        yield advice(
            "needs",
            f"an installed body with the channels {', '.join(fitness.needs)}",
            "no such body; the terms were not checked",
            "correct 'needs', or install the package of a body",
        )
        return
    on_status(f"moving and evaluating {found[0]}")
    motion, recording = sample_motion(*found), _RecordingMotion(sample_motion(*found))
    terms: object = fitness.terms(recording)
    if (yield from any_error(_check_terms(terms))):
        return
    assert isinstance(terms, dict)
    given = {name: np.array(term) for name, term in terms.items()}
    yield from _check_needs(fitness, recording)
    changed = next((name for name in motion if not same(motion[name], recording[name])), "")
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
    yield from _check_determinism(fitness, found, given)


def _check_terms(terms: object) -> Iterator[Finding]:
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
            yield error(
                "terms", "a printable name for each term", f"{name!r:.60}", "rename the term"
            )
        elif values.shape != (COUNT,) or values.dtype.kind not in "biuf":
            yield error(
                "shapes",
                f"{name}: real numbers, (population,) = ({COUNT},)",
                f"shape {values.shape}, dtype {values.dtype}",
                "reduce each individual's term to one number, for example with .sum(axis=1)",
            )


def _check_needs(fitness: Fitness, recording: _RecordingMotion) -> Iterator[Finding]:
    undeclared = sorted(recording.read - {*fitness.needs})
    if undeclared:
        yield error(
            "needs",
            "'needs' lists every channel that the fitness reads",
            f"also reads {', '.join(undeclared)}",
            f"needs = {(*fitness.needs, *undeclared)!r}",
        )
    unread = [name for name in fitness.needs if name not in recording.read]
    if unread:
        yield advice(
            "needs",
            "'needs' lists only channels that the fitness reads; bodies must have all of them",
            f"never reads {', '.join(unread)}",
            "remove them from 'needs'",
        )


def _check_determinism(
    fitness: Fitness, found: tuple[Entry, Organism], given: dict[str, Array]
) -> Iterator[Finding]:
    again = fitness.terms(sample_motion(*found))
    name = first_difference(given, {name: np.array(term) for name, term in again.items()})
    if name:
        yield error(
            "determinism",
            "the same terms for the same motion, bit for bit",
            f"{name} differs in a second call",
            "use no random numbers, and keep no state between calls",
        )
        return
    body = found[1]
    genomes = sample_genomes(body.genome_space())
    for indices in ([2], [4, 1, 0]):
        part = fitness.terms(body.move(genomes[indices]))
        name = first_difference(
            {name: term[indices] for name, term in given.items()},
            {name: np.array(term) for name, term in part.items()},
        )
        if name:
            yield error(
                "chunks",
                "the same terms in any chunk, with values that depend only on the individual",
                f"{name} differs when individuals are evaluated in a chunk of {len(indices)}",
                "use no values of the whole population, such as its best or its mean",
            )
            return
