"""Digests of the results of plugins, for comparison with those of another process."""

from collections.abc import Mapping
from contextlib import suppress
from typing import Any

import numpy as np

from gaitsim.plugin import (
    EXPERIMENTS,
    PLUGIN,
    Crossover,
    Entry,
    Fitness,
    GaitsimError,
    Mutation,
    Organism,
    Plugin,
    Reflex,
    Search,
    Selection,
    entries,
    load_entry,
    plugin_errors,
    read_preset,
    toml,
)
from gaitsim.plugin.runs import compatible
from gaitsim_testing.samples import digest, sample_genomes, sample_motion, supported_spaces
from gaitsim_testing.trials import (
    LEGS,
    ReflexTrial,
    build_plugin,
    make_trial,
    result_arrays,
    with_placeholders,
)


def digest_results(entry: Entry, options: Mapping[str, Any]) -> str:
    """Return a digest of the results of a plugin, for comparison with another process."""
    model = load_entry(entry)
    with plugin_errors(entry, "validating its options"):
        plugin = build_plugin(model, with_placeholders(model, options))
    with plugin_errors(entry, "computing its results"):
        return digest(_compute(entry, plugin))


def _compute(entry: Entry, plugin: Plugin) -> object:
    rng = np.random.default_rng(11)
    if isinstance(plugin, Organism):
        motion = sample_motion(entry, plugin)
        return [motion, plugin.skeleton(motion, 0)]
    if isinstance(plugin, Reflex):
        return [ReflexTrial(plugin, legs).run() for legs in LEGS.values()]
    if isinstance(plugin, Fitness):
        found = find_body(entry, plugin)
        return plugin.terms(sample_motion(*found)) if found else []
    if isinstance(plugin, Search):
        trials = filter(None, (make_trial(plugin, space) for _, space in supported_spaces(plugin)))
        return [[state, result_arrays(last)] for each in trials for state, last in each.run(3)]
    if isinstance(plugin, Selection):
        return plugin.parents(np.sin(np.arange(30.0)), 20, rng)
    assert isinstance(plugin, Crossover | Mutation)
    children = []
    for _, space in supported_spaces(plugin):
        genomes = sample_genomes(space, 8)
        if isinstance(plugin, Crossover):
            children.append(plugin.cross(genomes, genomes[::-1].copy(), space, rng))
        else:
            children.append(plugin.mutate(genomes, space, rng))
    return children


def find_body(entry: Entry, fitness: Fitness) -> tuple[Entry, Organism] | None:
    """Return an installed body with the channels that the fitness reads; None if there is none.

    The order is: bodies of presets of the fitness's own package, as channels may depend on options;
    its bodies, bodies of gaitsim, all others. A body that cannot be loaded is skipped.
    """
    bodies = {name: claims[0] for name, claims in entries("organism").items() if len(claims) == 1}
    candidates: list[tuple[Entry, dict[str, object]]] = []
    for name, claims in entries(EXPERIMENTS).items():
        if claims[0].package == entry.package:
            with suppress(GaitsimError, KeyError, TypeError, AttributeError):
                table = toml.parse(read_preset(name), name)
                section = dict(table["organism"])
                if table["fitness"][PLUGIN] == entry.name:
                    candidates.append((bodies[section.pop(PLUGIN)], section))
    candidates += [
        (body, {})
        for body in sorted(
            bodies.values(),
            key=lambda body: (body.package != entry.package, body.package != "gaitsim", body.name),
        )
    ]
    for body, values in candidates:
        with suppress(GaitsimError, ValueError):
            model = load_entry(body)
            with plugin_errors(body, "validating its options"):
                organism = build_plugin(model, values)
            assert isinstance(organism, Organism)
            if compatible(type(fitness), organism.channels, None):
                return body, organism
    return None
