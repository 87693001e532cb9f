"""The champion of a run, whose performance on the intact body is compared with adaptations."""

from dataclasses import dataclass
from typing import ClassVar

from pydantic import ConfigDict

from gaitsim.plugin import GaitsimError
from gaitsim.plugin.gait import with_body
from gaitsim.plugin.runs import (
    EXACT_KEYS,
    Experiment,
    Individual,
    RunSnapshot,
    find_individual,
    parse_experiment,
)
from gaitsim_adaptation.trials import simulated_robot

SAME = "damage", "duration"  # options of the body that a champion takes from the atlas


@dataclass(frozen=True)
class Reference:
    """A champion's performance on the intact body, in the place of the trials.

    Attributes:
        run: the run of the champion, as given; '' for the champion from which the atlas began.
        performance: performance in the unit of the map, above 0.
    """

    __pydantic_config__: ClassVar[ConfigDict] = EXACT_KEYS

    run: str
    performance: float


def find_reference(
    run: RunSnapshot, champion: str | None, measure: str, *, physics: bool
) -> Reference | None:
    """Return the champion to compare with; None without `champion` if the atlas began from none.

    Args:
        run: run of the atlas.
        champion: the run of the champion, or what else `find_individual` accepts; None for the
            champion from which the atlas began.
        measure: name of the performance measure.
        physics: whether to measure it on the body's twin in rigid-body physics.

    Raises:
        GaitsimError: the champion has another body, walks for another time, or does not walk.
    """
    if champion is not None:
        try:
            found = find_individual(champion)
        except GaitsimError as error:
            error.where = "--champion" if error.where in ("", "--from") else error.where
            raise
        text, genome = found.experiment, found.genome
    elif run.start is not None and run.start.generation:
        text, genome = run.start.experiment, run.start.genomes[0]
    else:
        return None
    experiment, atlas = parse_experiment(text, "the champion"), run.experiment_at(run.generation)
    own, wanted = dict(experiment.organism), dict(atlas.organism)
    shared = {f"organism.{name}": wanted[name] for name in SAME if name in own and name in wanted}
    experiment = with_body(experiment, shared)
    individual, member = Individual(experiment, 0.0, {}, 1, genome), run.individual()
    if _body(experiment) != _body(atlas):
        problem = "has another body than the atlas"
    elif (seconds := _seconds(individual)) != (others := _seconds(member)):
        problem = f"walks for {seconds:g} s, the gaits of the atlas for {others:g} s"
    else:
        robot = simulated_robot(experiment, (), measure, physics=physics)
        if (performance := robot(individual)) > 0:
            return Reference(champion or "", performance)
        problem = f"has no {measure} above 0 on the intact body"
    if champion is None:
        return None
    raise GaitsimError(
        f"the champion of {champion} cannot be compared: it {problem}",
        where="--champion",
        allowed="a run of the same body, with gaits of the same length",
    )


def _body(experiment: Experiment) -> tuple[object, tuple[str, ...]]:
    return experiment.entries["organism"], tuple(experiment.organism.joint_names())


def _seconds(individual: Individual) -> float:
    return (len(individual.skeleton.path) - 1) / individual.skeleton.frame_rate
