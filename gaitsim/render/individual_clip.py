"""The clip of an individual."""

from gaitsim.errors import GaitsimError
from gaitsim.individual import Individual
from gaitsim.registry import contract_error
from gaitsim.render.scene.clip import Clip


def clip_of(individual: Individual, title: str = "", details: str = "", tag: str = "") -> Clip:
    """Return the clip of an individual, with its captions."""
    skeleton = individual.skeleton
    try:
        return Clip(skeleton, title, details, tag)
    except GaitsimError as error:
        entry = individual.experiment.entries["organism"]
        raise contract_error(
            entry, f"has a skeleton that cannot be drawn: {error.what}", error.allowed
        ) from None
