"""A video of an imitator: its error during training, then its gait beside the expert's."""

from functools import partial

from gaitsim.evaluation.playing import require_play
from gaitsim.imitation.imitating import Result
from gaitsim.individual import Individual
from gaitsim.render.film import Film
from gaitsim.render.individual_clip import clip_of
from gaitsim.render.plots.imitation import errors_figure
from gaitsim.render.plots.labels import format_score
from gaitsim.render.scene.clip import Clip
from gaitsim.render.settings import RenderSettings


def imitation_film(result: Result, settings: RenderSettings | None = None) -> Film:
    """Return a video that shows the training error, then the imitator beside its expert.

    Args:
        result: result of the training.
        settings: size, speed, view and colours; None for the defaults of `RenderSettings`.
    """
    expert, training = result.expert, result.settings
    require_play(expert.experiment)
    assert expert.individual is not None, "a body that plays the imitator plays its expert"
    assert result.played is not None, "require_play checks that the body can play"
    generation = "" if expert.file else f", {expert.individual.label}"
    clips = [
        _clip(expert.individual, "expert", generation),
        _clip(result.played, "imitator"),
    ]
    errors = {training.activation: result.errors}
    return Film(
        clips,
        settings or RenderSettings(),
        (f"imitator of {expert.name}", (f"network {result.sizes}, {training.activation}",)),
        partial(errors_figure, errors, result.heading),
        leader=1,
    )


def _clip(individual: Individual, role: str, which: str = "") -> Clip:
    return clip_of(individual, role + which, format_score(individual), tag=role)
