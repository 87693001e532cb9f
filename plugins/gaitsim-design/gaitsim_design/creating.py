"""Create maps of designs: the experiment, the run, and `gs.design`."""

import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from math import ceil
from pathlib import Path
from typing import Any

import numpy as np

from gaitsim.plugin import (
    ARGUMENTS,
    EXPERIMENTS,
    Dimension,
    GaitsimError,
    RunError,
    contract_error,
    entries,
    options,
    plugin_errors,
    unknown,
)
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
from gaitsim_design.search import Designs, Floats, designs_of

Ranges = Mapping[str, tuple[float, float] | None]
"""Smallest and largest factor of each dimension by name; None for the usual ones."""

UPPER, LOWER = ("thigh", "femur"), ("shank", "tibia")
"""The names of the segments of legs that span a map by default."""

TIMED = 8  # individuals whose evaluation is timed


@dataclass(frozen=True)
class Plan:
    """How a map of designs is computed.

    Attributes:
        dimensions: ranges of the factors; {} for two of the body's dimensions.
        levels: factors of each dimension in a grid.
        sample: number of designs in a Latin hypercube instead; 0 for a grid.
        replicates: independent repetitions.
        original: generations that search for gaits of the original.
        polish: generations that vary the gaits of each design.
        speed: speed that gaits should reach, m/s; 0 for none.
        gaits: known gaits of the original, (gaits, genes), with which the map starts.
    """

    dimensions: Ranges
    levels: int = 7
    sample: int = 0
    replicates: int = 3
    original: int = 10
    polish: int = 15
    speed: float = 0.0
    gaits: Sequence[Floats] = ()

    def experiment(
        self, body: str, given: Mapping[str, Any], place: str = COMMAND_LINE
    ) -> Experiment:
        """Return the experiment of a map.

        Args:
            body: name of a preset, or path of a TOML file or a robot's file.
            given: values of options by key.
            place: origin of the options, for messages.

        Raises:
            ExperimentError: the experiment has problems.
            GaitsimError: the body lacks the dimensions, or a range is invalid.
        """
        base = load_experiment(body, given, place)
        ranges = self._ranges(base)
        low, high = np.array([*ranges.values()]).T
        measures = self._measures(base)
        rng = np.random.default_rng(0)
        count = len(designs_of(low, high, self.levels, self.sample, rng))
        known = len(self.gaits)
        transfers = ceil(known / self.replicates) if known else 1
        original = 0 if known else max(self.original, 1)
        organism: Any = base.organism
        kept = [name for name in organism.evolve if name not in organism.design_space()]
        derived: dict[str, Any] = {
            "name": f"{base.name}-designs",
            "description": f"gaits of {count} designs of {base.name}",
            "organism.evolve": [*kept, *ranges],
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
            "search.measures": measures,
        }
        # Stop conditions on the best score would end the search before all designs are polished.
        for name in ("target_score", "stagnation", "max_evaluations"):
            if getattr(base.evolution, name) is not None:
                derived[f"evolution.{name}"] = options.NOT_SET
        return load_experiment(body, {**given, **derived}, place)

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
        found = {}
        for name, ends in (self.dimensions or default_ranges(space)).items():
            if name not in space:
                raise unknown("dimension", name, [*space], where="--dimensions")
            one = space[name]
            least, most = ends or (one.low, one.high)
            if not one.least <= least < most <= one.most or not least <= 1 <= most:
                raise GaitsimError(
                    f"invalid range of the dimension {name!r}: {least:g} to {most:g}",
                    where="--dimensions",
                    allowed=f"factors from {one.least:g} to {one.most:g}, the smaller one first, "
                    "with the original, 1, in between",
                )
            found[name] = (least, most)
        return found

    def _measures(self, base: Experiment) -> list[str]:
        """Return the measures of the body that a map records."""
        entry, genomes = base.entries["organism"], base.space().random(1, np.random.default_rng(0))
        with plugin_errors(entry, "measuring an individual"):
            measures = base.organism.measures(base.organism.move(genomes))
        if not isinstance(measures, Mapping):
            what = f"returned a {type(measures).__name__} from measures()"
            raise contract_error(entry, what, "a mapping")
        if self.speed and SPEED not in measures:
            raise GaitsimError(
                f"the body {entry.name!r} does not measure its speed",
                where="--speed",
                allowed=", ".join(measures),
            )
        return [name for name in MEASURES if name in measures]

    def create(self, experiment: Experiment, out: Path | None, **settings: Any) -> Any:
        """Return the search of a new run, an iterator of generations.

        Args:
            experiment: experiment of the map.
            out: folder of the run; None for `runs/` with the name of the experiment.
            **settings: `workers` and `dask`, as in `gs.evolve`.
        """
        starts = None
        if len(self.gaits):
            factors = np.ones(len(search_of(experiment).dimensions))
            starts = np.array([[*gait, *factors] for gait in self.gaits])
        folder = out or Path("runs") / experiment.name
        return evolve(experiment, start=starts, out=folder, **settings)


def default_ranges(space: Mapping[str, Dimension]) -> Ranges:
    """Return two dimensions: both long segments of the legs, or else the first two."""
    chosen = [next((name for name in names if name in space), "") for names in (UPPER, LOWER)]
    return dict.fromkeys(chosen if all(chosen) else [*space][:2])


def search_of(experiment: Experiment) -> Designs:
    """Return the search of a map of designs."""
    assert isinstance(experiment.search, Designs), "Plan.experiment chooses the search"
    return experiment.search


def expected_seconds(experiment: Experiment, workers: int | None) -> float:
    """Return how long a map takes, from the time of a few individuals with different designs."""
    space, rng = experiment.space(), np.random.default_rng(0)
    low, high = search_of(experiment).ends(space)  # type: ignore[arg-type]
    starts = experiment.starts()
    genomes = (
        np.resize([*starts.values()], (TIMED, space.genes)) if starts else space.random(TIMED, rng)
    )
    genomes[:, -len(low) :] = rng.uniform(low, high, (TIMED, len(low)))
    evaluate(experiment, genomes)  # compiles the kernels and builds the designs
    begin = time.perf_counter()
    evaluate(experiment, genomes)
    each = (time.perf_counter() - begin) / TIMED
    shared = 1.0 if experiment.organism.threads else min(workers or cores(), cores())
    return each * experiment.individuals * experiment.evolution.generations / shared


def find_map(reference: str) -> RunSnapshot | None:
    """Return the run of a map by folder or, unless it is a preset, by name; None without one.

    Raises:
        RunError: it is a folder without a run.
    """
    named = [] if reference in entries(EXPERIMENTS) else [Path("runs") / reference]
    for path in (Path(reference), *named):
        if holds_run(path):
            return RunSnapshot(path)
    if Path(reference).is_dir():
        raise RunError(
            f"{reference} is neither a body nor a map of designs",
            allowed="the name of a preset, the path of an experiment or robot file, or a run",
        )
    return None


def known_gaits(experiment: Experiment, references: Sequence[str]) -> list[Floats]:
    """Return gaits of the original, from runs, champion files or codes.

    Raises:
        RunError: there is no such run, or it is of another body.
    """
    from gaitsim.plugin.commands import starting_individual

    found = (starting_individual(experiment, reference) for reference in references)
    return [one.genome for one in found if one is not None]


def design(
    body: str | Path,
    dimensions: Ranges | Sequence[str] = (),
    *,
    levels: int = 7,
    sample: int = 0,
    replicates: int = 3,
    original: int = 10,
    polish: int = 15,
    speed: float = 0.0,
    start: Sequence[str | Path] = (),
    seed: int | None = None,
    set: Mapping[str, Any] | None = None,
    workers: int | None = None,
    out: str | Path | None = None,
    on_generation: Callable[[int], object] = lambda number: None,
) -> DesignMap:
    """Compute a map of designs, as `gaitsim design` does; a run is continued and opened.

    Args:
        body: name of a preset, path of a TOML file or a robot's file; or the folder or name of the
            run of a map. The other arguments then have no effect, except `workers`.
        dimensions: names of dimensions, or their smallest and largest factors by name; () for two
            of the body's.
        levels: factors of each dimension in a grid.
        sample: number of designs in a Latin hypercube instead of a grid.
        replicates: independent repetitions, which show the noise of the search.
        original: generations that search for gaits of the original.
        polish: generations that vary the gaits of each design.
        speed: speed that gaits should reach, m/s; 0 for none.
        start: runs whose champions are known gaits of the original.
        seed: seed of all random numbers; None for that of the experiment.
        set: values of options by key.
        workers: number of parallel workers; None for the body's default.
        out: folder of the run; None for `runs/` with the name of the experiment.
        on_generation: called with the number of each finished generation.

    Raises:
        ExperimentError: the experiment has problems.
        GaitsimError: the body lacks the dimensions, or an argument is invalid.
        RunError: the run is not a map of designs, or cannot be read or written.
    """
    run = find_map(str(body))
    if run is not None:
        designs_search(run)
        search = Run(run.path).resume(workers=workers)
    else:
        given = {**(set or {}), **({} if seed is None else {"seed": seed})}
        ranges = dimensions if isinstance(dimensions, Mapping) else dict.fromkeys(dimensions)
        gaits = []
        if start:
            gaits = known_gaits(load_experiment(str(body), given, ARGUMENTS), [*map(str, start)])
        plan = Plan(ranges, levels, sample, replicates, original, polish, speed, gaits)
        experiment = plan.experiment(str(body), given, ARGUMENTS)
        search = plan.create(experiment, None if out is None else Path(out), workers=workers)
    path = search.path
    assert path is not None, "the search of a run"
    with search:
        for generation in search:
            on_generation(generation.number)
    return DesignMap.of(RunSnapshot(path))
