"""`gaitsim run`, `gaitsim atlas` and `gaitsim resume`."""

from __future__ import annotations

import math
from pathlib import Path
from typing import TYPE_CHECKING, Any

from gaitsim.actions.action import (
    DASK,
    EXPERIMENT,
    GENERATIONS,
    JSON,
    POPULATION,
    RUN,
    SET,
    WORKERS,
    Action,
    argument,
)
from gaitsim.contracts.plugin import option
from gaitsim.contracts.product import Names
from gaitsim.errors import GaitsimError

if TYPE_CHECKING:
    from gaitsim.experiment import Experiment
    from gaitsim.storage.files.checkpoint import Champion


class Evolve(Action):
    """Options of how a run evolves."""

    set_: Names | None = SET
    workers: int | None = WORKERS
    dask: str | None = DASK
    detach: bool = option(
        False, "evolve in the background, until the run is finished or 'gaitsim stop' stops it"
    )
    json_lines: bool = JSON


class EvolveNew(Evolve):
    """Options of a new run."""

    generations: int | None = GENERATIONS
    population: int | None = POPULATION
    seed: int | None = option(None, "seed of all random numbers")
    from_: str | None = option(
        None,
        "start from a given individual: the search begins around it. Give a gait file of a robot "
        "(.csv, .npz or .mat), a champion file, a run (its champion), RUN@N (the best individual "
        "of generation N), RUN@N:I (its individual I), RUN#N (member N of its front or archive) "
        "or a challenge code",
        flag="--from",
        placeholder="FILE|RUN[@N|#N]|CODE",
        completion="run_names",
    )
    out: Path | None = option(
        None,
        "folder of the run",
        unset="a folder in runs/ named after the experiment",
        placeholder="FOLDER",
    )

    @property
    def given(self) -> dict[str, Any]:
        """The given options of the experiment, by key."""
        from gaitsim.experiment import parse_assignments

        short = {
            "evolution.generations": self.generations,
            "evolution.population": self.population,
            "seed": self.seed,
        }
        given = {key: value for key, value in short.items() if value is not None}
        return {**given, **parse_assignments(self.set_ or ())}

    def chosen(self) -> tuple[Experiment, Champion | None]:
        """Return the experiment to evolve, and the individual from which it starts."""
        raise NotImplementedError

    def do(self) -> None:
        """Create a run, and evolve it."""
        from gaitsim.console.cluster import warn
        from gaitsim.console.evolving import chosen_place, evolve_run
        from gaitsim.storage.creation import create_run
        from gaitsim.storage.snapshot import RunSnapshot

        experiment, start = self.chosen()
        for warning in experiment.warnings():
            warn(warning)
        with chosen_place(self.dask, self.workers, detach=self.detach) as place:
            run = RunSnapshot(create_run(experiment, self.out, start))
            evolve_run(run, place, workers=self.workers, json=self.json_lines)


class EvolveRun(EvolveNew):
    """Evolve a gait, and save the run in a folder.

    Ctrl-C stops after the current generation, saves the run, and prints how to continue it.

    [bold]Examples[/bold]

    gaitsim run spider

    gaitsim run spider --seed 3 --generations 200

    gaitsim run spider --set search.start=random --set fitness.yaw_weight=2

    gaitsim run spider-genetic --set mutation.rate=0.1

    gaitsim run my-spider.toml --out runs/mine --json > log.jsonl

    gaitsim run my_robot.urdf

    gaitsim run spider --from runs/spider --set fitness.yaw_weight=8

    gaitsim run spider --from spider@120

    gaitsim run spider --from runs/spider/champions/generation-000014.pickle

    gaitsim run --from gaitsim1-8gAAAGNl… --seed 4

    gaitsim run spider --detach

    gaitsim run walker --dask tcp://host:8786
    """

    experiment: str | None = argument(
        EXPERIMENT,
        "NAME|FILE",
        None,
        unset="with --from CODE, the experiment of the code",
        completion="preset_names",
    )

    def chosen(self) -> tuple[Experiment, Champion | None]:
        """Return the given experiment, or that of a challenge code."""
        from gaitsim.console.codes import read_challenge
        from gaitsim.console.evolving import starting_individual
        from gaitsim.experiment import load_experiment

        given = self.given
        challenge = read_challenge(self.from_) if self.from_ is not None else None
        if self.experiment is not None:
            loaded = load_experiment(self.experiment, given)
        elif challenge is not None:
            loaded = challenge.experiment_with(given)
        else:
            raise GaitsimError(
                "no experiment is given",
                where="NAME|FILE",
                allowed="the name of a preset or a file; optional with --from CODE",
                remedy="'gaitsim experiments list' lists the presets",
            )
        if challenge is None and self.from_ and Path(self.from_).suffix.lower() in GAITS:
            return _start_at_gait(loaded, Path(self.from_))
        return loaded, starting_individual(loaded, challenge or self.from_)


GAITS = (".csv", ".npz", ".mat")


def _start_at_gait(experiment: Experiment, path: Path) -> tuple[Experiment, Champion]:
    """Return the experiment and the start of a search that begins at a gait from a file."""
    from gaitsim.console.printing import notice
    from gaitsim.gait.from_file import start_from_gait
    from gaitsim.gait.gait_files import read_gait
    from gaitsim.storage.compatibility import versions
    from gaitsim.storage.files.checkpoint import Champion

    file = read_gait(path)
    found = start_from_gait(experiment, file)
    for text in (*(f"{path}: {one}" for one in file.notices), found.about):
        notice(text)
    one = found.individual
    assert one.genome is not None, "a fitted gait has a genome"
    score = one.score if math.isfinite(one.score) else 0.0
    text, used = found.experiment.to_toml(), versions(found.experiment)
    return found.experiment, Champion(text, used, 1, one.genome, score, {})


class Resume(Evolve):
    """Continue a run exactly as if it had never stopped, optionally with changed options.

    Changes made with --set start a new stage of the run at the next generation.

    [bold]Examples[/bold]

    gaitsim resume spider

    gaitsim resume spider --generations 300

    gaitsim resume spider --set fitness.yaw_weight=8 --generations 400

    gaitsim resume spider --set fitness.plugin=spider-classic --generations 500

    gaitsim resume spider --detach
    """

    run: str = argument(RUN, "RUN")
    generations: int | None = option(
        None, "continue up to this generation", unset="the number originally planned"
    )
    any_version: bool = option(False, "continue even if a plugin's package has changed version")

    def do(self) -> None:
        """Evolve the run."""
        from gaitsim.console.evolving import chosen_place, evolve_run
        from gaitsim.experiment import parse_assignments
        from gaitsim.storage.snapshot import RunSnapshot

        run, overrides = RunSnapshot.find(self.run), parse_assignments(self.set_ or ())
        with chosen_place(self.dask, self.workers, detach=self.detach) as place:
            evolve_run(
                run,
                place,
                workers=self.workers,
                json=self.json_lines,
                overrides=overrides,
                generations=self.generations,
                any_version=self.any_version,
            )
