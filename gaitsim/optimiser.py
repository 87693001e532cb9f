"""Searches that are asked for genomes and told their scores: `gaitsim.Optimiser`."""

import time
from array import array
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any, NoReturn

import numpy as np
from numpy.typing import ArrayLike, NDArray

from gaitsim.arguments import ARGUMENTS, as_overrides
from gaitsim.contracts import Genomes, GenomeSpace, State
from gaitsim.contracts.search import Members
from gaitsim.errors import GaitsimError
from gaitsim.evaluating import as_genomes
from gaitsim.evaluation.scoring import constrain, evaluate_motion
from gaitsim.evaluation.values import values_to_read
from gaitsim.evolution.loop import Generation, finish_generation, next_genomes
from gaitsim.evolution.searching import members
from gaitsim.experiment import Experiment
from gaitsim.experiment.loading import python_experiment
from gaitsim.experiment.model import MOST_GENERATIONS
from gaitsim.individual import Individual
from gaitsim.inspecting import DataFrame, InspectedIndividual, data_frame
from gaitsim.registry.entry_points import PythonEntry
from gaitsim.registry.python_plugins import motion_of, objective_names
from gaitsim.repr_mixin import ReprField, ReprMixin
from gaitsim.storage.compatibility import check_start, out_of_bounds
from gaitsim.storage.files.checkpoint import Start
from gaitsim.storage.files.history import row, with_integers


class TrackedSearch(ReprMixin):
    """The results of a search so far.

    Attributes:
        experiment: experiment being evolved.
        path: folder of the run; None if nothing is recorded.
        last: last generation; None before the first.
        champion: best individual so far; None while all have failed.
    """

    def __init__(self, experiment: Experiment, path: Path | None = None) -> None:
        self.experiment = experiment
        self.path = path
        self.last: Generation | None = None
        self.champion: InspectedIndividual | None = None
        self._history: dict[str, array[float]] = {}

    @property
    def history(self) -> dict[str, NDArray[Any]]:
        """Columns by name, as in `Run.history`, each (generations,); {} before the first.

        They hold the generations of this search only, not those of a run that it continues.
        """
        return with_integers({name: np.array(values) for name, values in self._history.items()})

    def to_pandas(self) -> "DataFrame":
        """Return `history` as a DataFrame, with a row for each generation.

        Raises:
            GaitsimError: pandas is not installed.
        """
        return data_frame(self.history)

    @property
    def members(self) -> Members | None:
        """The front or archive that the search keeps; None for searches without one."""
        return members(self.experiment, self.last.state) if self.last else None

    @property
    def stop(self) -> str:
        """The reason why the search has ended; '' if it continues."""
        return self.last.stop if self.last else ""

    def _add(self, generation: Generation) -> None:
        self.last = generation
        for name, value in row(generation).items():
            self._history.setdefault(name, array("d")).append(value)
        score = float(generation.scores[generation.best])
        if np.isfinite(score) and (self.champion is None or score > self.champion.score):
            self.champion = InspectedIndividual.of_generation(
                self.experiment, generation, generation.best, self.path
            )

    def _repr_fields(self) -> Mapping[str, ReprField]:
        return {
            "experiment": self.experiment.name,
            "generation": self.last.number if self.last else 0,
            "of": ""
            if (most := self.experiment.evolution.generations) == MOST_GENERATIONS
            else most,
            "best": self.champion.score if self.champion else "",
            "path": str(self.path or ""),
        }


class Optimiser(TrackedSearch):
    """A search that you ask for genomes and tell their scores, for loops of your own.

        while not optimiser.stop:
            optimiser.tell([score(genome) for genome in optimiser.ask()])
        print(optimiser.champion.genome)

    With the same seed and scores, it gives the same bits as `gaitsim.evolve` with a function.

    Args:
        space: genome space.
        experiment: name of a preset, path of a file, or an experiment, whose search is used; None
            uses CMA-ES, or a genetic search if the genes are bits.
        population: individuals per generation; see `gaitsim.evolve`.
        generations: number of generations after which the search ends; None sets no limit.
        seed: seed of all random numbers.
        objectives: 'max' or 'min' for each objective, to find trade-offs with NSGA-II; see
            `gaitsim.evolve`.
        constraints: largest value of each constrained value that `tell` receives besides 'score',
            by name.
        start: genome around which the search begins, (genes,), several of them, (starts, genes),
            or an individual; None for a random start.
        set: options by key, such as `{"search.restarts": "stop"}`.

    Raises:
        GaitsimError: an argument or an option is invalid.
    """

    def __init__(
        self,
        space: GenomeSpace,
        experiment: str | Path | Experiment | None = None,
        *,
        population: int | None = None,
        generations: int | None = None,
        seed: int | None = None,
        objectives: Mapping[str, str] | Sequence[str] | None = None,
        constraints: Mapping[str, float] | None = None,
        start: ArrayLike | Individual | None = None,
        set: Mapping[str, Any] | None = None,
    ) -> None:
        options = {
            "evolution.generations": MOST_GENERATIONS if generations is None else generations,
            "evolution.population": population,
            "seed": seed,
            "constraints.at_most": constraints,
            **objective_options(objectives),
            **start_options(start),
        }
        given = as_overrides(set, options)
        super().__init__(python_experiment(experiment, given, ARGUMENTS, body=tell, space=space))
        self._space = self.experiment.space()
        found = start_of(self.experiment, start)
        self._starts = found.genomes if found else None
        self._asked: tuple[Genomes, State, float] | None = None

    def ask(self) -> Genomes:
        """Return the genomes to score, (population, genes); the same ones until `tell` is called.

        Raises:
            GaitsimError: the search has ended; see `stop`.
        """
        if self.stop:
            raise GaitsimError(
                f"the search has ended: {self.stop}", remedy="loop while not optimiser.stop"
            )
        if self._asked is None:
            start = time.perf_counter()
            genomes, state = next_genomes(self.experiment, self._space, self.last, self._starts)
            self._asked = genomes, state, time.perf_counter() - start
        return self._asked[0].copy()

    def tell(self, scores: ArrayLike | Mapping[str, ArrayLike]) -> Generation:
        """Receive the scores of the genomes that `ask` returned; return the finished generation.

        Args:
            scores: score of each genome, (population,); higher is better, and NaN or −inf means
                that the individual failed. Or objectives, (population, objectives), or a dict of
                terms or objectives by name, each (population,).

        Raises:
            GaitsimError: no genomes were asked for, or the scores have a wrong shape.
        """
        if self._asked is None:
            raise GaitsimError("tell() has no genomes to score", remedy="call ask() before tell()")
        genomes, state, seconds = self._asked
        entry, experiment = self.experiment.entries["organism"], self.experiment
        assert isinstance(entry, PythonEntry)
        motion = motion_of(entry, _checked(scores, len(genomes)), len(genomes))
        evaluation = evaluate_motion(experiment, motion, len(genomes))
        read = values_to_read(experiment, motion, evaluation.scores, evaluation.terms)
        evaluation = constrain(experiment, replace(evaluation, values=read))
        self._add(
            finish_generation(
                experiment, self._space, self.last, state, genomes, evaluation, _fail, seconds
            )
        )
        self._asked = None
        assert self.last is not None
        return self.last


def _checked(scores: Any, population: int) -> Any:
    """Return scores as arrays, in a form that `motion_of` accepts."""
    size = f"({population},)"
    if isinstance(scores, Mapping):
        return {
            name: _array(one, population, 1, f"{name!r}, {size}") for name, one in scores.items()
        }
    if isinstance(scores, tuple) and all(np.shape(one) == (population,) for one in scores):
        return scores
    found = _array(
        scores, population, 2, f"{size}; or several objectives, ({population}, objectives)"
    )
    if found.ndim == 2 and found.shape[1] == 1:
        raise _invalid(found, size)
    return found


def _array(values: Any, population: int, axes: int, allowed: str) -> NDArray[Any]:
    try:
        found = np.array(values)
    except ValueError:  # lists of different lengths
        found = np.empty(0, object)
    if found.dtype.kind not in "fiub" or not 1 <= found.ndim <= axes or len(found) != population:
        raise _invalid(found, allowed)
    return found


def _invalid(found: NDArray[Any], allowed: str) -> GaitsimError:
    numbers = found.dtype.kind in "fiub"
    what = f"scores of shape {found.shape}" if numbers else "scores that are not all real numbers"
    allowed = f"one number for each genome that ask() returned, {allowed}"
    return GaitsimError(f"tell() received {what}", where="scores", allowed=allowed)


def tell(genomes: Genomes) -> NoReturn:
    """Stand for the body of an `Optimiser`, whose scores gaitsim cannot compute."""
    raise GaitsimError(
        "the scores of an Optimiser are computed by your own code",
        remedy="use gs.evolve(body=…), or call your own function",
    )


def _fail(genomes: Genomes, generation: int) -> NoReturn:
    tell(genomes)


def start_of(experiment: Experiment, start: Any) -> Start | None:
    """Return the start that a user passed, checked; None for None or the name of a start point.

    Args:
        experiment: experiment that starts from it.
        start: genome, (genes,), or genomes, (starts, genes); an individual; or the name of a start
            point of the body.
    """
    if start is None or isinstance(start, str):
        return None
    if isinstance(start, Individual):
        if start.genome is None:
            what = "the individual has no genome: it is a gait from a file"
            raise GaitsimError(what, where="start", allowed="an individual of a search or a run")
        score = start.score if np.isfinite(start.score) else 0.0
        genomes = np.asarray(start.genome)[None]
        found = Start(start.experiment.to_toml(), genomes, start.generation, score)
        check_start(experiment, found, "start")
        return found
    genomes = as_genomes(experiment, experiment.space(), start, "start")
    if wrong := out_of_bounds(experiment, genomes, "the start point"):
        remedy = "move it into the bounds: space.repair(start), with an array (starts, genes)"
        raise GaitsimError(wrong, where="start", remedy=remedy)
    return Start(experiment.to_toml(), genomes)


def start_options(start: Any) -> dict[str, Any]:
    """Return the option that chooses a start point of the body by name; {} for other starts."""
    return {"search.start": start} if isinstance(start, str) else {}


def objective_options(objectives: Any) -> dict[str, Any]:
    """Return the options of NSGA-II with objectives; {} for None.

    Args:
        objectives: 'max' or 'min' for each objective by name, or in the order in which a function
            returns objectives without names.
    """
    if objectives is None:
        return {}
    if isinstance(objectives, Mapping):
        named = dict(objectives)
    elif isinstance(objectives, Sequence) and not isinstance(objectives, str):
        named = dict(zip(objective_names(len(objectives)), objectives, strict=True))
    else:
        raise GaitsimError(
            f"{objectives!r:.80} are not objectives",
            where="objectives",
            allowed="'max' or 'min' for each of two or more objectives, such as ('max', 'min') or "
            "{'speed': 'max', 'energy': 'min'}",
        )
    return {"search.plugin": "nsga-2", "search.objectives": named}
