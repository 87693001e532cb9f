"""`gaitsim design`."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, ClassVar

from pydantic import BeforeValidator

from gaitsim.plugin import GaitsimError, Names, option
from gaitsim.plugin.commands import INTERRUPTED, JSON, SET, WORKERS, Action, argument, parse_pairs

if TYPE_CHECKING:
    from gaitsim.plugin.runs import RunSnapshot

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
        "challenge code",
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
        from gaitsim.plugin.commands import (
            Progress,
            interruptible,
            notice,
            print_json,
            report_files,
            status,
        )
        from gaitsim.plugin.pictures import visible
        from gaitsim.plugin.runs import Run, command
        from gaitsim_design.creating import find_map
        from gaitsim_design.maps import DesignMap
        from gaitsim_design.report import print_map, to_dict, write_results

        again = command("design", self.body)
        try:
            with interruptible():
                with status(f"Preparing the designs of {visible(self.body)} …"):
                    run = find_map(self.body) or self._create()
                again = command("design", run.path)
                total, done = run.experiment.evolution.generations, run.generation
                what = f"designs {run.path}"
                log = f"{what}: generation {done} of {total}" * (done < total)
                with (
                    Progress(what, "generations", total, done, log=log) as progress,
                    Run(run.path).resume(workers=self.workers) as search,
                ):
                    for generation in search:
                        progress.reach(generation.number)
                with status("Measuring the designs …"):
                    found = DesignMap.of(run.reopened())
                    files = write_results(found)
        except KeyboardInterrupt:
            notice(f"Stopped; finished generations are saved. Continue with: {again}")
            sys.exit(INTERRUPTED)
        report_files(*files)
        if self.json_lines:
            print_json(to_dict(found))
        else:
            print_map(found, files)

    def _create(self) -> RunSnapshot:
        """Create the run, and print how long it will take."""
        from gaitsim.plugin.commands import notice
        from gaitsim.plugin.runs import RunSnapshot, parse_assignments
        from gaitsim_design.creating import MapPlan, expected_seconds

        seed = {} if self.seed is None else {"seed": self.seed}
        names = "levels", "sample", "replicates", "original", "polish", "speed"
        given: dict[str, Any] = {name: getattr(self, name) for name in names}
        plan = MapPlan(self.dimensions or {}, start=self.from_ or (), **given)
        path = plan.create(self.body, {**parse_assignments(self.set_ or ()), **seed}, self.out)
        run = RunSnapshot(path)
        seconds, evolution = expected_seconds(run, self.workers), run.experiment.evolution
        notice(
            f"{path}: {evolution.population // self.replicates:,} designs × {self.replicates} "
            f"replicates × {evolution.generations} generations; about "
            + (f"{seconds / 60:.0f} minutes" if seconds > 90 else f"{seconds:.0f} seconds")
        )
        return run
