"""Find an installed body with the channels that a fitness reads."""

from collections.abc import Iterator
from contextlib import suppress

from gaitsim import toml
from gaitsim.contracts import Fitness, Organism
from gaitsim.errors import GaitsimError
from gaitsim.experiment.combination import compatible
from gaitsim.registry import EXPERIMENTS, Entry, entries, load_entry, plugin_errors
from gaitsim.registry.loading import read_preset
from gaitsim.registry.options import PLUGIN
from gaitsim.testing.rules.declared import build_plugin


def find_body(entry: Entry, fitness: Fitness) -> tuple[Entry, Organism] | None:
    """Return an installed body with the channels that the fitness reads; None if there is none.

    The order is: bodies of the fitness's own package, bodies of gaitsim, all others. A body that
    cannot be loaded is skipped.
    """
    for body, values in _candidates(entry):
        with suppress(GaitsimError, ValueError):
            model = load_entry(body)
            if compatible(type(fitness), getattr(model, "channels", ()), None):
                with plugin_errors(body, "validating its options"):
                    organism = build_plugin(model, values)
                assert isinstance(organism, Organism)
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
