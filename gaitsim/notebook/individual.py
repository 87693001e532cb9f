"""One individual: its genome, and how it moves."""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any

from numpy.typing import NDArray

from gaitsim.contracts import Motion, Skeleton
from gaitsim.errors import GaitsimError, nearest
from gaitsim.experiment import Experiment
from gaitsim.registry import plugin_errors
from gaitsim.repr_mixin import ReprField, ReprMixin
from gaitsim.runs.replay import motion_of, skeleton_of

if TYPE_CHECKING:
    from PIL.Image import Image


@dataclass(frozen=True, eq=False, repr=False)
class Individual(ReprMixin):
    """One individual of a search, such as its champion.

    Attributes:
        experiment: as it was in its generation.
        generation: in which it was found.
        score: its score then.
        genome: (genes,).
    """

    experiment: Experiment
    generation: int
    score: float
    genome: NDArray[Any]

    @cached_property
    def motion(self) -> Motion:
        """Its motion, a population of one: channels by name, (1, frames, …) each.

        Raises:
            PluginError: the body cannot move it.
        """
        return motion_of(self.experiment, self.genome)

    @cached_property
    def skeleton(self) -> Skeleton:
        """Its body over time, as line segments in metres.

        Raises:
            PluginError: the body cannot be drawn.
        """
        return skeleton_of(self.experiment, self.motion)

    @cached_property
    def measures(self) -> dict[str, float]:
        """What its body says of its motion, such as metres walked forward, by name.

        Raises:
            PluginError: the body cannot measure it.
        """
        return {name: value for name, (value, _) in self._measured.items()}

    @cached_property
    def _measured(self) -> dict[str, tuple[float, str]]:
        motion = self.motion
        with plugin_errors(self.experiment.entries["organism"], "measuring the champion"):
            return {
                str(name): (float(measure.values[0]), measure.unit)
                for name, measure in self.experiment.organism.measures(motion).items()
            }

    def picture(
        self,
        seconds: float = 0.0,
        *,
        view: str = "iso",
        size: tuple[int, int] = (640, 360),
        dark: bool = False,
    ) -> "Image":
        """The body at a moment, as an image; a notebook shows it.

        Args:
            seconds: since the motion began.
            view: 'iso' obliquely from the front, 'side', 'top'.
            size: width and height, pixels.
            dark: on a dark ground.

        Raises:
            GaitsimError: there is no such view.
            PluginError: the body cannot be drawn.
        """
        from PIL import Image

        from gaitsim.render.scene import VIEWS, draw

        if view not in VIEWS:
            raise GaitsimError(
                f"there is no view {view!r}",
                allowed=", ".join(VIEWS),
                remedy=nearest(view, list(VIEWS)),
            )
        theme = "dark" if dark else "light"
        return Image.fromarray(draw(self.skeleton, seconds, size=size, view=view, theme=theme))

    def _repr_fields(self) -> Mapping[str, ReprField]:
        return {
            "experiment": self.experiment.name,
            "generation": self.generation,
            "score": self.score,
        }

    def _repr_details(self) -> Mapping[str, ReprField]:
        measured = {
            name if not unit else f"{name}, {unit}": value
            for name, (value, unit) in self._measured.items()
        }
        return {**self._repr_fields(), "measures": measured}
