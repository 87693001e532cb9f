"""`measures.json`: the measures of a run's champion, so that it need not be simulated again."""

from dataclasses import dataclass
from pathlib import Path
from typing import ClassVar, Self

from pydantic import ConfigDict, TypeAdapter, ValidationError

from gaitsim.effort import warnings_of
from gaitsim.individual import Individual, Measurement
from gaitsim.opening import read_regular
from gaitsim.storage.files.atomic import write_bytes
from gaitsim.storage.files.folder import MEASURES

LARGEST = 2**20  # bytes


@dataclass(frozen=True)
class Measured:
    """The measures of a champion's motion, and the warnings about it.

    Attributes:
        generation: generation of the champion.
        score: its score.
        measures: the body's measures of its motion by name, with units.
        warnings: warnings about servos that overheat, and those of the body.
    """

    __pydantic_config__: ClassVar[ConfigDict] = ConfigDict(ser_json_inf_nan="constants")

    generation: int
    score: float
    measures: dict[str, Measurement]
    warnings: tuple[str, ...]

    @classmethod
    def of(cls, champion: Individual) -> Self:
        """Simulate a champion.

        Raises:
            PluginError: the body fails.
        """
        found = champion.generation, champion.score, champion.measurements, warnings_of(champion)
        return cls(*found)


_ADAPTER = TypeAdapter(Measured)


def read_measured(run: Path, champion: Individual | None = None) -> Measured | None:
    """Return the stored measures of a champion; None if they are missing or of another one.

    Args:
        run: folder of the run.
        champion: its champion; None for the individual to which the measures belong.
    """
    try:
        found = _ADAPTER.validate_json(read_regular(run / MEASURES, LARGEST))
    except (OSError, ValidationError):
        return None
    if champion is None:
        return found
    same = (found.generation, found.score) == (champion.generation, champion.score)
    return found if same else None


def write_measured(run: Path, champion: Individual) -> None:
    """Simulate a champion and write its measures, unless they are stored."""
    if read_measured(run, champion) is None:
        data = _ADAPTER.dump_json(Measured.of(champion), indent=1) + b"\n"
        write_bytes(run / MEASURES, data, follow=False)
