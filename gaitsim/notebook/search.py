"""A search as a loop over its generations, recorded on disk or not."""

import warnings
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any, Self

import numpy as np

from gaitsim import evolution
from gaitsim.errors import GaitsimError, RunError
from gaitsim.evaluation import Evaluator
from gaitsim.evolution import Generation, island_map
from gaitsim.experiment import Experiment, Overrides, load_experiment, with_overrides
from gaitsim.individual import Individual
from gaitsim.repr_mixin import ReprField, ReprMixin
from gaitsim.runs.files.folder import create_run
from gaitsim.runs.session import Session

if TYPE_CHECKING:
    from gaitsim.notebook.run import Run

ARGUMENTS = "arguments"  # where options come from, for messages


def evolve(
    experiment: str | Path | Experiment,
    *,
    generations: int | None = None,
    population: int | None = None,
    seed: int | None = None,
    set: Mapping[str, Any] | None = None,
    workers: int | None = None,
    out: str | Path | None = None,
) -> "Search":
    """Evolve: a search to loop over, which yields each finished generation.

    The same experiment, options and seed give the same generations to the last bit,
    in Python as on the command line, with any number of workers.

    Args:
        experiment: a preset's name, the path of a TOML file, or an experiment.
        generations: how many; None as the experiment says.
        population: individuals in each; None as the experiment says.
        seed: of all randomness; None as the experiment says.
        set: options by key, such as `{"mutation.rate": 0.1}`.
        workers: how many work at a time; None for what suits the body.
        out: folder of a run to record, as `gaitsim run` does; one that is taken gets a
            number. None records nothing.

    Returns:
        The search, an iterator of `Generation`. Nothing is evolved before it is looped over.

    Raises:
        ExperimentError: the experiment has problems, all of them in one message.
        GaitsimError: there is no such preset or file, the folder cannot be made, or `set` or
            `workers` is nothing of the kind.
    """
    _check_workers(workers)
    given = overrides(
        {
            "evolution.generations": generations,
            "evolution.population": population,
            "seed": seed,
        },
        set,
    )
    if not isinstance(experiment, Experiment):
        experiment = load_experiment(str(experiment), given, ARGUMENTS)
    elif given:
        experiment = with_overrides(experiment, given, ARGUMENTS)
    if out is None:
        return Search(experiment, None, _unrecorded(experiment, workers))
    path = create_run(experiment, Path(out))
    return Search(experiment, path, _recorded(path, workers))


def overrides(short: Mapping[str, Any], set: Mapping[str, Any] | None) -> dict[str, Any]:
    """Return options by key, without those of `short` that are None.

    Raises:
        GaitsimError: `set` is no mapping.
    """
    if not isinstance(set, Mapping | None):
        raise GaitsimError(
            f"{set!r} are no options by key",
            where="set",
            allowed='a mapping, such as {"mutation.rate": 0.1}',
        )
    return {key: value for key, value in short.items() if value is not None} | dict(set or {})


def _check_workers(workers: Any) -> None:
    """Refuse what is no number of workers."""
    whole = isinstance(workers, int | np.integer) and not isinstance(workers, bool)
    if workers is not None and not (whole and workers >= 1):
        raise GaitsimError(
            f"{workers!r} is no number of workers",
            where="workers",
            allowed="a whole number, 1 or more; None for what suits the body",
        )


# The generations are functions' and not methods': a search that is left in the middle of its
# loop is then freed at once, and with it the workers and the run's lock.
def _unrecorded(experiment: Experiment, workers: int | None) -> Iterator[Generation]:
    with Evaluator(experiment, workers, _warn) as evaluator:
        evaluator.prepare()
        yield from evolution.evolve(
            experiment, evaluator.evaluate, parallel_map=island_map(evaluator)
        )


def _recorded(
    path: Path,
    workers: int | None,
    overrides: Overrides | None = None,
    generations: int | None = None,
) -> Iterator[Generation]:
    with Session(
        path, overrides=overrides, generations=generations, workers=workers, on_warning=_warn
    ) as session:
        if session.writer.warning:
            _warn(session.writer.warning)
        yield from session.evolve()


def _warn(text: str) -> None:
    warnings.warn(text, stacklevel=2)


def resumed(
    path: Path,
    experiment: Experiment,
    workers: int | None,
    overrides: Overrides,
    generations: int | None,
) -> "Search":
    """A search that goes on with a recorded run, further, or under changed options.

    Raises:
        GaitsimError: `workers` is no number of workers.
    """
    _check_workers(workers)
    return Search(experiment, path, _recorded(path, workers, overrides, generations))


class Search(ReprMixin, Iterator[Generation]):
    """A search, to loop over once; made by `evolve`.

    A loop that is left early can be gone on with: `next(search)`, or another loop. `close()`,
    or the end of a `with` block, gives the workers and the lock of the run back; so does
    letting go of the search. What was yielded of a recorded search is on the disk.

    Attributes:
        experiment: what is evolved, and how.
        path: folder of the run; None where nothing is recorded.
        last: the last generation that was yielded; None before the first.
        champion: the best individual that was yielded; None before the first that did not
            fail.
    """

    def __init__(
        self, experiment: Experiment, path: Path | None, generations: Iterator[Generation]
    ) -> None:
        self.experiment = experiment
        self.path = path
        self.last: Generation | None = None
        self.champion: Individual | None = None
        self._generations = generations

    def __iter__(self) -> Self:
        return self

    def __next__(self) -> Generation:
        self.last = generation = next(self._generations)
        score = float(generation.scores[generation.best])
        if np.isfinite(score) and (self.champion is None or score > self.champion.score):
            best, terms = generation.best, generation.evaluation.terms
            self.champion = Individual(
                self.experiment,
                score,
                {name: float(values[best]) for name, values in terms.items()},
                generation.number,
                generation.genomes[best],
                self.path,
            )
        return generation

    @property
    def run(self) -> "Run":
        """The run on disk, opened for reading.

        Raises:
            RunError: nothing is recorded.
        """
        from gaitsim.notebook.run import Run

        if self.path is None:
            raise RunError(
                "this search is not recorded", remedy="give evolve() a folder, as out='runs/mine'"
            )
        return Run(self.path)

    def close(self) -> None:
        """End it: workers and lock are given back; it yields nothing any more."""
        close = getattr(self._generations, "close", None)
        if close is not None:
            close()

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
