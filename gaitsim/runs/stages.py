"""Training in stages: how a run's experiment changed on the way, and where."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from pydantic_core import to_jsonable_python

from gaitsim.errors import GaitsimError
from gaitsim.experiment import Experiment, parse_experiment
from gaitsim.registry import KINDS, load_class
from gaitsim.registry.class_validation import PLUGIN
from gaitsim.runs.files.checkpoint import Checkpoint
from gaitsim.toml import parse

# Options of [evolution] that change what is evolved. The others say how long, and what is kept.
MATTERING = ("population", "elites")
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
    def reevaluated(self) -> bool:
        """Whether its scores cannot be compared with those of the stage before."""
        return any(change.reevaluates for change in self.changes)


def stages_of(checkpoint: Checkpoint) -> tuple[RunStage, ...]:
    """The stages of the run that a checkpoint belongs to, the present one last."""
    found: list[RunStage] = []
    ended = [(stage.generation, stage.experiment, stage.versions) for stage in checkpoint.stages]
    for last, experiment, versions in (
        *ended,
        (checkpoint.generation, checkpoint.experiment, checkpoint.versions),
    ):
        before = found[-1] if found else None
        found.append(
            RunStage(
                number=len(found) + 1,
                first=before.last + 1 if before else 1,
                last=last,
                experiment=experiment,
                versions=versions,
                changes=changes(before.experiment, experiment) if before else (),
            )
        )
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
    return changes(before, now)


def comparable(stages: Sequence[RunStage]) -> int:
    """The first generation whose scores can be compared with those of the last stage."""
    first = stages[-1]
    for stage in reversed(stages):
        first = stage
        if stage.reevaluated:
            break
    return first.first


def changes(then: str, now: str) -> tuple[Change, ...]:
    """By what two experiments, as TOML, evolve differently."""
    before, after = options(then), options(now)
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


def options(experiment: str) -> dict[str, dict[str, Any]]:
    """The options of an experiment that matter to how it evolves, by section; '' has the seed."""
    try:
        tables = parse(experiment, "")
    except GaitsimError:
        return {}
    found = {kind: dict(tables[kind]) for kind in KINDS if isinstance(tables.get(kind), dict)}
    evolution = tables.get("evolution")
    if isinstance(evolution, dict):
        found["evolution"] = {key: evolution[key] for key in MATTERING if key in evolution}
    islands = tables.get("islands")
    if isinstance(islands, dict) and islands.get("number", 1) != 1:  # else they change nothing
        found["islands"] = dict(islands)
    return {"": {"seed": tables.get("seed")}, **found}


def islands_in(experiment: str) -> int:
    """How many islands a resolved experiment has; those of an older gaitsim say nothing of it."""
    number = options(experiment).get("islands", {}).get("number", 1)
    return max(number, 1) if isinstance(number, int) else 1


def threshold_in(experiment: str) -> float | None:
    """The option `evolution.fitness_threshold` of a resolved experiment."""
    try:
        evolution = parse(experiment, "").get("evolution")
    except GaitsimError:
        return None
    found = evolution.get("fitness_threshold") if isinstance(evolution, dict) else None
    return float(found) if isinstance(found, int | float) else None


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
