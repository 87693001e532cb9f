"""Stages: the changes of a run's experiment, and the generations between them."""

from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field, replace
from typing import Any

from pydantic_core import to_jsonable_python

from gaitsim.errors import GaitsimError
from gaitsim.evaluation import Evaluation
from gaitsim.evaluation.scoring import Evaluate
from gaitsim.evolution import Generation, SearchProgress, reevaluate
from gaitsim.experiment import (
    CONSTRAINTS,
    TRANSFERABILITY,
    Evolution,
    Experiment,
    ExperimentOutline,
    parse_experiment,
    read_outline,
)
from gaitsim.registry import load_class
from gaitsim.registry.options import PLUGIN
from gaitsim.storage.files.checkpoint import Checkpoint, Stage
from gaitsim.toml import brief

SCORING = ("organism", "fitness", "worlds")


@dataclass(frozen=True)
class Change:
    """A changed option that makes two experiments evolve differently.

    Attributes:
        key: key of the option, such as `mutation.rate`.
        then: previous value; None if the option was not set.
        now: new value; None if the option is not set.
        options: options of the new plugin, if the change chooses another plugin.
        redraws: whether the change redraws the worlds.
    """

    key: str
    then: Any
    now: Any
    options: Mapping[str, Any] = field(default_factory=dict)
    redraws: bool = False

    def __str__(self) -> str:
        """Return key and values, with the non-default options of a new plugin."""
        found = _non_default_options(self.key.partition(".")[0], self.now, self.options)
        more = ", ".join(f"{name} {_text(value)}" for name, value in found.items())
        now = f"{_text(self.now)} ({more})" if more else _text(self.now)
        return f"{self.key}: {_text(self.then)}, now {now}"

    @property
    def reevaluates(self) -> bool:
        """Whether scores before and after the change cannot be compared."""
        return self.redraws or self.key.split(".")[0] in (*SCORING, TRANSFERABILITY, CONSTRAINTS)


@dataclass(frozen=True)
class RunStage:
    """Generations of a run that were evolved with one experiment.

    Attributes:
        number: number of the stage, counted from 1.
        first: first generation of the stage.
        last: last generation of the stage; for the current stage, the latest generation.
        experiment: experiment as resolved TOML.
        versions: versions of gaitsim, NumPy and each plugin's package in the stage, by name.
        changes: changes since the previous stage.
    """

    number: int
    first: int
    last: int
    experiment: str
    versions: Mapping[str, str]
    changes: tuple[Change, ...]

    @property
    def outline(self) -> ExperimentOutline:
        """The experiment, without its plugins."""
        return read_outline(self.experiment, f"the experiment of stage {self.number}")

    @property
    def reevaluated(self) -> bool:
        """Whether the stage's scores cannot be compared with those of the previous stage."""
        return any(change.reevaluates for change in self.changes)


def stages_of(checkpoint: Checkpoint) -> tuple[RunStage, ...]:
    """Return the stages of the run of a checkpoint, the current one last."""
    found: list[RunStage] = []
    ends: tuple[Stage | Checkpoint, ...] = (*checkpoint.stages, checkpoint)
    for end in ends:
        first = found[-1].last + 1 if found else 1
        stage = RunStage(len(found) + 1, first, end.generation, end.experiment, end.versions, ())
        if found:
            stage = replace(stage, changes=changes(found[-1].outline, stage.outline))
        found.append(stage)
    return tuple(found)


def pending_changes(checkpoint: Checkpoint, experiment: Experiment) -> tuple[Change, ...]:
    """Return the changes since the experiment of a checkpoint; any change starts a stage."""
    now = experiment.to_toml()
    if now == checkpoint.experiment:
        return ()
    source = "the checkpoint"
    after = read_outline(now, source)
    found = changes(read_outline(checkpoint.experiment, source), after)
    if found:
        # Parsed with the current packages, so that their new options do not count as changes.
        with suppress(GaitsimError):
            before = parse_experiment(checkpoint.experiment, source).to_toml()
            found = changes(read_outline(before, source), after)
    return found


def first_comparable(stages: Sequence[RunStage]) -> int:
    """Return the first generation whose scores are comparable with those of the last one."""
    first = next((stage.first for stage in reversed(stages) if stage.reevaluated), 1)
    last = stages[-1]
    return max(first, last.outline.worlds.first_of_draw(last.last))


def changes(then: ExperimentOutline, now: ExperimentOutline) -> tuple[Change, ...]:
    """Return the changed options that make two experiments evolve differently."""
    before, after = then.search_options(), now.search_options()
    found = []
    for section in sorted({*before, *after}):
        old, new = before.get(section, {}), after.get(section, {})
        if old.get(PLUGIN) != new.get(PLUGIN):
            chosen = {key: value for key, value in new.items() if key != PLUGIN}
            found.append(Change(f"{section}.{PLUGIN}", old.get(PLUGIN), new.get(PLUGIN), chosen))
            continue
        for key in sorted({*old, *new}):
            if old.get(key) != new.get(key):
                name = f"{section}.{key}" if section else key
                redraws = name == "seed" and bool(now.worlds.number)
                found.append(Change(name, old.get(key), new.get(key), redraws=redraws))
    return tuple(found)


def restore_generation(checkpoint: Checkpoint) -> Generation:
    """Return the generation in a checkpoint."""
    reasons = {int(index): reason for index, reason in checkpoint.reasons.items()}
    return Generation(
        number=checkpoint.generation,
        genomes=checkpoint.genomes,
        evaluation=Evaluation(checkpoint.scores, checkpoint.terms, reasons, checkpoint.values),
        progress=SearchProgress(
            evaluations=checkpoint.evaluations,
            best_score=checkpoint.best_score,
            stagnation=checkpoint.stagnation,
            threshold=checkpoint.threshold,
            stage=len(checkpoint.stages) + 1,
            finished=checkpoint.finished,
        ),
        diversity=float("nan"),
        seconds=0.0,
        is_champion=False,
        stop="",
        state=checkpoint.state,
    )


def next_progress(
    checkpoint: Checkpoint, evolution: Evolution, stage_changes: Sequence[Change]
) -> SearchProgress:
    """Return the progress that the generation after a checkpoint starts from."""
    progress = restore_generation(checkpoint).progress
    if not stage_changes:
        return progress
    return begin_stage(progress, evolution, stage_changes, len(checkpoint.genomes))


def begin_stage(
    progress: SearchProgress, evolution: Evolution, stage_changes: Sequence[Change], population: int
) -> SearchProgress:
    """Return the progress at the start of a stage.

    Args:
        progress: progress at the end of the previous stage.
        evolution: options of the stage.
        stage_changes: changes that start the stage.
        population: number of individuals.
    """
    threshold = evolution.fitness_threshold
    reevaluated = any(change.reevaluates for change in stage_changes)
    progress = progress.next_stage(threshold, reevaluated=reevaluated, population=population)
    if any(change.key == "evolution.fitness_threshold" for change in stage_changes):
        progress = replace(progress, threshold=threshold)
    return progress


def begin_again(
    last: Generation, stage: RunStage, experiment: Experiment, evaluate: Evaluate
) -> Generation:
    """Return the last generation of a stage, from which the next stage continues."""
    evolution, changed = experiment.evolution, stage.changes
    progress = begin_stage(last.progress, evolution, changed, len(last.genomes))
    last = replace(last, progress=progress)
    return reevaluate(experiment, last, evaluate) if stage.reevaluated else last


def _non_default_options(kind: str, plugin: Any, given: Mapping[str, Any]) -> dict[str, Any]:
    """Return the options that differ from a plugin's defaults; all if it is not installed."""
    if not given:
        return {}
    try:
        fields = load_class(kind, plugin).model_fields
    except GaitsimError:
        return dict(given)
    defaults = {
        name: to_jsonable_python(
            item.get_default(call_default_factory=True), serialize_unknown=True
        )
        for name, item in fields.items()
    }
    return {name: value for name, value in given.items() if defaults.get(name) != value}


def _text(value: Any) -> str:
    return "not set" if value is None else brief(value)
