"""The Python API: evolve in a loop, open runs, and inspect champions.

`import gaitsim as gs` provides all of it. The command line calls the same functions.
"""

import warnings
from collections.abc import Generator, Iterator, Mapping, Sequence
from contextlib import AbstractContextManager, nullcontext
from pathlib import Path
from typing import TYPE_CHECKING, Any, Self, TypeAlias

import numpy as np
from numpy.typing import ArrayLike, NDArray

from gaitsim import evolution, individual as recorded
from gaitsim.arguments import ARGUMENTS, as_overrides, check_workers, warn
from gaitsim.contracts import Exported, GenomeSpace
from gaitsim.contracts.search import Members
from gaitsim.effort import gait_warnings
from gaitsim.errors import GaitsimError, RunError
from gaitsim.evaluation import Evaluator, Executor
from gaitsim.evaluation.worlds import World, parse_world
from gaitsim.evolution import Generation, island_map
from gaitsim.experiment import Experiment, Overrides
from gaitsim.experiment.loading import check_functions_match, python_experiment, resumed_options
from gaitsim.gait.changed import in_engine, with_damage, with_world
from gaitsim.gait.report import GaitAnalysis
from gaitsim.individual import Member, Numbered, Which
from gaitsim.inspecting import (
    DataFrame,
    InspectedIndividual as Individual,
    data_frame,
    export as _export,
    plot,
)
from gaitsim.live.process import detach, stop
from gaitsim.optimiser import TrackedSearch, objective_options, start_of, start_options
from gaitsim.registry import EXPERIMENTS, entries
from gaitsim.registry.loading import describe_preset
from gaitsim.registry.python_plugins import python_options
from gaitsim.render.notebook import picture, view
from gaitsim.repr_mixin import ReprField, ReprMixin, Table
from gaitsim.sharing.challenge import (
    Challenge,
    CodeVerdict,
    find_challenge,
    verify_challenge,
)
from gaitsim.steering import driven
from gaitsim.storage.background import RunState, last_failure
from gaitsim.storage.creation import create_run
from gaitsim.storage.files.checkpoint import Start
from gaitsim.storage.files.folder import check_root, find_run
from gaitsim.storage.files.history import with_integers
from gaitsim.storage.growing import overview
from gaitsim.storage.manage import (
    read_note,
    read_tags,
    rename_run,
    trash_run,
    write_note,
    write_tags,
)
from gaitsim.storage.overview import list_overviews
from gaitsim.storage.query import check_keys, parse_query, sort_runs
from gaitsim.storage.snapshot import RunSnapshot
from gaitsim.storage.verification import Verdict, verify_run
from gaitsim.storage.writer import RunWriter
from gaitsim.verifying import find_verifier, verify_files

if TYPE_CHECKING:
    from matplotlib.figure import Figure

__all__ = [
    "Individual",
    "Member",
    "Numbered",
    "Run",
    "RunningSearch",
    "analyse",
    "evolve",
    "export",
    "load",
    "picture",
    "presets",
    "runs",
    "share",
    "verify",
    "view",
]


def __dir__() -> list[str]:
    return __all__


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
    objectives: Mapping[str, str] | Sequence[str] | None = None,
    constraints: Mapping[str, float] | None = None,
    start: ArrayLike | recorded.Individual | str | None = None,
    workers: int | None = None,
    dask: str | None = None,
    out: str | Path | None = None,
) -> "RunningSearch":
    """Return a search to loop over, an iterator of finished generations.

    The same experiment, options and seed give bit-identical generations, in Python and on the
    command line, with any number of workers. Evolution starts with the loop.

    Args:
        experiment: name of a preset, path of a TOML file or robot file, or an experiment. None
            evolves `body` without one, with CMA-ES, or with a genetic search if its genes are bits.
        fitness: function that takes a motion and returns the scores, (population,), or a dict of
            such arrays, one per term; or an instance of a subclass of `Fitness`. None uses the
            experiment's fitness.
        body: function that takes genomes, (population, genes), and returns either a dict of
            channels, each (population, …), or the scores, (population,); or an instance of a
            subclass of `Organism`. `scalar` makes one from a function of one genome. Without a
            fitness, several objectives, (population, objectives), or a dict of terms, each
            (population,), are allowed as well. None uses the experiment's body.
        space: genome space of a body that is a function.
        generations: number of generations; None uses the experiment's number.
        population: individuals per generation; None uses the experiment's number or, without an
            experiment, 4 + ⌊3 ln genes⌋ for CMA-ES and 100 for other searches.
        seed: seed of all random numbers; None uses the experiment's seed.
        set: options by key, such as `{"mutation.rate": 0.1}`.
        objectives: 'max' or 'min' for each of two or more objectives, to find trade-offs with
            NSGA-II: terms, measures or 'score' by name, or a sequence for objectives that the body
            returns without names. The search's `members` are the trade-offs.
        constraints: largest value of each constrained term or measure, by name. A body that is a
            function returns them in a dict, besides its 'score'. Individuals that exceed a value
            fail, so the champion is the best feasible individual; CMA-ES approaches it through
            penalties. The option `constraints.at_least` holds smallest values.
        start: genome around which the search begins, (genes,), several of them, (starts, genes),
            or an individual, such as the champion of a run or of another search; or the name of a
            start point of the body, 'body' for all of them, or 'random'. None uses the
            experiment's option `search.start`.
        workers: number of parallel workers; None chooses the body's default, which is 1 for a
            function. Functions and objects are sent to worker processes by cloudpickle.
        dask: address of a Dask scheduler, such as 'tcp://host:8786', whose workers evaluate the
            populations; or 'local' to start Dask workers on this machine.
        out: folder in which to record a run, as `gaitsim run` does; if it exists, a number is
            added to its name. None records nothing.

    Raises:
        ExperimentError: the experiment has problems; one message lists them all.
        GaitsimError: the preset or file does not exist, the folder cannot be created, or `set` or
            `workers` is invalid. The loop raises it if a function cannot be sent to workers.
    """
    check_workers(workers)
    given = as_overrides(
        set,
        {
            "evolution.generations": generations,
            "evolution.population": population,
            "seed": seed,
            "constraints.at_most": constraints,
            **objective_options(objectives),
            **start_options(start),
        },
    )
    experiment = python_experiment(
        experiment, given, ARGUMENTS, fitness=fitness, body=body, space=space
    )
    for warning in experiment.warnings():
        warn(warning)
    found = start_of(experiment, start)
    if out is None:
        return RunningSearch(experiment, None, _unrecorded(experiment, found, workers, dask))
    path = create_run(experiment, Path(out), found)
    writers: list[RunWriter] = []
    return RunningSearch(experiment, path, _recorded(path, writers, workers, dask), writers)


def load(
    run: str | Path, *, fitness: Any = None, body: Any = None, space: GenomeSpace | None = None
) -> "Run":
    """Open a run for reading, by its folder or its name under `runs/`.

    Opening a run never executes code from its files.

    Args:
        run: folder or name of the run.
        fitness: function or object that was given to `evolve`; the run folder does not contain its
            code.
        body: function or object that was given to `evolve`.
        space: genome space of a body that is a function.

    Raises:
        RunError: the run does not exist.
        GaitsimError: the functions differ from those that evolved the run.
    """
    found = Run(find_run(str(run)))
    if sections := python_options(fitness, body, space):
        check_functions_match(sections, found.snapshot.outlines, str(found.path))
    return found


def runs(folder: str | Path = "runs", *, where: str = "", sort: str = "") -> Table["Run"]:
    """Return the runs in a folder, oldest first, as a sequence that is shown as a table.

    Args:
        folder: folder that holds the runs.
        where: query that the runs match, as in `gaitsim runs --where`, such as
            `"spider score>5 -tag:bad"`.
        sort: key of a query to sort by, such as `"score"`, or `"-score"` for descending order.

    Raises:
        GaitsimError: the folder does not exist, or the query or key is invalid.
    """
    check_root(Path(folder))
    every = list_overviews(Path(folder), overview)
    found = parse_query(where).select(every)
    if sort:
        check_keys([sort.removeprefix("-")], every)
        found = sort_runs(found, sort)
    rows = [
        {
            "run": one.name,
            "body": one.plugins.get("organism", ""),
            "fitness": one.plugins.get("fitness", ""),
            "generation": f"{one.generation}/{one.generations}",
            "best": one.best,
            "state": one.state,
            "tags": ", ".join(one.tags),
        }
        for one in found
    ]
    return Table(f"runs in {folder}", [Run(one.path) for one in found], rows)


def presets() -> Table[str]:
    """Return the names of all presets, for `evolve`, as a sequence that is shown as a table."""
    rows = [{"preset": name, "description": describe_preset(name)} for name in entries(EXPERIMENTS)]
    return Table("presets", [row["preset"] for row in rows], rows)


Shown: TypeAlias = "recorded.Individual | Run | str | Path"
"""An individual, or a run, its folder or its name under `runs/`."""


def _opened(subject: Shown) -> "Individual | Run":
    if isinstance(subject, Run):
        return subject
    if isinstance(subject, recorded.Individual):
        return Individual.of(subject)
    if isinstance(subject, str | Path):
        return load(subject)
    raise GaitsimError(
        f"a {type(subject).__name__} is neither a run nor an individual",
        allowed="a run, its folder or its name, or an individual, such as run.champion",
        remedy="use search.run or search.champion of a search",
    )


def analyse(subject: Shown) -> GaitAnalysis:
    """Return the analysis of a gait as a table.

    Args:
        subject: an individual; or a run, its folder or its name under `runs/`, for its champion.

    Raises:
        RunError: the run does not exist or has no champion.
        PluginError: the body cannot be moved or drawn.
    """
    return _opened(subject).analyse()


def share(subject: Shown) -> str:
    """Return the challenge code of an individual, which `verify` verifies on any machine.

    Args:
        subject: an individual; or a run, its folder or its name under `runs/`, for its champion.

    Raises:
        GaitsimError: the individual has no genome or score, or the code would be too large.
        RunError: the run does not exist, has no champion, or is damaged.
    """
    return _opened(subject).share()


def export(subject: Shown, path: str | Path, format: str | None = None, **options: Any) -> Exported:
    """Write an individual or a run to a file, as `gaitsim export` does.

    Args:
        subject: an individual, such as a run's champion, `run.replay(12)` or
            `run.replay(world={...})`; or a run, its folder or its name, for its champion or for a
            format that needs a whole run, such as 'atlas'.
        path: path of the file, or of a folder for some formats, such as 'arduino' and 'c'.
        format: a format listed by `gaitsim export --help`, such as 'mat', 'motion', 'arduino' or
            'ros2'; None takes the format from the file's extension.
        **options: options of the format, such as `calibration`, `keyframe_ms`, `speed`, `clip`,
            `centre`, `min` and `max`; `gaitsim plugins show FORMAT` lists them.

    Returns:
        A description of the file's content, and notices.

    Raises:
        GaitsimError: the extension, the format or an option is unknown, the body lacks something
            that the format needs (such as joint angles), the calibration is invalid, or the gait
            exceeds the limits of the servos.
        RunError: the file cannot be written.
    """
    return _opened(subject).export(path, format, **options)


def verify(
    subject: "str | Path | Challenge | recorded.Individual | Run",
) -> Verdict | CodeVerdict:
    """Verify a run, an individual, a challenge code, a study, a comparison or an adaptation.

    A run's files are compared and its generations reproduced; see `Run.verify`. An individual is
    played, and its score compared. Parts of a study, a comparison or an adaptation are repeated.

    Args:
        subject: a run, its folder or its name under `runs/`; an individual; a challenge; a text or
            file that contains a challenge code; the folder of a study or a comparison; or the file
            of an adaptation in the folder of its atlas.

    Returns:
        The result, whose `identical` says whether all is identical.

    Raises:
        ExperimentError: the experiment has problems, such as a plugin that is not installed.
        GaitsimError: the code is damaged or invalid.
        RunError: the run does not exist or cannot be read.
        PluginError: a plugin fails.
    """
    if isinstance(subject, str | Path):
        challenge = find_challenge(str(subject))
        if challenge is None and find_verifier(subject) is not None:
            return verify_files(str(subject))
        subject = challenge or load(subject)
    if not isinstance(subject, Challenge):
        subject = _opened(subject)
    if isinstance(subject, Individual):
        subject = Challenge.of(subject)
    return subject.verify() if isinstance(subject, Run) else verify_challenge(subject)


class RunningSearch(TrackedSearch, Iterator[Generation]):
    """A search to loop over once, as returned by `evolve`.

    After leaving a loop early, continue with `next(search)` or another loop. `close()`, the end
    of a `with` block or the deletion of the search stops the workers and unlocks the run. A
    recorded search saves its generations then, when `run` is read, and at least every half second
    of computing.

    Attributes:
        experiment: experiment being evolved.
        path: folder of the run; None if nothing is recorded.
        last: last generation yielded; None before the first.
        champion: best individual yielded; None while all have failed.
    """

    def __init__(
        self,
        experiment: Experiment,
        path: Path | None,
        generations: Generations,
        writers: Sequence[RunWriter] = (),
    ) -> None:
        super().__init__(experiment, path)
        self._generations, self._writers = generations, writers

    def __next__(self) -> Generation:
        generation = next(self._generations)
        failed = not np.isfinite(generation.scores).any()
        # With constraints, a search often begins without a feasible individual.
        if generation.number == 1 and failed and not self.experiment.constraints.names:
            reason = generation.evaluation.reasons.get(0, "its score is not finite")
            warn(f"all {len(generation.scores):,} individuals failed (individual 0: {reason})")
        self._add(generation)
        if generation.stop and self.experiment.constraints.names and self.champion is None:
            warn("no individual satisfied all constraints: see search.last.evaluation.reasons")
        return generation

    @property
    def run(self) -> "Run":
        """The recorded run, with all generations yielded so far.

        Raises:
            RunError: nothing is recorded, or it cannot be saved.
        """
        if self.path is None:
            raise RunError(
                "this search is not recorded on disk",
                remedy="give evolve() a folder for the run, such as out='runs/mine'",
            )
        for writer in self._writers:
            writer.save()
        return Run(self.path)

    def close(self) -> None:
        """Stop the workers and unlock the run; the search yields no more generations."""
        self._generations.close()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()


class Run(ReprMixin):
    """A run on disk. Its attributes are re-read at each access, as it may still be evolving.

    Attributes:
        path: folder of the run.
    """

    def __init__(self, path: Path) -> None:
        self.path = path

    @property
    def snapshot(self) -> RunSnapshot:
        """The current state of the run; each of its files is read at most once."""
        return RunSnapshot(self.path)

    @property
    def experiment(self) -> Experiment:
        """The experiment in the run's `experiment.toml`.

        Raises:
            ExperimentError: the experiment is invalid, or a plugin that it needs is not
                installed.
        """
        return self.snapshot.experiment

    @property
    def history(self) -> dict[str, NDArray[Any]]:
        """Columns of `history.csv` by name, each of shape (generations,); {} before the first row.

        `generation`, `stage` and `evaluations` are int64, others float64.

        Raises:
            RunError: the file is damaged.
        """
        return with_integers(self.snapshot.history)

    def to_pandas(self) -> DataFrame:
        """Return `history` as a DataFrame, with a row for each generation.

        Raises:
            GaitsimError: pandas is not installed.
            RunError: the file is damaged.
        """
        return data_frame(self.history)

    @property
    def generation(self) -> int:
        """The last finished generation; 0 before the first."""
        return self.snapshot.generation

    @property
    def state(self) -> RunState | None:
        """The state in `gaitsim runs`, such as `running`; None if the folder does not exist."""
        found = overview(self.path)
        return found.state if found else None

    @property
    def failure(self) -> GaitsimError | None:
        """The error of its last process in the background; None if it did not fail."""
        return last_failure(self.path)

    @property
    def note(self) -> str:
        """The text of the note in the run's folder; '' without a note. Can be assigned.

        Raises:
            RunError: the note cannot be read or written.
        """
        return read_note(self.path)

    @note.setter
    def note(self, text: str) -> None:
        write_note(self.path, text)

    @property
    def tags(self) -> tuple[str, ...]:
        """The tags in the run's folder, sorted."""
        return read_tags(self.path)

    def tag(self, *tags: str) -> None:
        """Add tags to the run.

        Raises:
            RunError: a tag is invalid, or the tags cannot be written.
        """
        write_tags(self.path, {*self.tags, *tags})

    def untag(self, *tags: str) -> None:
        """Remove tags from the run; those that it does not have are ignored."""
        write_tags(self.path, {*self.tags} - {*tags})

    def delete(self) -> None:
        """Move the run to the trash, from which `gaitsim trash restore` restores it for 30 days.

        Raises:
            RunError: a process is evolving the run, or its folder cannot be moved.
        """
        trash_run(self.path)

    def rename(self, name: str) -> None:
        """Rename the run's folder.

        Raises:
            RunError: the name is invalid or taken, or a process is evolving the run.
        """
        self.path = rename_run(self.path, name)

    @property
    def champion(self) -> Individual:
        """The best individual of the generations whose scores are comparable with the last one's.

        Raises:
            RunError: no generation is finished yet, or all individuals failed.
        """
        return self.replay()

    best = champion

    def replay(
        self,
        generation: int | None = None,
        *,
        member: int | None = None,
        damage: Sequence[str] = (),
        world: World | str | None = None,
        engine: str | None = None,
        drive: Sequence[Mapping[str, float]] | None = None,
    ) -> Individual:
        """Return the best individual of a generation, or a member of the front or archive.

        Args:
            generation: generation whose best individual to return; None for the best of the run.
            member: number of a member of the front or archive to return instead, counted from 1.
            damage: damage to the body, such as 'L2 lost' or `["L2 lost", "R1 femur stuck 20"]`.
            world: conditions of the body's world, such as `{"friction": 0.4}` or 'friction 0.4';
                None for the body's own world.
            engine: physics engine for a robot, such as 'bullet'; None for its own.
            drive: commands over time to a robot, such as
                `[{"speed": 0.2}, {"at": 5.0, "turn": 30.0}]`: `at` in s, `speed` and `sideways` in
                m/s, `turn` in °/s, `height` in m; None for the gait as it evolved.

        Raises:
            GaitsimError: both generation and member are given, the body does not support the
                conditions, or it cannot be driven.
            RunError: the generation or member does not exist, or all its individuals failed.
        """
        if generation is not None and member is not None:
            raise GaitsimError("'generation' and 'member' cannot be combined", where=ARGUMENTS)
        found = self.snapshot.individual(generation if member is None else Member(member))
        if damage:
            found = with_damage(found, [damage] if isinstance(damage, str) else damage)
        if world:
            conditions = parse_world([world], "world") if isinstance(world, str) else world
            found = with_world(found, conditions)
        found = in_engine(found, engine) if engine else found
        if drive is None:
            return Individual.of(found)
        found = driven(found, drive)
        for text in gait_warnings(found):
            warn(text)
        return Individual.of(found)

    def analyse(self) -> GaitAnalysis:
        """Return the analysis of the champion's gait; see `Individual.analyse`."""
        return self.champion.analyse()

    def verify(
        self,
        *,
        everything: bool | None = None,
        workers: int | None = None,
    ) -> Verdict:
        """Compare the files, and evolve the run again, like `gaitsim verify`.

        Args:
            everything: whether to evolve the whole run again, up to the first difference; None does
                so if it took at most a minute.
            workers: number of parallel workers; None chooses the body's default.

        Returns:
            The verdict, whose `identical` says whether all is identical.

        Raises:
            RunError: the run cannot be read.
        """
        check_workers(workers)
        return verify_run(self.snapshot, everything=everything, workers=workers)

    def share(self) -> str:
        """Return the challenge code of the champion; see `Individual.share`."""
        return self.champion.share()

    @property
    def members(self) -> Members | None:
        """The front or archive that the search keeps; None for searches without one.

        Raises:
            RunError: no generation is finished yet, or the checkpoint is damaged.
        """
        return self.snapshot.members

    def fingerprint(self) -> str:
        """Return the SHA-256 hash of all results except times.

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
        dask: str | None = None,
    ) -> RunningSearch:
        """Return a search that continues the run, exactly as if it had never stopped.

        Args:
            generations: last generation to evolve, counted from the start of the run; None for the
                number originally planned.
            fitness: function or object, as accepted by `evolve`. If it differs from the run's, a
                new stage starts.
            body: function or object, as accepted by `evolve`. If it differs from the run's, a new
                stage starts.
            space: genome space of a body that is a function.
            set: options by key. Changing an option that affects the evolution starts a new stage.
            workers: number of parallel workers; None chooses the body's default.
            dask: address of a Dask scheduler, or 'local', as accepted by `evolve`.

        Raises:
            ExperimentError: the options have problems. Other errors are raised when the loop
                starts.
        """
        check_workers(workers)
        sections = python_options(fitness, body, space)
        given = as_overrides(set, resumed_options(sections, self.snapshot.outline))
        further = {} if generations is None else {"evolution.generations": generations}
        experiment = self.snapshot.experiment_with(further | given, ARGUMENTS)
        writers: list[RunWriter] = []
        steps = _recorded(self.path, writers, workers, dask, given, generations)
        return RunningSearch(experiment, self.path, steps, writers)

    def detach(
        self,
        generations: int | None = None,
        *,
        set: Mapping[str, Any] | None = None,
        workers: int | None = None,
    ) -> None:
        """Continue the run in the background, in a process that outlives this one.

        Args:
            generations: last generation to evolve, counted from 1; None for the number originally
                planned.
            set: options to change, by key. Changing an option that affects the evolution starts a
                new stage.
            workers: number of parallel workers; None for the body's default.

        Raises:
            ExperimentError: the options have problems.
            GaitsimError: the run is already evolving, or cannot be evolved in the background.
        """
        detach(self.path, overrides=set, generations=generations, workers=workers)

    def stop(self, timeout: float | None = None) -> bool:
        """Save and stop the run after its current generation.

        Args:
            timeout: maximum seconds to wait; None for no limit.

        Returns:
            Whether the run has stopped.

        Raises:
            RunError: the run is not evolving in the background.
        """
        return stop(self.path, timeout)

    def plot(
        self,
        kind: str = "fitness",
        *,
        generations: Sequence[Which] | Which = (),
        dark: bool = False,
        **options: Any,
    ) -> "Figure":
        """Return a plot, like the command `gaitsim plot`.

        Args:
            kind: a kind listed by `gaitsim plot --help`, such as 'fitness' or 'footfall'.
            generations: generations whose best individuals to draw, or members such as
                `gs.Member(3)`; () for the champion.
            dark: whether the background is dark.
            **options: options of the kind, such as `channel`, `components` (a sequence of names),
                `window` (start and end in seconds) and `axes` (two axes of an archive);
                `gaitsim plugins show KIND` lists them.

        Returns:
            The figure, which notebooks show and `savefig` writes.

        Raises:
            GaitsimError: the kind or an option is unknown, or the run or its body lacks the data.
        """
        return plot(kind, self.snapshot, generations, options, dark=dark)

    def export(
        self,
        path: str | Path,
        format: str | None = None,
        *,
        generations: Sequence[Which] | Which = (),
        **options: Any,
    ) -> Exported:
        """Write the champion, or other individuals, to a file; see `gaitsim.export`.

        Args:
            path: path of the file or folder.
            format: format of the file; None takes it from the file's extension.
            generations: generations whose best individuals to write, or members such as
                `gs.Member(3)`, for formats that take several; () for the champion.
            **options: options of the format.
        """
        return _export(self.snapshot, Path(path), format, generations, options)

    def video(
        self,
        path: str | Path,
        *,
        generations: Sequence[Which] | Which = (),
        view: str = "iso",
        size: tuple[int, int] | None = None,
        fps: float | None = None,
        speed: float | None = None,
        dark: bool = False,
        intro: bool = True,
    ) -> Path:
        """Write an MP4 or GIF, depending on the file's extension, like `gaitsim video`.

        Args:
            path: path of the file.
            generations: generations whose best individuals to show, or members such as
                `gs.Member(3)`; several run a race. () shows the champion.
            view: 'iso', 'side', 'top' or 'orbit'.
            size: width and height, pixels.
            fps: frames per second.
            speed: speed of the motion, where 1 is real time. None chooses real time, or slow motion
                for movements too fast for the frame rate, such as a wing beat.
            dark: whether the background is dark.
            intro: whether the video begins with the fitness curve.

        Returns:
            The path of the file.

        Raises:
            GaitsimError: an argument is invalid, or the file cannot be written.
        """
        from gaitsim.render.film import RenderSettings
        from gaitsim.render.video import Video

        path = Path(path)
        theme = "dark" if dark else "light"
        settings = RenderSettings(path.suffix[1:].lower(), size, fps, speed, view, theme, intro)
        video = Video(self.snapshot, generations, settings)
        if video.warning:
            warnings.warn(video.warning, stacklevel=2)
        video.write(path)
        return path

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


# Functions rather than methods, so that a search abandoned in its loop is freed at once, together
# with its workers and the lock of the run.
def _unrecorded(
    experiment: Experiment, start: Start | None, workers: int | None, dask: str | None
) -> Generations:
    with (
        _cluster(dask, workers) as cluster,
        Evaluator(experiment, workers, warn, cluster) as evaluator,
    ):
        evaluator.prepare()
        yield from evolution.evolve(
            experiment,
            evaluator.evaluate,
            starts=start.genomes if start else None,
            parallel_map=island_map(evaluator),
        )


def _recorded(
    path: Path,
    writers: list[RunWriter],
    workers: int | None,
    dask: str | None,
    overrides: Overrides | None = None,
    generations: int | None = None,
) -> Generations:
    with (
        _cluster(dask, workers) as cluster,
        RunWriter.open(
            path,
            overrides=overrides,
            generations=generations,
            workers=workers,
            cluster=cluster,
            on_warning=warn,
        ) as writer,
    ):
        writers.append(writer)
        if writer.warning:
            warn(writer.warning)
        yield from writer.evolve()


def _cluster(dask: str | None, workers: int | None) -> AbstractContextManager[Executor | None]:
    if dask is None:
        return nullcontext()
    from gaitsim.evaluation.dask import DaskExecutor

    return DaskExecutor(dask, workers, warn)
