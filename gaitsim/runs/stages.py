"""Training in stages: how a run's experiment changed on the way, and where."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

from pydantic_core import to_jsonable_python

from gaitsim.errors import GaitsimError
from gaitsim.experiment import Experiment, ExperimentOutline, parse_experiment, read_outline
from gaitsim.registry import load_class
from gaitsim.registry.class_validation import PLUGIN
from gaitsim.runs.files.checkpoint import Checkpoint

SCORING = ("organism", "fitness")


@dataclass(frozen=True)
class Change:
    """An option by which two experiments evolve differently.

    Attributes:
        key: of the option, such as `mutation.rate`.
        then: its value before; None where it was not set.
        now: its value after.
        options: where another plugin is chosen, its options.
    """

    key: str
    then: Any
    now: Any
    options: Mapping[str, Any] = field(default_factory=dict)

    def __str__(self) -> str:
        """What changed; of another plugin's options, those that are not as it has them."""
        found = _unusual(self.key.partition(".")[0], self.now, self.options)
        more = ", ".join(f"{name} {_text(value)}" for name, value in found.items())
        now = f"{_text(self.now)} ({more})" if more else _text(self.now)
        return f"{self.key}: {_text(self.then)}, now {now}"

    @property
    def reevaluates(self) -> bool:
        """Whether scores from before it and after it cannot be compared."""
        return self.key.split(".")[0] in SCORING


@dataclass(frozen=True)
class RunStage:
    """Generations of a run that were evolved under one experiment.

    Attributes:
        number: from 1.
        first: its first generation.
        last: its last generation; so far, of the present stage.
        experiment: as resolved TOML.
        versions: of gaitsim, NumPy and each plugin's package then, by name.
        changes: what makes it differ from the stage before.
    """

    number: int
    first: int
    last: int
    experiment: str
    versions: Mapping[str, str]
    changes: tuple[Change, ...]

    @property
    def outline(self) -> ExperimentOutline:
        """The experiment, without its plugins.

        Raises:
            GaitsimError: the checkpoint holds something else.
        """
        return read_outline(self.experiment, f"the experiment of stage {self.number}")

    @property
    def reevaluated(self) -> bool:
        """Whether its scores cannot be compared with those of the stage before."""
        return any(change.reevaluates for change in self.changes)


def stages_of(checkpoint: Checkpoint) -> tuple[RunStage, ...]:
    """Return the stages of the run that a checkpoint belongs to, the present one last."""
    found: list[RunStage] = []
    ended = [(stage.generation, stage.experiment, stage.versions) for stage in checkpoint.stages]
    present = (checkpoint.generation, checkpoint.experiment, checkpoint.versions)
    for last, experiment, versions in (*ended, present):
        first = found[-1].last + 1 if found else 1
        stage = RunStage(len(found) + 1, first, last, experiment, versions, ())
        if found:
            stage = replace(stage, changes=changes(found[-1].outline, stage.outline))
        found.append(stage)
    return tuple(found)


def pending(checkpoint: Checkpoint, experiment: Experiment) -> tuple[Change, ...]:
    """By what an experiment differs from that of a checkpoint: it begins a stage, if by anything.

    Raises:
        PluginError: the experiment cannot be written.
    """
    now = experiment.to_toml()
    if now == checkpoint.experiment:
        return ()
    try:
        # As it reads today: an option that a package has got since then is no change.
        before = parse_experiment(checkpoint.experiment, "the checkpoint").to_toml()
    except GaitsimError:
        before = checkpoint.experiment
    source = "the checkpoint"
    return changes(read_outline(before, source), read_outline(now, source))


def comparable(stages: Sequence[RunStage]) -> int:
    """The first generation whose scores can be compared with those of the last stage."""
    first = stages[-1]
    for stage in reversed(stages):
        first = stage
        if stage.reevaluated:
            break
    return first.first


def changes(then: ExperimentOutline, now: ExperimentOutline) -> tuple[Change, ...]:
    """Return the options by which two experiments evolve differently."""
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
                found.append(Change(name, old.get(key), new.get(key)))
    return tuple(found)


def _unusual(kind: str, plugin: Any, given: Mapping[str, Any]) -> dict[str, Any]:
    """The options of a plugin that are not its defaults; all where it is not installed."""
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
    return "not set" if value is None else str(value)
