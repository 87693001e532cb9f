"""Compatibility of genomes with the body of another experiment, and versions of packages."""

import sys
from collections.abc import Mapping, Sequence
from functools import cache
from importlib.metadata import version
from pathlib import Path

import numpy as np

from gaitsim.contracts import Genomes, GenomeSpace, RealSpace
from gaitsim.errors import CheckpointError, GaitsimError, RunError
from gaitsim.experiment import Experiment, parse_space, read_outline
from gaitsim.registry import KINDS, REFLEX, entries, find, plugin_errors
from gaitsim.registry.entry_points import OUTSIDE, install_hint, own_packages
from gaitsim.storage.files.checkpoint import Checkpoint, Start
from gaitsim.storage.files.folder import CHECKPOINT, EXPERIMENT
from gaitsim.storage.files.safe_pickle import MAX_BYTES

_installed = cache(version)  # reading it takes a millisecond


def genome_mismatch(experiment: Experiment, genomes: Genomes, source: str, label: str) -> str:
    """Return why genomes do not fit an experiment's body; '' if they do.

    Args:
        experiment: experiment whose body should accept the genomes.
        genomes: genomes, (individuals, genes).
        source: TOML of the experiment that evolved the genomes. The gene labels are not compared
            if its body can no longer be created.
        label: name of the genomes in messages, such as 'the population'.
    """
    space = experiment.space()
    wrong = ""
    labels: Sequence[str] | None
    try:
        body, before = parse_space(source, "the previous experiment")
        actual, labels = _describe_genomes(body, before), before.labels
    except GaitsimError:
        kind = "real" if genomes.dtype.kind == "f" else "bit"
        actual, labels = f"{genomes.shape[1]} {kind} genes", None
    if genomes.dtype != space.dtype or genomes.shape[1] != space.genes:
        wrong = f"{label} has {actual}"
    elif labels is not None and tuple(labels) != tuple(space.labels):
        at = next(i for i in range(space.genes) if labels[i] != space.labels[i])
        wrong = f"{label} has {actual}: gene {at + 1} is {labels[at]!r}, not {space.labels[at]!r}"
    return wrong or out_of_bounds(experiment, genomes, label)


def out_of_bounds(experiment: Experiment, genomes: Genomes, label: str) -> str:
    """Return which gene is outside the bounds of an experiment's body; '' if none is."""
    space = experiment.space()
    with plugin_errors(experiment.entries["organism"], "checking genomes"):
        fits = space.contains(genomes)
    return "" if fits else f"{label} is out of bounds{_first_outside(space, genomes)}"


def expected_genomes(experiment: Experiment) -> str:
    """Describe the genomes that fit an experiment's body."""
    body = experiment.entries["organism"].name
    return f"{_describe_genomes(body, experiment.space())}, within bounds"


def _describe_genomes(body: str, space: GenomeSpace) -> str:
    return f"{space.genes} genes of the kind {space.name!r} of the body {body!r}"


def _first_outside(space: GenomeSpace, genomes: Genomes) -> str:
    if not isinstance(space, RealSpace):
        return ""
    outside = np.argwhere((genomes < space.lower) | (genomes > space.upper))
    if not len(outside):
        return ""
    individual, gene = outside[0]
    owner = f" of individual {individual}" if len(genomes) > 1 else ""
    return (
        f": {space.labels[gene]!r}{owner} is {genomes[individual, gene]:g}, "
        f"allowed {space.lower[gene]:g} to {space.upper[gene]:g}"
    )


def check_start(experiment: Experiment, start: Start, where: str) -> None:
    """Check that the genomes of a start fit the experiment's body."""
    wrong = genome_mismatch(experiment, start.genomes, start.experiment, "the genome")
    if wrong:
        raise RunError(
            f"{wrong}, so a run cannot start from it",
            where=where,
            allowed=expected_genomes(experiment),
            remedy="start from an individual of the same body, with the same options for its "
            "genome",
        )


def check_size(experiment: Experiment) -> None:
    """Check that the population fits into a checkpoint."""
    population, space = experiment.individuals, experiment.space()
    # Half of the checkpoint is reserved for scores and terms.
    most = MAX_BYTES // 2 // (space.genes * space.dtype.itemsize)
    if population > most:
        raise RunError(
            f"{population:,} individuals with {space.genes} genes are too many for a checkpoint",
            allowed=f"evolution.population up to {most // experiment.islands.number:,}",
        )


def check_population(experiment: Experiment, checkpoint: Checkpoint, path: Path) -> None:
    """Check that the population of a checkpoint fits the experiment in the run's folder."""
    population, genomes = experiment.individuals, checkpoint.genomes
    number = experiment.islands.number
    outline = read_outline(checkpoint.experiment, CHECKPOINT)
    before, search = outline.islands.number, experiment.entries["search"].name
    wrong = genome_mismatch(experiment, genomes, checkpoint.experiment, "the population")
    if search != outline.plugins["search"]:
        wrong = f"the search {outline.plugins['search']!r} evolved the population, not {search!r}"
    if wrong or len(genomes) != population or number != before:
        expected = f"{population} individuals" if number == before else f"{number} islands"
        reason = wrong or f"the experiment has {expected}"
        raise CheckpointError(
            f"the population of {len(genomes)} with {genomes.shape[1]} genes in "
            f"{path / CHECKPOINT} does not match {EXPERIMENT}: {reason}",
            where=str(path / EXPERIMENT),
            allowed=f"a population of {population} with {expected_genomes(experiment)}",
            remedy="undo the changes to the experiment, or start a new run with the changed one",
        )


def versions(experiment: Experiment) -> dict[str, str]:
    """Return the versions of gaitsim, libraries and the packages of plugins in use, by name."""
    found = {"gaitsim": _installed("gaitsim"), "numpy": np.__version__}
    engine = experiment.engine  # another version may compute different motions
    if engine in sys.modules:
        own = getattr(sys.modules[engine], "__version__", None)  # its package may be renamed
        found[engine] = str(own or _installed(engine))
    for kind, entry in experiment.entries.items():
        found[f"{kind} {entry.name}"] = entry.source
    with plugin_errors(experiment.entries["organism"], "naming its reflexes"):
        names = tuple(experiment.organism.reflex_names())
    for name in names:
        found[f"{REFLEX} {name}"] = find(REFLEX, name).source
    return found


def same_version(then: str, now: str) -> bool:
    """Return whether versions of a package are equal; gaitsim's packages were once in one."""
    package, _, version = now.partition(" ")
    return then in (now, f"gaitsim {version}") if package in own_packages() else then == now


def missing_packages(found: Mapping[str, str]) -> list[GaitsimError]:
    """Return an error for each plugin that is not installed, given the versions of a checkpoint."""
    kinds = (*KINDS, REFLEX)
    known = {f"{kind} {name}" for kind in kinds for name in entries(kind)}
    return [
        GaitsimError(
            f"the {key} of this run is not installed; its package is {package}",
            remedy=install_hint(*key.partition(" ")[::2])
            or f"install it: pip install {'=='.join(package.split())}",
        )
        for key, package in found.items()
        if key.partition(" ")[0] in kinds and key not in known and package != OUTSIDE
    ]
