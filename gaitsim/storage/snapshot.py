"""A run folder, opened once: its files, experiments, stages and individuals."""

import hashlib
import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gaitsim.contracts import Genomes, Members
from gaitsim.errors import CheckpointError, ExperimentError, GaitsimError, RunError, unknown
from gaitsim.evaluation import evaluate
from gaitsim.evolution.searching import members, state_mismatch
from gaitsim.experiment import (
    PORTABLE,
    Experiment,
    ExperimentOutline,
    Overrides,
    parse_experiment,
    read_outline,
)
from gaitsim.experiment.overrides import COMMAND_LINE
from gaitsim.individual import Choice, Individual, Member, Numbered
from gaitsim.opening import read_regular
from gaitsim.registry.entry_points import PythonEntry, find_registered, is_outside
from gaitsim.stopping import stop_reason
from gaitsim.storage.background import BackgroundProcess, background_process, last_failure
from gaitsim.storage.compatibility import (
    check_population,
    check_start,
    missing_packages,
    out_of_bounds,
)
from gaitsim.storage.files.checkpoint import (
    Checkpoint,
    Start,
    read_checkpoint,
    read_start,
    read_with_fallback,
)
from gaitsim.storage.files.folder import (
    ALL_SCORES,
    BESTS,
    CHECKPOINT,
    CHECKSUMS,
    EXPERIMENT,
    HISTORY,
    ISLANDS,
    ONE_COPY,
    PREVIOUS,
    SAVES,
    START,
    command,
    find_run,
    truncation_error,
    unfinished_error,
)
from gaitsim.storage.files.history import (
    best_generation,
    best_terms,
    figures_of,
    header,
    read_history,
    read_islands,
    read_records,
    record_type,
    terms_of,
    used_terms,
)
from gaitsim.storage.files.records import RECORD, SAVE
from gaitsim.storage.files.scores import block_ends, parse_scores, read_block, unpack_block
from gaitsim.storage.files.tables import damaged_error, line_ends
from gaitsim.storage.manage import read_note
from gaitsim.storage.replaying import breed_again
from gaitsim.storage.stages import (
    Change,
    RunStage,
    changes,
    first_comparable,
    next_progress,
    pending_changes,
    stages_of,
)
from gaitsim.toml import LARGEST

NEAR_TOLERANCE = 0.05  # share of an axis


@dataclass(frozen=True)
class RunSnapshot:
    """The state of a run at one moment: its files, experiments, stages and individuals.

    The files are as safe to open as text files; only `experiment` and what depends on it load
    plugins. Each file is read at its first use and cached. Create a new snapshot to see additions
    to a growing run. Records after the generation of the checkpoint are left out: they belong to a
    generation that is still being written, or that a killed process left incomplete.

    Attributes:
        path: folder of the run.
        keep_damaged: whether to rename a damaged checkpoint, so that the next one does not
            replace it. Only for the writer of the run.
    """

    path: Path
    keep_damaged: bool = False

    @classmethod
    def find(cls, reference: str) -> "RunSnapshot":
        """Return the run with a name in `runs/`, or in a folder."""
        return cls(find_run(reference))

    def reopened(self) -> "RunSnapshot":
        """Return the current state of the run."""
        return RunSnapshot(self.path)

    @cached_property
    def experiment_text(self) -> str:
        """The resolved experiment as TOML."""
        path = self.path / EXPERIMENT
        try:
            return read_regular(path, LARGEST).decode()
        except (OSError, UnicodeDecodeError) as error:
            reason = getattr(error, "strerror", None) or "it is not a text file in UTF-8"
            raise RunError(
                f"cannot read {path}: {reason}",
                remedy="restore it from a copy of the run; the checkpoint also contains its text",
            ) from None

    @property
    def outline(self) -> ExperimentOutline:
        """The experiment, without its plugins."""
        return read_outline(self.experiment_text, str(self.path / EXPERIMENT))

    @cached_property
    def _checkpoint_and_warning(self) -> tuple[Checkpoint | None, str]:
        current, previous = self.path / CHECKPOINT, self.path / PREVIOUS
        if not os.path.lexists(current) and not os.path.lexists(previous):
            self._check_no_generation()
            return None, ""
        checkpoint, warning = read_with_fallback(current, previous, rename=self.keep_damaged)
        return checkpoint, warning or ""

    @cached_property
    def checkpoint(self) -> Checkpoint | None:
        """The latest undamaged checkpoint; None before the first generation."""
        return self._checkpoint_and_warning[0]

    @property
    def warning(self) -> str:
        """The reason why `checkpoint` is the previous one; '' if it is the latest."""
        return self._checkpoint_and_warning[1]

    @cached_property
    def _previous(self) -> tuple[Checkpoint | None, str]:
        """The checkpoint saved before the last one, and why it cannot be read."""
        path = self.path / PREVIOUS
        # A run of one generation and a copy by `gaitsim fork` have none. If the last checkpoint
        # is damaged, the previous one already replaces it.
        if self.warning or not os.path.lexists(path):
            return None, ""
        try:
            found = read_checkpoint(path)
            # Every stage is saved at its end, so that an earlier checkpoint comes from elsewhere.
            first, last = max(self.stages[-1].first - 1, 1), self.generation - 1
            if first <= found.generation <= last:
                wrong = self._mismatch(found, PREVIOUS)
            else:
                wrong = f"it is of generation {found.generation}, not of {first} to {last}"
        except GaitsimError as error:
            return None, error.what
        if wrong:
            return None, f"{PREVIOUS} does not belong to the run: {wrong}"
        return found, ""

    def _mismatch(self, earlier: Checkpoint, name: str) -> str:
        """Return why an earlier checkpoint does not belong to this run; '' if it does."""
        now, genomes = self.finished.genomes, earlier.genomes
        if (genomes.shape, genomes.dtype) != (now.shape, now.dtype):
            return f"its population has the shape {genomes.shape}, not {now.shape}"
        stage = next(stage for stage in self.stages if earlier.generation <= stage.last)
        if changes(read_outline(earlier.experiment, name), stage.outline):
            return "its experiment differs"
        return ""

    @property
    def previous(self) -> Checkpoint | None:
        """The checkpoint saved before the last one; None if missing or unreadable."""
        return self._previous[0]

    @property
    def damaged(self) -> tuple[str, ...]:
        """One message for each checkpoint that cannot be read."""
        return tuple(text for text in (self.warning, self._previous[1]) if text)

    @property
    def finished(self) -> Checkpoint:
        """The latest undamaged checkpoint, which must exist."""
        if self.checkpoint is None:
            raise unfinished_error(self.path)
        return self.checkpoint

    @cached_property
    def generation(self) -> int:
        """The number of the last finished generation; 0 before the first."""
        return self.checkpoint.generation if self.checkpoint else 0

    @cached_property
    def stages(self) -> tuple[RunStage, ...]:
        """The stages of the run, the current one last; () before the first generation."""
        if self.checkpoint is None:
            return ()
        stages = stages_of(self.checkpoint)
        outline, found = stages[-1].outline, len(self.checkpoint.genomes)
        expected = outline.evolution.population * outline.islands.number
        if found != expected:
            raise CheckpointError(
                f"the checkpoint contradicts itself: it has {found:,} individuals, but its "
                f"experiment has {expected:,}",
                where=str(self.path / CHECKPOINT),
                remedy=ONE_COPY,
            )
        return stages

    @cached_property
    def history(self) -> dict[str, NDArray[np.float64]]:
        """Columns of the history by name, each of shape (generations,); {} before the first row."""
        if self.checkpoint is None:
            return {}
        columns = read_history(self.path / HISTORY, self.generation)
        columns = {name: self._cut(values, HISTORY) for name, values in columns.items()}
        if not columns:
            raise truncation_error(self.path, HISTORY, 0, self.generation)
        terms = [*self.checkpoint.terms]
        for name in terms:
            if name not in terms_of(columns):
                raise damaged_error(
                    self.path / HISTORY, f"it lacks the term {name!r} of the checkpoint"
                )
        # Leave out the columns of a stage whose first generation was never finished.
        return {
            name: columns[name] for name in header(used_terms(columns, terms), figures_of(columns))
        }

    def _cut(self, records: NDArray[Any], name: str) -> NDArray[Any]:
        """Return the records of a file up to the checkpoint's generation."""
        if len(records) < self.generation:
            raise truncation_error(self.path, name, len(records), self.generation)
        return records[: self.generation]

    @cached_property
    def islands(self) -> NDArray[np.float64]:
        """The best score of each island by generation, (generations, islands).

        For a run of one population, these are the best scores of the history.
        """
        if self.checkpoint is None:
            return np.empty((0, 1))
        number = self.stages[-1].outline.islands.number
        if number == 1:
            return self.history["best"][:, None]
        return self._cut(read_islands(self.path / ISLANDS, number, self.generation), ISLANDS)

    @cached_property
    def checksums(self) -> NDArray[Any]:
        """The checksums of the generations, which may be fewer than the generations."""
        return read_records(self.path / CHECKSUMS, RECORD, self.generation)

    @cached_property
    def saves(self) -> NDArray[np.int64]:
        """The generation of each save that was begun, the last one perhaps not finished."""
        return read_records(self.path / SAVES, SAVE)

    @cached_property
    def start(self) -> Start | None:
        """The individual or genomes that the run was started from; None without any."""
        path = self.path / START
        return read_start(path) if os.path.lexists(path) else None

    def starts(self, experiment: Experiment) -> Genomes | None:
        """Return the genomes that the run was started from, (starts, genes), or None."""
        try:
            start = self.start
        except CheckpointError as error:
            error.remedy = "restore it from a copy; the run cannot start as planned without it"
            raise
        if start is None:
            return None
        check_start(experiment, start, str(self.path / START))
        return start.genomes

    @cached_property
    def note(self) -> str:
        """The user's note; '' without one."""
        return read_note(self.path)

    def _check_no_generation(self) -> None:
        """Check that a run without a checkpoint never had one.

        The history may have one row, as a row is written before its checkpoint.
        """
        if len(line_ends(self.path / HISTORY, 2)) > 2:
            raise CheckpointError(
                f"{CHECKPOINT} and {PREVIOUS} are missing, but {HISTORY} has generations",
                where=str(self.path),
                remedy="restore them from a copy; to start again: "
                + command("run", self.path / EXPERIMENT),
            )

    @cached_property
    def experiment(self) -> Experiment:
        """The experiment, with its plugins loaded."""
        return self.experiment_with()

    def experiment_with(
        self, overrides: Overrides | None = None, place: str = COMMAND_LINE
    ) -> Experiment:
        """Return the experiment with some options changed and its plugins loaded."""
        try:
            source = str(self.path / EXPERIMENT)
            return parse_experiment(self.experiment_text, source, overrides, place)
        except ExperimentError as error:
            try:
                versions = self.checkpoint.versions if self.checkpoint else {}
            except RunError:
                versions = {}
            raise ExperimentError([*error.problems, *missing_packages(versions)]) from None

    @property
    def outlines(self) -> list[ExperimentOutline]:
        """The experiment of each stage, followed by the current one."""
        return [*(stage.outline for stage in self.stages), self.outline]

    @property
    def outside(self) -> tuple[PythonEntry, ...]:
        """The Python code outside packages in any stage, which the run's files cannot reproduce."""
        plugins = [plugin for outline in self.outlines for plugin in outline.plugins.items()]
        return tuple(
            find_registered(kind, name) for kind, name in dict.fromkeys(plugins) if is_outside(name)
        )

    def stage_at(self, generation: int) -> RunStage:
        """Return the stage that a generation belongs to."""
        last = self.finished.generation
        for stage in self.stages:
            if stage.first <= generation <= stage.last:
                return stage
        raise RunError(
            f"the run {self.path} has no generation {generation}", allowed=f"1 to {last}"
        )

    def experiment_at(self, generation: int) -> Experiment:
        """Return the experiment that evolved `generation`, with its plugins loaded."""
        stage = self.stage_at(generation)
        text = stage.experiment
        if text not in self._parsed:
            if not changes(stage.outline, self.outline):
                return self.experiment
            source = f"{self.path}, the experiment of stage {stage.number}"
            try:
                self._parsed[text] = parse_experiment(text, source)
            except ExperimentError as error:
                missing = missing_packages(stage.versions)
                raise ExperimentError([*error.problems, *missing]) from None
        return self._parsed[text]

    @property
    def portability(self) -> str:
        """The class of the results and its meaning; of several stages, the least portable one."""
        experiments = [self.experiment_at(stage.last) for stage in self.stages]
        found = [one.portability for one in experiments or [self.experiment]]
        return next((text for text in found if not text.startswith(PORTABLE)), found[-1])

    @cached_property
    def _parsed(self) -> dict[str, Experiment]:
        return {}

    @cached_property
    def pending(self) -> tuple[Change, ...]:
        """The changes since the last generation, which start a stage with the next one."""
        if self.checkpoint is None or self.checkpoint.experiment == self.experiment_text:
            return ()
        return pending_changes(self.checkpoint, self.experiment)

    @property
    def stop_reason(self) -> str:
        """The stop condition that holds; '' if none. Plugins are not loaded."""
        checkpoint = self.checkpoint
        if checkpoint is None:
            return ""
        evolution = self.outline.evolution
        found = changes(self.stages[-1].outline, self.outline)
        progress = next_progress(checkpoint, evolution, found)
        return stop_reason(evolution, checkpoint.generation, progress, len(checkpoint.genomes))

    @property
    def process(self) -> BackgroundProcess | None:
        """The process that now evolves the run in the background, or waits to."""
        return background_process(self.path)

    @property
    def failure(self) -> GaitsimError | None:
        """The error of the last process in the background; None if it did not fail."""
        return last_failure(self.path)

    @property
    def first_comparable(self) -> int:
        """The first generation whose scores are comparable with those of the last one.

        Earlier scores come from another fitness, body or set of worlds.
        """
        _ = self.finished
        return first_comparable(self.stages)

    @cached_property
    def bests(self) -> NDArray[Any]:
        """The best `score` and `genome` of every generation g, at index g − 1."""
        checkpoint, space = self.checkpoint, self.experiment.space()
        if checkpoint is None:
            return np.empty(0, record_type(space))
        check_population(self.experiment, checkpoint, self.path)
        return self._cut(
            read_records(self.path / BESTS, record_type(space), self.generation), BESTS
        )

    @cached_property
    def _score_ends(self) -> list[int]:
        """The ends of the blocks of all generations in `scores.bin`, after a first 0."""
        ends = block_ends(self.path / ALL_SCORES, self.generation)
        if len(ends) < self.generation:
            raise truncation_error(self.path, ALL_SCORES, len(ends), self.generation)
        return [0, *ends]

    def score_block(self, generation: int) -> bytes:
        """Return the block of a generation in `scores.bin`."""
        start, end = self._score_ends[generation - 1 : generation + 1]
        return read_block(self.path / ALL_SCORES, start, end, len(self.finished.genomes))

    def score_bytes(self, generation: int) -> bytes:
        """Return the numbers of a generation in `scores.bin`, as `scores_of` returns them."""
        block = self.score_block(generation)
        return unpack_block(self.path / ALL_SCORES, block, len(self.finished.genomes))

    def scores(self, generation: int) -> NDArray[np.float64]:
        """Return the scores of all individuals, then values, (1 + values, individuals)."""
        individuals, path = len(self.finished.genomes), self.path / ALL_SCORES
        return parse_scores(path, self.score_bytes(generation), individuals)

    def best_genome(self, generation: int) -> NDArray[Any]:
        """Return the genome of a generation's best individual, (genes,)."""
        experiment = self.experiment_at(generation)
        genome: NDArray[Any] = self.bests[generation - 1]["genome"]
        genome = genome.astype(experiment.space().dtype)
        wrong = out_of_bounds(experiment, genome[None], f"the best of generation {generation}")
        if wrong:
            raise damaged_error(self.path / BESTS, wrong, ONE_COPY)
        return genome

    @property
    def best_generation(self) -> int | None:
        """The generation of the champion; None before the first, or if all individuals failed."""
        if self.checkpoint is None:
            return None
        return best_generation(self.history["best"], self.first_comparable)

    @cached_property
    def members(self) -> Members | None:
        """The front or archive after the last generation; None for searches without one."""
        checkpoint = self.finished
        experiment = self.experiment_at(checkpoint.generation)
        if not experiment.search.keeps:
            return None
        wrong = state_mismatch(experiment, checkpoint.state, checkpoint.generation)
        found = None if wrong else members(experiment, checkpoint.state)
        if found is not None:
            wrong = out_of_bounds(experiment, found.genomes, "a member")
        if wrong:
            what = f"the {experiment.search.keeps} of the run is damaged: {wrong}"
            raise RunError(what, where=str(self.path / CHECKPOINT), remedy=ONE_COPY)
        return found

    def individual(self, which: Choice = None) -> Individual:
        """Return the best individual of a generation or of all generations, or a member.

        The best of all generations is chosen only among those comparable with the last one.
        """
        if isinstance(which, Mapping):
            found = self._member(member := self._nearest(which))
            return replace(found, note=self._asked(which, member))
        if isinstance(which, Numbered):
            return self._numbered(which)
        return self._member(which) if isinstance(which, Member) else self._best(which)

    def individuals(self, which: Sequence[Choice] | Choice = ()) -> tuple[Individual, ...]:
        """Return the individual of each choice; that of the best of all generations for none."""
        several = (which,) if isinstance(which, int | Member | Numbered | Mapping | None) else which
        numbered = [one for one in several if isinstance(one, Numbered)]
        if len(numbered) > 1 and all(map(self._exists, numbered)):  # otherwise, one after another
            self._breed(numbered)
        return tuple(map(self.individual, several or (None,)))

    def _nearest(self, values: Mapping[str, float]) -> Member:
        """Return the best member near given values, by axis.

        The distance of a member from the values is the largest of its distances along the axes,
        each as a share of the axis. All members within `NEAR_TOLERANCE` of the smallest distance
        count as near; the one with the highest score is chosen.
        """
        found = self.members
        if found is None or not len(found.scores):
            return Member(1)  # does not exist, so `_member` raises the error
        distance = np.zeros(len(found.scores))
        for name, value in values.items():
            if name not in found.values:
                raise unknown("axis", name, found.values, where=f"the members of {self.path}")
            known = found.values[name]
            ends = known if found.borders is None else found.borders[name]
            width = float(np.max(ends) - np.min(ends)) or 1.0
            distance = np.maximum(distance, np.abs(known - value) / width)
        near = np.flatnonzero(distance <= distance.min() + NEAR_TOLERANCE)
        return Member(int(near[np.argmax(found.scores[near])]) + 1)

    def _asked(self, values: Mapping[str, float], member: Member) -> str:
        """Return the values of a member that differ from those asked for, as a note."""
        known = self.required_members("").values
        found = {name: float(known[name][member.number - 1]) for name in values}
        return ", ".join(
            f"{name} {value:.3g}, not {values[name]:g}"
            for name, value in found.items()
            if abs(value - values[name]) > 1e-9
        )

    def required_members(self, remedy: str) -> Members:
        """Return the members; without any, raise an error with a remedy."""
        found = self.members
        if found is None:
            raise RunError(
                f"the run {self.path} has no members: its search keeps neither a front nor an "
                "archive",
                remedy=remedy,
            )
        return found

    def _member(self, which: Member) -> Individual:
        found = self.required_members("omit the member to use the champion")
        count, index = len(found.scores), which.number - 1
        if not 0 <= index < count:
            raise RunError(
                f"the run {self.path} has no {which}",
                allowed=f"1 to {count}" if count else "none, because every individual failed",
                remedy=f"list them: {command('members', self.path)}",
            )
        generation = self.finished.generation
        individual = Individual(
            self.experiment_at(generation),
            float(found.scores[index]),
            {},
            generation,
            found.genomes[index],
            self.path,
            member=which,
        )
        return replace(individual, terms=individual.evaluated_terms())

    def _numbered(self, which: Numbered) -> Individual:
        """Return any individual, whose generation is bred again."""
        self.stage_at(which.generation)
        if not self._exists(which):
            raise RunError(
                f"generation {which.generation} of the run {self.path} has no individual "
                f"{which.number}",
                allowed=f"1 to {len(self.finished.genomes)}",
            )
        if which not in self._bred:
            self._breed([which])
        if which not in self._bred:
            raise RunError(f"the search of the run {self.path} has no centre")
        score, genome = self._bred[which]
        found = Individual(
            self.experiment_at(which.generation),
            score,
            {},
            which.generation,
            genome,
            self.path,
            member=which,
        )
        return replace(found, terms=found.evaluated_terms())

    def _exists(self, which: Numbered) -> bool:
        number = 0 <= which.number <= len(self.finished.genomes)
        return number and 1 <= which.generation <= self.generation

    @cached_property
    def _bred(self) -> dict[Numbered, tuple[float, NDArray[Any]]]:
        """Score and genome of individuals whose generations were bred again."""
        return {}

    def _breed(self, wanted: Sequence[Numbered]) -> None:
        """Breed generations again, and keep the score and genome of the wanted individuals."""
        for bred in breed_again(self, max(one.generation for one in wanted)):
            generation = bred.generation
            for one in wanted:
                at = one.number - 1
                if one.generation == generation.number and one.number:
                    self._bred[one] = float(generation.scores[at]), generation.genomes[at]
                elif one.generation == generation.number and bred.centre is not None:
                    experiment = self.experiment_at(one.generation)
                    score = evaluate(experiment, bred.centre[None], one.generation).scores[0]
                    self._bred[one] = float(score), bred.centre

    def _best(self, generation: int | None) -> Individual:
        bests = self.bests  # read first, for the clearest error if the run was deleted
        self.stage_at(self.finished.generation if generation is None else generation)
        first = self.first_comparable
        number = generation or first + int(np.argmax(bests["score"][first - 1 :]))
        best, recorded = bests[number - 1], self.history["best"][number - 1]
        if best["score"] != recorded:
            raise RunError(
                f"the best score of generation {number} is {best['score']:g} in {BESTS}, but "
                f"{recorded:g} in {HISTORY}",
                where=str(self.path),
                remedy=ONE_COPY,
            )
        if not np.isfinite(best["score"]):
            which = f"generation {generation}"
            if generation is None:
                which = "every generation" if first == 1 else f"every generation from {first}"
            raise RunError(
                f"the run {self.path} has no champion: every individual of {which} failed",
                remedy=f"see why: {command('show', self.path)}",
            )
        return Individual(
            self.experiment_at(number),
            float(best["score"]),
            best_terms(self.history, number),
            number,
            self.best_genome(number),
            self.path,
        )

    def fingerprint(self) -> str:
        """Return the SHA-256 hash of population, scores, state of the search, history and stages.

        Times and column names are left out.
        """
        checkpoint = self.finished
        digest = hashlib.sha256()
        digest.update(checkpoint.genomes.tobytes())
        digest.update(checkpoint.scores.tobytes())
        for name, values in sorted(checkpoint.state.items()):
            digest.update(f"{name} {values.shape}".encode() + values.tobytes())
        for name, values in self.history.items():
            if name != "seconds":
                digest.update(values.tobytes())
        for stage in self.stages if len(self.stages) > 1 else ():
            digest.update(f"{stage.first} {stage.outline.search_options()}".encode())
        return digest.hexdigest()
