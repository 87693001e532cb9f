"""Create maps of designs: the experiment, the run, and `gs.design`."""

import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, fields
from pathlib import Path
from typing import Any

import numpy as np

from gaitsim.plugin import (
    ARGUMENTS,
    EXPERIMENTS,
    GaitsimError,
    RunError,
    entries,
    options,
    plugin_errors,
    unknown,
)
from gaitsim.plugin.commands import starting_individual
from gaitsim.plugin.runs import (
    COMMAND_LINE,
    Experiment,
    Run,
    RunSnapshot,
    cores,
    evaluate,
    evolve,
    holds_run,
    load_experiment,
)
from gaitsim_design.maps import MEASURES, SPEED, DesignMap, designs_search
from gaitsim_design.search import designs_of

Ranges = Mapping[str, tuple[float, float] | None]
"""Smallest and largest factor of each dimension by name; None for the usual ones."""

SEGMENTS = ("thigh", "femur"), ("shank", "tibia")
"""The names of the segments of legs that span a map by default."""

TIMED = 8  # individuals whose evaluation is timed


@dataclass(frozen=True)
class MapPlan:
    """How a map of designs is computed.

    Attributes:
        dimensions: ranges of the factors; {} for two of the body's dimensions.
        levels: factors of each dimension in a grid.
        sample: number of designs in a Latin hypercube instead; 0 for a grid.
        replicates: independent repetitions, which show the noise of the search.
        original: generations that evolve gaits of the original.
        polish: generations that vary the gaits of each design.
        speed: speed that gaits should reach, m/s; 0 for none.
        start: runs, champion files or codes with known gaits of the original.
    """

    dimensions: Ranges
    levels: int = 7
    sample: int = 0
    replicates: int = 3
    original: int = 10
    polish: int = 15
    speed: float = 0.0
    start: Sequence[str] = ()

    def create(
        self,
        body: str,
        given: Mapping[str, Any],
        out: Path | None,
        place: str = COMMAND_LINE,
    ) -> Path:
        """Create the run of a map, and return its folder.

        Args:
            body: name of a preset, or path of a TOML file or a robot's file.
            given: values of options by key.
            out: folder; None for `runs/` with the name of the experiment.
            place: origin of the options, for messages.

        Raises:
            ExperimentError: the experiment has problems.
            GaitsimError: the body lacks the dimensions, or a range is invalid.
            RunError: a known gait is missing or of another body.
        """
        base = load_experiment(body, given, place)
        ranges = self._ranges(base)
        starts = [starting_individual(base, reference) for reference in self.start]
        known = [[*one.genome, *np.ones(len(ranges))] for one in starts if one is not None]
        experiment = load_experiment(
            body, {**given, **self._derived(base, ranges, len(known))}, place
        )
        folder = out or Path("runs") / experiment.name
        search = evolve(experiment, start=np.array(known) if known else None, out=folder)
        assert search.path is not None, "the folder of the run"
        return search.path

    def _derived(
        self, base: Experiment, ranges: Mapping[str, tuple[float, float]], known: int
    ) -> dict[str, Any]:
        """Return the options of the map that differ from the body's experiment."""
        low, high = np.array([*ranges.values()]).T
        rng, organism = np.random.default_rng(0), base.organism
        count = len(designs_of(low, high, self.levels, self.sample, rng))
        original = 0 if known else self.original
        transfers = -(-known // self.replicates) if known else 1
        evolving: Sequence[str] = organism.evolve  # type: ignore[attr-defined]
        derived: dict[str, Any] = {
            "name": f"{base.name}-designs",
            "description": f"gaits of {count} designs of {base.name}",
            "organism.evolve": [
                *(name for name in evolving if name not in organism.design_space()),
                *ranges,
            ],
            "organism.ranges": {name: [*ends] for name, ends in ranges.items()},
            "evolution.population": count * self.replicates,
            "evolution.generations": original + transfers + self.polish,
            "search.plugin": "designs",
            "search.dimensions": [*ranges],
            "search.levels": self.levels,
            "search.sample": self.sample,
            "search.replicates": self.replicates,
            "search.original": original,
            "search.speed": float(self.speed),
            "search.measures": self._measures(base),
        }
        # Stop conditions on the best score would end the search before all designs are polished.
        for name in ("target_score", "stagnation", "max_evaluations"):
            if getattr(base.evolution, name) is not None:
                derived[f"evolution.{name}"] = options.NOT_SET
        return derived

    def _ranges(self, base: Experiment) -> dict[str, tuple[float, float]]:
        """Return the ranges of the factors of the dimensions, by name."""
        entry = base.entries["organism"]
        with plugin_errors(entry, "naming its dimensions"):
            space = dict(base.organism.design_space())
        if not space:
            raise GaitsimError(
                f"the body {entry.name!r} has no dimensions",
                allowed="a body with dimensions, such as the robots quadruped and hexapod",
            )
        usual = [next((name for name in names if name in space), "") for names in SEGMENTS]
        usual = usual if all(usual) else [*space][:2]
        found = {}
        for name, ends in (self.dimensions or dict.fromkeys(usual)).items():
            if name not in space:
                raise unknown("dimension", name, [*space], where="--dimensions")
            one = space[name]
            low, high = ends or (one.low, one.high)
            if not one.least <= low < high <= one.most or not low <= 1 <= high:
                raise GaitsimError(
                    f"invalid range of the dimension {name!r}: {low:g} to {high:g}",
                    where="--dimensions",
                    allowed=f"factors from {one.least:g} to {one.most:g}, the smaller one first, "
                    "with the original, 1, in between",
                )
            found[name] = (low, high)
        return found

    def _measures(self, base: Experiment) -> list[str]:
        """Return the measures of the body that a map records."""
        entry, genomes = base.entries["organism"], base.space().random(1, np.random.default_rng(0))
        with plugin_errors(entry, "measuring an individual"):
            measures = base.organism.measures(base.organism.move(genomes))
        if self.speed and SPEED not in measures:
            raise GaitsimError(
                f"the body {entry.name!r} does not measure its speed",
                where="--speed",
                allowed=", ".join(measures),
            )
        return [name for name in MEASURES if name in measures]


def expected_seconds(run: RunSnapshot, workers: int | None) -> float:
    """Return how long a map takes, from the time of a few individuals with different designs."""
    experiment, rng = run.experiment, np.random.default_rng(0)
    genomes = experiment.space().random(TIMED, rng)
    genes = genomes.shape[1] - len(designs_search(run).dimensions)
    for start in [*experiment.starts().values()][:1]:  # random gaits fall, which takes less time
        genomes[:, :genes] = start[:genes]
    evaluate(experiment, genomes)  # compiles the kernels and builds the designs
    begin = time.perf_counter()
    evaluate(experiment, genomes)
    each = (time.perf_counter() - begin) / TIMED
    shared = 1.0 if experiment.organism.threads else min(workers or cores(), cores())
    return each * experiment.individuals * experiment.evolution.generations / shared


def find_map(reference: str) -> RunSnapshot | None:
    """Return the map in a folder or, unless it is a preset, of a name; None if there is none.

    Raises:
        RunError: the folder holds another run, or none.
    """
    named = [] if reference in entries(EXPERIMENTS) else [Path("runs") / reference]
    for path in (Path(reference), *named):
        if holds_run(path):
            run = RunSnapshot(path)
            designs_search(run)
            return run
    if Path(reference).is_dir():
        raise RunError(
            f"{reference} is neither a body nor a map of designs",
            allowed="the name of a preset, the path of an experiment or robot file, or a run",
        )
    return None


def design(
    body: str | Path,
    dimensions: Ranges | Sequence[str] = (),
    *,
    seed: int | None = None,
    set: Mapping[str, Any] | None = None,
    workers: int | None = None,
    out: str | Path | None = None,
    on_generation: Callable[[int], object] = lambda number: None,
    **settings: Any,
) -> DesignMap:
    """Compute a map of designs, as `gaitsim design` does, or continue and open one.

    Args:
        body: name of a preset, path of a TOML file or a robot's file; or the folder or name of the
            run of a map, for which all other arguments but `workers` have no effect.
        dimensions: names of dimensions, or their smallest and largest factors by name; () for two
            of the body's.
        seed: seed of all random numbers; None for that of the experiment.
        set: values of options by key.
        workers: number of parallel workers; None for the body's default.
        out: folder of the run; None for `runs/` with the name of the experiment.
        on_generation: called with the number of each finished generation.
        **settings: other options of the command: `levels`, `sample`, `replicates`, `original`,
            `polish`, `speed`, and `start`, a list of runs with known gaits of the original.

    Raises:
        ExperimentError: the experiment has problems.
        GaitsimError: the body lacks the dimensions, or an argument is invalid.
        RunError: the run is not a map of designs, or cannot be read or written.
    """
    known = [one.name for one in fields(MapPlan)]
    for name in settings:
        if name not in known:
            raise unknown("argument of design()", name, known)
    run = find_map(str(body))
    if run is None:
        ranges = dimensions if isinstance(dimensions, Mapping) else dict.fromkeys(dimensions)
        given = {**(set or {}), **({} if seed is None else {"seed": seed})}
        folder = None if out is None else Path(out)
        run = RunSnapshot(MapPlan(ranges, **settings).create(str(body), given, folder, ARGUMENTS))
    with Run(run.path).resume(workers=workers) as search:
        for generation in search:
            on_generation(generation.number)
    return DesignMap.of(run.reopened())
