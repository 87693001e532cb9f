"""gaitsim in Python: evolve in a loop, open runs, look at champions.

`import gaitsim as gs` has all of it. It calls the same functions as the command line.
"""

from collections.abc import Generator, Iterator, Mapping
from pathlib import Path
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray

from gaitsim import evolution
from gaitsim.adaptation.of_run import RunAdaptations
from gaitsim.arguments import ARGUMENTS, as_overrides, check_workers, warn
from gaitsim.contracts import GenomeSpace
from gaitsim.contracts.search import Members
from gaitsim.errors import GaitsimError, RunError
from gaitsim.evaluation import Evaluator
from gaitsim.evaluation.worlds import Ranges, World
from gaitsim.evolution import Generation, island_map
from gaitsim.experiment import Experiment, Overrides
from gaitsim.experiment.in_python import check_belongs, python_experiment, resumed_options
from gaitsim.gait.changed import with_world
from gaitsim.gait.judgement import Judgement
from gaitsim.gait.unseen import judge
from gaitsim.individual import Individual, Member
from gaitsim.live.control import BackgroundControls
from gaitsim.registry.python_giving import given_options
from gaitsim.render.notebook import RunViews, picture, view
from gaitsim.repr_mixin import ReprField, ReprMixin
from gaitsim.runs.files.folder import create_run, find_run
from gaitsim.runs.notes import read_note, write_note
from gaitsim.runs.renaming import rename_run
from gaitsim.runs.session import Session
from gaitsim.runs.writer import RunWriter
from gaitsim.sharing.challenge import code_of

__all__ = ["Individual", "Member", "Run", "Search", "evolve", "load", "picture", "view"]

Generations = Generator[Generation, None, None]


def evolve(
    experiment: str | Path | Experiment | None = None,
    *,
    fitness: Any = None,
    body: Any = None,
    space: GenomeSpace | None = None,
    generations: int | None = None,
    population: int | None = None,
    seed: int | None = None,
    set: Mapping[str, Any] | None = None,
    workers: int | None = None,
    out: str | Path | None = None,
) -> "Search":
    """Return a search to loop over, an iterator of finished generations.

    The same experiment, options and seed give the same generations to the last bit,
    in Python as on the command line, with any number of workers. Evolution starts with the loop.

    Args:
        experiment: a preset's name, the path of a TOML file or of a robot's file, or an experiment.
            None for a body alone: CMA-ES evolves it, or a genetic search if its genes are bits.
        fitness: a function of your own, (motion) -> (population,), or a dict of such terms; or an
            instance of a subclass of `Fitness`. None as the experiment says.
        body: a function of your own, (genomes (population, genes)) -> dict of channels, each
            (population, …), or the score (population,); or an instance of a subclass of `Organism`.
        space: the genomes of a body that is a function.
        generations: how many; None as the experiment says.
        population: individuals in each; None as the experiment says.
        seed: of all randomness; None as the experiment says.
        set: options by key, such as `{"mutation.rate": 0.1}`.
        workers: number of parallel workers; None for what suits the body.
        out: folder of a run to record, as `gaitsim run` does; a number is added to one that
            exists. None records nothing.

    Raises:
        ExperimentError: the experiment has problems, all of them in one message.
        GaitsimError: there is no such preset or file, the folder cannot be created, or `set` or
            `workers` is invalid.
    """
    check_workers(workers)
    given = as_overrides(
        set,
        {"evolution.generations": generations, "evolution.population": population, "seed": seed},
    )
    experiment = python_experiment(
        experiment, given, ARGUMENTS, fitness=fitness, body=body, space=space
    )
    if out is None:
        return Search(experiment, None, _unrecorded(experiment, workers))
    path = create_run(experiment, Path(out))
    return Search(experiment, path, _recorded(path, workers))


def load(
    run: str | Path, *, fitness: Any = None, body: Any = None, space: GenomeSpace | None = None
) -> "Run":
    """Open a run for reading, by its folder or its name under `runs/`.

    Opening a run never executes anything in it.

    Args:
        run: the folder or the name.
        fitness: the function or object of `evolve` that evolved it; no folder contains its code.
        body: likewise.
        space: of a body that is a function.

    Raises:
        RunError: there is none.
        GaitsimError: the functions are not those that evolved it.
    """
    found = Run(find_run(str(run)))
    if sections := given_options(fitness, body, space):
        check_belongs(sections, found.snapshot.outlines, str(found.path))
    return found


class Search(ReprMixin, Iterator[Generation]):
    """A search to loop over once, as `evolve` returns it.

    A loop that is left early can be continued: by `next(search)`, or another loop. `close()`,
    the end of a `with` block or the last reference to the search ends the workers and unlocks the
    run. What a recorded search has yielded is on the disk.

    Attributes:
        experiment: what is evolved, and how.
        path: folder of the run; None where nothing is recorded.
        last: the last generation that was yielded; None before the first.
        champion: the best individual that was yielded; None where all have failed.
    """

    def __init__(self, experiment: Experiment, path: Path | None, generations: Generations) -> None:
        self.experiment = experiment
        self.path = path
        self.last: Generation | None = None
        self.champion: Individual | None = None
        self._generations = generations

    def __next__(self) -> Generation:
        self.last = generation = next(self._generations)
        if generation.number == 1 and not np.isfinite(generation.scores).any():
            reason = generation.evaluation.reasons.get(0, "its score is not finite")
            warn(f"all {len(generation.scores):,} individuals failed; the first one: {reason}")
        score = float(generation.scores[generation.best])
        if np.isfinite(score) and (self.champion is None or score > self.champion.score):
            self.champion = Individual(
                self.experiment,
                score,
                generation.evaluation.terms_of(generation.best),
                generation.number,
                generation.genomes[generation.best],
                self.path,
            )
        return generation

    @property
    def run(self) -> "Run":
        """The run on disk.

        Raises:
            RunError: nothing is recorded.
        """
        if self.path is None:
            raise RunError(
                "this search is not recorded", remedy="give evolve() a folder, as out='runs/mine'"
            )
        return Run(self.path)

    def close(self) -> None:
        """End the workers and unlock the run; the search yields nothing more."""
        self._generations.close()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def _repr_fields(self) -> Mapping[str, ReprField]:
        return {
            "experiment": self.experiment.name,
            "generation": self.last.number if self.last else 0,
            "of": self.experiment.evolution.generations,
            "best": self.champion.score if self.champion else "",
            "path": str(self.path or ""),
        }


class Run(RunViews, RunAdaptations, BackgroundControls, ReprMixin):
    """A run on disk. Its attributes are read again each time, as it may be growing.

    Attributes:
        path: its folder.
    """

    @property
    def experiment(self) -> Experiment:
        """The experiment in the run's `experiment.toml`.

        Raises:
            ExperimentError: it has problems, such as a plugin that is no longer installed.
        """
        return self.snapshot.experiment

    @property
    def history(self) -> dict[str, NDArray[np.float64]]:
        """The columns of `history.csv` by name, (generations,) each; {} before the first one.

        Raises:
            RunError: it is damaged.
        """
        return self.snapshot.history

    @property
    def generation(self) -> int:
        """The last finished generation; 0 before the first."""
        return self.snapshot.generation

    @property
    def note(self) -> str:
        """A text of yours that is kept in the run's folder; '' for none. Can be assigned.

        Raises:
            RunError: it cannot be read, or written.
        """
        return read_note(self.path)

    @note.setter
    def note(self, text: str) -> None:
        write_note(self.path, text)

    def rename(self, name: str) -> None:
        """Give the run's folder another name, in the same place.

        Raises:
            RunError: the name is invalid or taken, or a process evolves the run.
        """
        self.path = rename_run(self.path, name)

    @property
    def champion(self) -> Individual:
        """The best individual of all generations whose scores can be compared.

        Raises:
            RunError: no generation is finished yet, or all individuals failed.
        """
        return self.replay()

    def replay(
        self,
        generation: int | None = None,
        *,
        member: int | None = None,
        world: World | None = None,
    ) -> Individual:
        """Return the best individual of one generation; of all where none is given.

        Args:
            generation: whose best.
            member: number of a member of the search's front or archive instead, from 1.
            world: conditions of the world that its body is in, such as `{"friction": 0.4}`; None
                for the body's own world.

        Raises:
            GaitsimError: generation and member are given, or the body cannot be in this world.
            RunError: there is no such generation or member, or all its individuals failed.
        """
        if generation is not None and member is not None:
            raise GaitsimError("replay() takes a generation or a member, not both", where=ARGUMENTS)
        found = self.snapshot.individual(generation if member is None else Member(member))
        return with_world(found, world) if world else found

    def in_worlds(
        self,
        number: int = 100,
        *,
        generation: int | None = None,
        member: int | None = None,
        seed: int = 0,
        ranges: Ranges | None = None,
        workers: int | None = None,
    ) -> Judgement:
        """Judge the champion, or another individual, in worlds that it has not seen.

        Args:
            number: of worlds.
            generation: whose best; None for the best of all.
            member: number of a member of the search's front or archive instead, from 1.
            seed: of the worlds.
            ranges: lowest and highest value of each condition that varies, by name; None for those
                of the experiment's worlds, or the usual ones of the body.
            workers: number of parallel workers; None for what suits the body.

        Raises:
            GaitsimError: the body has no conditions, or not these, or an argument is invalid.
            RunError: there is no such individual.
        """
        check_workers(workers)
        individual = self.replay(generation, member=member)
        return judge(individual, number, seed=seed, ranges=ranges, workers=workers)

    def share(self, generation: int | None = None, *, member: int | None = None) -> str:
        """Return the challenge code of the champion, or of another individual.

        `verify_code` plays it, on any machine; `Challenge.read` opens it.

        Args:
            generation: whose best; None for the best of all.
            member: number of a member of the search's front or archive instead, from 1.

        Raises:
            GaitsimError: generation and member are given, or the code would be too large.
            RunError: there is no such individual, or the run is damaged.
        """
        return code_of(self.replay(generation, member=member))

    @property
    def members(self) -> Members | None:
        """The front or archive that the search keeps; None where it keeps none.

        Raises:
            RunError: no generation is finished yet, or the checkpoint is damaged.
        """
        return self.snapshot.members

    def fingerprint(self) -> str:
        """Return the SHA-256 of population, scores and history, times left out.

        Raises:
            RunError: no generation is finished yet.
        """
        return self.snapshot.fingerprint()

    def resume(
        self,
        generations: int | None = None,
        *,
        fitness: Any = None,
        body: Any = None,
        space: GenomeSpace | None = None,
        set: Mapping[str, Any] | None = None,
        workers: int | None = None,
    ) -> Search:
        """Return a search that continues the run, exactly as if it had never stopped.

        Args:
            generations: the last generation to evolve, counted from the first one; None as planned.
            fitness: as of `evolve`; another one than the run's begins a stage.
            body: likewise.
            space: of a body that is a function.
            set: options from here on, by key; those that matter begin a stage.
            workers: number of parallel workers; None for what suits the body.

        Raises:
            ExperimentError: the options have problems. What else prevents the run from continuing
                is raised when the loop begins.
        """
        check_workers(workers)
        sections = given_options(fitness, body, space)
        given = as_overrides(set, resumed_options(sections, self.snapshot.outline))
        further = {} if generations is None else {"evolution.generations": generations}
        experiment = self.snapshot.experiment_with(further | given, ARGUMENTS)
        return Search(experiment, self.path, _recorded(self.path, workers, given, generations))

    def _repr_fields(self) -> Mapping[str, ReprField]:
        found = self.snapshot.checkpoint
        best = found.best_score if found else -np.inf
        return {
            "path": str(self.path),
            "generation": found.generation if found else 0,
            "best": best if np.isfinite(best) else "",
        }

    def _repr_details(self) -> Mapping[str, ReprField]:
        return {**self._repr_fields(), **self.experiment._repr_fields()}


# Functions rather than methods: a search that is left in the middle of its loop is then freed at
# once, and with it the workers and the run's lock.
def _unrecorded(experiment: Experiment, workers: int | None) -> Generations:
    with Evaluator(experiment, workers, warn) as evaluator:
        evaluator.prepare()
        yield from evolution.evolve(
            experiment, evaluator.evaluate, parallel_map=island_map(evaluator)
        )


def _recorded(
    path: Path,
    workers: int | None,
    overrides: Overrides | None = None,
    generations: int | None = None,
) -> Generations:
    writer = RunWriter.open(path, overrides=overrides, generations=generations)
    with Session(writer, workers=workers, on_warning=warn) as session:
        if writer.warning:
            warn(writer.warning)
        yield from session.evolve()
