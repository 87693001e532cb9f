"""Plan how a run continues: check its files, and apply changes to its options.

This module writes nothing. A change that affects the evolution starts a stage with the next
generation. Until that generation is written, the stage is only a difference between
`experiment.toml` and the checkpoint. It survives a killed process, and a later change replaces it.
"""

from dataclasses import dataclass, replace
from typing import TypedDict

from gaitsim.contracts import Array
from gaitsim.errors import ExperimentError, GaitsimError, RunError
from gaitsim.evolution import Generation, stop_reason
from gaitsim.evolution.searching import state_mismatch
from gaitsim.experiment import Experiment, Overrides, Typed
from gaitsim.registry import options
from gaitsim.storage.compatibility import (
    check_population,
    check_size,
    expected_genomes,
    genome_mismatch,
    same_version,
    versions,
)
from gaitsim.storage.files.checkpoint import Checkpoint, Stage
from gaitsim.storage.files.folder import CHECKPOINT, EXPERIMENT, command
from gaitsim.storage.snapshot import RunSnapshot
from gaitsim.storage.stages import Change, next_progress, pending_changes, restore_generation

POPULATION = "evolution.population"


class ResumeOptions(TypedDict, total=False):
    """Options of how a run continues; see `plan_resume`."""

    overrides: Overrides | None
    generations: int | None
    any_version: bool


@dataclass(frozen=True, eq=False)
class ResumePlan:
    """A plan of how a run continues.

    Attributes:
        experiment: experiment of the coming generations.
        last: last generation, with the progress that the next one starts from; None before the
            first.
        start: genomes that the run was started from, (starts, genes); None begins as the
            experiment's option `search.start` says.
        stages: stages that have ended, including the one ended by `changes`.
        changes: changes that start a stage; () if there are none.
        warning: problems of the run that do not prevent it from continuing, or ''.
        edited: whether options were given that change `experiment.toml`.
    """

    experiment: Experiment
    last: Generation | None
    start: Array | None
    stages: tuple[Stage, ...]
    changes: tuple[Change, ...]
    warning: str
    edited: bool

    @property
    def reevaluates(self) -> bool:
        """Whether the last generation is re-evaluated before the next one is bred."""
        return any(change.reevaluates for change in self.changes)


def plan_resume(
    run: RunSnapshot,
    overrides: Overrides | None = None,
    *,
    generations: int | None = None,
    any_version: bool = False,
) -> ResumePlan:
    """Plan how a run continues, without writing anything.

    Args:
        run: run, locked or not.
        overrides: changed options by key.
        generations: last generation to evolve; None for the number in the experiment.
        any_version: whether to accept package versions other than those of the run.
    """
    length = {} if generations is None else {"evolution.generations": generations}
    given = {**length, **(overrides or {})}
    edited = bool(given)
    checkpoint = run.checkpoint
    if checkpoint is None:
        experiment = run.experiment_with(given)
        experiment.check_functions()
        check_size(experiment)
        return ResumePlan(experiment, None, run.starts(experiment), (), (), "", edited)
    experiment = _changed_experiment(run, checkpoint, given)
    _check_state(run, experiment, checkpoint)
    _ = run.history, run.islands  # raises an error if they are damaged
    warnings = [run.warning] if run.warning else []
    other_library = _compare_versions(run, experiment, checkpoint, any_version=any_version)
    found = pending_changes(checkpoint, experiment)
    progress = next_progress(checkpoint, experiment.evolution, found)
    last = replace(restore_generation(checkpoint), progress=progress)
    stages = checkpoint.stages
    if found:
        ended = Stage(checkpoint.generation, checkpoint.experiment, checkpoint.versions)
        stages = (*stages, ended)
        reason = stop_reason(experiment.evolution, last.number, progress, len(last.genomes))
        if overrides and reason:
            raise RunError(
                f"no generation would be evolved with these changes: {reason}",
                where=f"{run.path}, at generation {last.number}",
                remedy=f"raise the limit, for instance evolution.generations={last.number + 100}",
            )
        if not overrides:
            warnings.append(
                f"{EXPERIMENT} was changed after generation {checkpoint.generation} "
                f"({', '.join(map(str, found))}): the run continues with the new options"
            )
    warnings += [other_library] if other_library else []
    return ResumePlan(experiment, last, None, stages, found, "; ".join(warnings), edited)


def _changed_experiment(
    run: RunSnapshot, checkpoint: Checkpoint, overrides: Overrides
) -> Experiment:
    """Return the experiment with the overrides, after checking that the population fits it."""
    number = run.stages[-1].outline.islands.number
    population = len(checkpoint.genomes) // number
    if not overrides:
        run.experiment.check_functions()
        check_population(run.experiment, checkpoint, run.path)
        return run.experiment
    try:
        experiment = run.experiment_with(overrides)
        experiment.check_functions()
    except ExperimentError as error:
        asked = overrides.get(POPULATION, population)
        if isinstance(asked, Typed):
            asked = options.parse_value(asked)
        problems = [*error.problems]
        if isinstance(asked, int) and asked != population:
            problems.append(_size_error(population))
        raise ExperimentError(problems) from None
    problems = []
    search = run.stages[-1].outline.plugins["search"]
    if experiment.entries["search"].name != search:
        problems.append(
            _fixed_option_error("the search of a run cannot change", "search.plugin", search)
        )
    if experiment.evolution.population != population:
        problems.append(_size_error(population))
    if experiment.islands.number != number:
        more = "; topology, every and migrants may be changed" if number > 1 else ""
        what = "the number of islands of a run cannot change"
        problems.append(_fixed_option_error(what, "islands.number", f"{number:,}{more}"))
    wrong = genome_mismatch(experiment, checkpoint.genomes, checkpoint.experiment, "the population")
    if wrong:
        problems.append(
            GaitsimError(
                f"{wrong}; the genomes of a run cannot change",
                where="command line, options of organism",
                allowed=expected_genomes(experiment),
                remedy="start a new run with 'gaitsim run'",
            )
        )
    if problems:
        raise ExperimentError(problems)
    done, generations = checkpoint.generation, experiment.evolution.generations
    if generations < done:
        raise RunError(
            f"the run {run.path} is already at generation {done}",
            allowed=f"evolution.generations of {done} or more",
            remedy=f"start a new run instead: {command('run', run.path / EXPERIMENT)}",
        )
    return experiment


def _check_state(run: RunSnapshot, experiment: Experiment, checkpoint: Checkpoint) -> None:
    """Check that the search, with its possibly changed options, can continue from its state."""
    if wrong := state_mismatch(experiment, checkpoint.state, checkpoint.generation):
        name = experiment.entries["search"].name
        raise RunError(
            f"the search {name!r} cannot continue from the state of the run {run.path}: {wrong}",
            where=str(run.path / CHECKPOINT),
            remedy="resume the run with the original options of the search, or start a new run: "
            "'gaitsim run' with --from starts from this run's champion",
        )


def _size_error(population: int) -> GaitsimError:
    what = "the population size of a run cannot change"
    return _fixed_option_error(what, POPULATION, f"{population:,}")


def _fixed_option_error(what: str, key: str, allowed: str) -> GaitsimError:
    return GaitsimError(
        what,
        where=f"command line, key {key}",
        allowed=allowed,
        remedy="start a new run: 'gaitsim run' with --from starts from this run's champion",
        key=key,
    )


def _compare_versions(
    run: RunSnapshot, experiment: Experiment, checkpoint: Checkpoint, *, any_version: bool
) -> str:
    """Check the versions of the packages in use; return a warning, or ''.

    Packages used only in former stages are ignored.
    """
    now = versions(experiment)
    changed = {
        name: f"{name}: {then} then, {now[name]} now"
        for name, then in checkpoint.versions.items()
        if name in now and not same_version(then, now[name])
    }
    libraries = [changed.pop(name) for name in [*changed] if " " not in name and name != "gaitsim"]
    if changed and not any_version:
        raise RunError(
            f"the run {run.path} was evolved with other versions of packages: "
            + "; ".join(changed.values()),
            remedy="install those versions, or resume with --any-version, which may give other "
            "results",
        )
    return (
        f"different versions of libraries: {'; '.join(libraries)}; the results may differ"
        if libraries
        else ""
    )
