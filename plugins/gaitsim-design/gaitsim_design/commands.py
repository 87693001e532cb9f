"""`gaitsim design`."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, ClassVar

from pydantic import BeforeValidator

from gaitsim.plugin import GaitsimError, Names, option
from gaitsim.plugin.commands import INTERRUPTED, JSON, SET, WORKERS, Action, argument, parse_pairs

if TYPE_CHECKING:
    from gaitsim.plugin.runs import Experiment

Ranges = dict[str, tuple[float, float] | None]


def parse_ranges(value: Any) -> Any:
    """Return the ends of each dimension of 'NAME=LOW:HIGH,…'; None for a name without ends."""
    if not isinstance(value, str):
        return value
    allowed = "NAME,… or NAME=LOW:HIGH,… with factors, such as thigh,shank=0.5:1.5"
    found: Ranges = {}
    for name, ends in parse_pairs(value, "--dimensions", allowed).items():
        try:
            low, high = (float(end) for end in ends.split(":")) if ends else (0.0, 0.0)
        except ValueError:
            what = f"invalid range of the dimension {name!r}: {ends!r}"
            raise GaitsimError(what, where="--dimensions", allowed=allowed) from None
        found[name] = (low, high) if ends else None
    return found


class Design(Action):
    """Map the designs of a body: how its dimensions change its best gaits.

    Gaits evolve for the original first. Every design, such as a robot with longer shanks, tries
    them, and improves its own. Independent replicates show how much of a difference is noise of the
    search. The map is a run: Ctrl-C saves and stops it; pass the run to continue it, or to show
    it again.

    [bold]Examples[/bold]

    gaitsim design quadruped

    gaitsim design my_robot.urdf --dimensions thigh,shank=0.5:1.5

    gaitsim design hexapod --dimensions femur,tibia,hips.width --sample 60

    gaitsim design quadruped --from runs/quadruped

    gaitsim design quadruped --speed 0.3 --out runs/at-0.3

    gaitsim design quadruped-designs --json

    gaitsim plot quadruped-designs --kind design
    """

    title: ClassVar[str] = "Map of designs"

    body: str = argument(
        "name of a preset, or path of a TOML file or a robot file such as URDF; or a map of "
        "designs: the name of a run in runs/, or its folder",
        "NAME|FILE|RUN",
        completion="preset_names",
        shown=True,
    )
    dimensions: Annotated[Ranges, BeforeValidator(parse_ranges)] | None = option(
        None,
        "dimensions of the body, each with its smallest and largest factor; by default, 0.7:1.3",
        unset="thigh and shank, femur and tibia, or the body's first two dimensions",
        placeholder="NAME=LOW:HIGH,…",
    )
    levels: int = option(7, "factors of each dimension in the grid", ge=3, le=100)
    sample: int = option(
        0,
        "number of designs in a Latin hypercube instead of a grid; 0 for a grid",
        ge=0,
        le=100_000,
    )
    replicates: int = option(3, "number of independent repetitions", ge=1, le=100)
    original: int = option(
        10, "generations that search for gaits of the original, without --from", ge=1, le=10_000
    )
    polish: int = option(15, "generations that vary the gaits of each design", ge=0, le=10_000)
    speed: float = option(
        0.0,
        "speed that all gaits should reach, so that heat and cost are compared at one speed; 0 for "
        "none",
        unit="m/s",
        ge=0,
        le=100,
    )
    from_: Names | None = option(
        None,
        "known gait of the original: a run (its champion), RUN@N, RUN#N, a champion file or a "
        "challenge code; may be given several times",
        flag="--from",
        placeholder="RUN",
        completion="run_names",
    )
    seed: int | None = option(None, "seed of all random numbers", unset="that of the experiment")
    set_: Names | None = SET
    workers: int | None = WORKERS
    out: Path | None = option(
        None,
        "folder of the run",
        unset="a folder in runs/ named after the experiment, with '-designs'",
        placeholder="FOLDER",
    )
    json_lines: bool = JSON

    def do(self) -> None:
        """Compute or continue the map, and print it."""
        from gaitsim.plugin.commands import interruptible, print_json, report_files, status
        from gaitsim.plugin.pictures import visible
        from gaitsim.plugin.runs import Run, RunSnapshot
        from gaitsim_design.creating import find_map
        from gaitsim_design.maps import DesignMap, designs_search
        from gaitsim_design.report import print_map, to_dict, write_results

        with interruptible():
            try:
                with status(f"Reading {visible(self.body)} …"):
                    run = find_map(self.body)
                    if run is not None:
                        designs_search(run)
                path = self._create() if run is None else run.path
            except KeyboardInterrupt:
                sys.exit(INTERRUPTED)
            snapshot = RunSnapshot(path)
            if snapshot.generation < snapshot.experiment.evolution.generations:
                self._evolve(Run(path))
            with status("Measuring the designs …"):
                found = DesignMap.of(RunSnapshot(path))
                files = write_results(found)
        report_files(*files)
        if self.json_lines:
            print_json(to_dict(found))
        else:
            print_map(found, files)

    def _create(self) -> Path:
        """Create the run, and state how long it will take."""
        from gaitsim.plugin.commands import notice, status
        from gaitsim.plugin.pictures import visible
        from gaitsim.plugin.runs import load_experiment, parse_assignments
        from gaitsim_design.creating import Plan, expected_seconds, known_gaits

        seed = {} if self.seed is None else {"seed": self.seed}
        given = {**parse_assignments(self.set_ or ()), **seed}
        gaits = []
        with status(f"Preparing the designs of {visible(self.body)} …"):
            if self.from_:
                gaits = known_gaits(load_experiment(self.body, given), self.from_)
            plan = Plan(
                self.dimensions or {},
                self.levels,
                self.sample,
                self.replicates,
                self.original,
                self.polish,
                self.speed,
                gaits,
            )
            experiment = plan.experiment(self.body, given)
            path: Path = plan.create(experiment, self.out).path
            seconds = expected_seconds(experiment, self.workers)
        notice(_announce(experiment, path, seconds))
        return path

    def _evolve(self, run: Any) -> None:
        """Evolve the run to its end, with a progress bar; exit if the user stops it."""
        from gaitsim.plugin.commands import Progress, notice
        from gaitsim.plugin.runs import command

        total, done = run.experiment.evolution.generations, run.generation
        log = f"map of designs {run.path}: generation {done} of {total}"
        try:
            with (
                Progress(f"designs {run.path}", "generations", total, done, log=log) as progress,
                run.resume(workers=self.workers) as search,
            ):
                for generation in search:
                    progress.reach(generation.number)
        except KeyboardInterrupt:
            again = command("design", run.path)
            notice(f"Stopped; finished generations are saved. Continue with: {again}")
            sys.exit(INTERRUPTED)


def _announce(experiment: Experiment, path: Path, seconds: float) -> str:
    """Return the size of a map and how long it will take."""
    from gaitsim_design.creating import search_of

    replicates, evolution = search_of(experiment).replicates, experiment.evolution
    minutes = f"{seconds / 60:.0f} minutes" if seconds > 90 else f"{seconds:.0f} seconds"
    return (
        f"{path}: {evolution.population // replicates:,} designs × {replicates} replicates × "
        f"{evolution.generations} generations; about {minutes}"
    )
