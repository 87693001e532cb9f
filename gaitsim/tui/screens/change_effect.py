"""The options of a run's experiment and the effect of changing them."""

import shlex
from dataclasses import dataclass

from pydantic import BaseModel

from gaitsim.errors import ExperimentError, GaitsimError
from gaitsim.experiment import TRANSFERABILITY, Overrides
from gaitsim.experiment.overrides import COMMAND_LINE
from gaitsim.registry import options
from gaitsim.registry.options import PLUGIN
from gaitsim.runs.resume import plan_resume
from gaitsim.runs.snapshot import RunSnapshot


@dataclass(frozen=True)
class ChangeableOption:
    """A changeable option: its key, its current value, and its allowed values and meaning."""

    key: str
    value: str
    about: str


def changeable_options(run: RunSnapshot) -> list[ChangeableOption]:
    """Return the changeable options of a run's experiment, those that choose plugins last."""
    experiment = run.experiment
    models: dict[str, BaseModel] = {
        kind: experiment.plugin(kind) for kind in reversed(experiment.kinds)
    }
    models["evolution"] = experiment.evolution
    if experiment.islands.number > 1:
        models["islands"] = experiment.islands
    if experiment.reality is not None:
        models[TRANSFERABILITY] = experiment.transferability
    found = []
    for section, model in models.items():
        given = options.values(model)
        for name, declared in type(model).model_fields.items():
            if f"{section}.{name}" in ("evolution.population", "islands.number"):
                continue  # fixed after the start
            value = (
                options.format_brief(declared, given[name]) if name in given else options.NOT_SET
            )
            about = f"{options.allowed(declared)}. {options.meaning(declared)}"
            found.append(ChangeableOption(f"{section}.{name}", value, about))
    chosen = [
        ChangeableOption(
            f"{kind}.{PLUGIN}", experiment.entries[kind].name, f"name of a different {kind}"
        )
        for kind in experiment.kinds
        if kind != "search"  # fixed too
    ]
    return [*found, *chosen]


def parse_words(text: str) -> tuple[str, ...]:
    """Split a text as a shell does."""
    try:
        return tuple(shlex.split(text))
    except ValueError:
        raise GaitsimError("a quotation mark is not closed") from None


def describe_effect(run: RunSnapshot, overrides: Overrides) -> str:
    """Describe the effect of changes without applying them."""
    plans = plan_resume(run, overrides, generations=None, any_version=True)
    if plans.last is None:
        return "The first generation will have these options." if overrides else ""
    if not plans.changes:
        planned = f"{plans.experiment.evolution.generations:,}"
        return f"No new stage: evolution continues to generation {planned}." if overrides else ""
    changes = "".join(f"▶ {change}\n" for change in plans.changes)
    rescored = "; scores are not comparable to earlier scores" if plans.reevaluates else ""
    return f"{changes}from generation {run.generation + 1}{rescored}"


def format_error(error: GaitsimError) -> str:
    """Return an error's text without the location 'command line'."""
    for one in error.problems if isinstance(error, ExperimentError) else (error,):
        one.where = one.where.removeprefix(COMMAND_LINE).removeprefix(", ")
    return str(error)
