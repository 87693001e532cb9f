"""The contents of a run folder, read once per file, without loading plugins."""

import os
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gaitsim.errors import CheckpointError, GaitsimError, RunError
from gaitsim.experiment import ExperimentOutline, read_outline
from gaitsim.opening import read_regular
from gaitsim.runs.files.checkpoint import (
    Champion,
    Checkpoint,
    read_champion,
    read_checkpoint,
    read_with_fallback,
)
from gaitsim.runs.files.checksums import RECORD
from gaitsim.runs.files.folder import (
    CHECKPOINT,
    CHECKSUMS,
    EXPERIMENT,
    HISTORY,
    ISLANDS,
    PREVIOUS,
    START,
    command,
    truncation_error,
    unfinished_error,
)
from gaitsim.runs.files.history import (
    figures_of,
    header,
    read_history,
    read_islands,
    read_records,
    terms_of,
    used_terms,
)
from gaitsim.runs.files.tables import damaged_error, line_ends
from gaitsim.runs.manage import read_note
from gaitsim.runs.stages import RunStage, changes, stages_of
from gaitsim.toml import LARGEST


@dataclass(frozen=True)
class RunFiles:
    """The contents of a run folder, whose files are as safe to open as text files.

    Each file is read at its first use and cached. Records after the generation of the checkpoint
    are left out: they belong to a generation that is still being written, or that a killed process
    left incomplete.

    Attributes:
        path: folder of the run.
        keep_damaged: whether to rename a damaged checkpoint, so that the next one does not
            replace it. Only for the writer of the run.
    """

    path: Path
    keep_damaged: bool = False

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

    @property
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
            if not self.stages[-1].first - 1 <= found.generation < self.generation:
                return None, ""
            wrong = self._previous_mismatch(found)
        except GaitsimError as error:
            return None, error.what
        if wrong:
            return None, f"{PREVIOUS} does not belong to the run: {wrong}"
        return found, ""

    def _previous_mismatch(self, previous: Checkpoint) -> str:
        """Return why a previous checkpoint does not belong to this run; '' if it does."""
        now, genomes = self.finished.genomes, previous.genomes
        if (genomes.shape, genomes.dtype) != (now.shape, now.dtype):
            return f"its population has the shape {genomes.shape}, not {now.shape}"
        stage = next(stage for stage in self.stages if previous.generation <= stage.last)
        if changes(read_outline(previous.experiment, PREVIOUS), stage.outline):
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

    @property
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
                remedy="restore all files of the run from one copy",
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
    def start(self) -> Champion | None:
        """The individual that the run started from; None if it started at random."""
        path = self.path / START
        return read_champion(path) if os.path.lexists(path) else None

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
