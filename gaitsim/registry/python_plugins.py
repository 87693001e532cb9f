"""Plugin classes that wrap functions passed in Python, and placeholders for missing ones."""

from collections.abc import Callable, Iterator, Mapping
from typing import Any, ClassVar

import numpy as np
from pydantic import ConfigDict

from gaitsim.contracts import (
    Array,
    Channel,
    Fitness,
    Genomes,
    GenomeSpace,
    Motion,
    Organism,
    Plugin,
    Skeleton,
)
from gaitsim.errors import GaitsimError
from gaitsim.registry.plugin_context import contract_error
from gaitsim.registry.python_entries import PythonEntry


class UnknownChannelError(KeyError):
    """Raised if a fitness reads a channel that the motion does not have."""

    def __str__(self) -> str:
        return str(self.args[0])


class ReadOnlyMotion(Motion):
    """A motion whose arrays are read-only."""

    def __init__(self, motion: Motion) -> None:
        super().__init__(motion.frame_rate, {}, failures=motion.failures)
        self._original = motion

    def __getitem__(self, name: str) -> Array:
        if name not in self:
            known = ", ".join(self) or "none"
            raise UnknownChannelError(f"the motion has no channel {name!r}; it has {known}")
        view = np.asarray(self._original[name]).view()
        view.flags.writeable = False
        return view

    def __setitem__(self, name: str, values: object) -> None:
        raise ValueError("the motion is read-only")

    def __contains__(self, name: object) -> bool:
        return name in tuple(self._original)

    def __iter__(self) -> Iterator[str]:
        return iter(self._original)

    @property
    def population(self) -> int:
        """The number of individuals."""
        return self._original.population


class FunctionFitness(Fitness):
    """A fitness that calls a function for its terms."""

    entry: ClassVar[PythonEntry]
    function: ClassVar[Callable[[Motion], Any]]
    needs: ClassVar[tuple[str, ...]] = ()

    def terms(self, motion: Motion) -> dict[str, Array]:
        """Return the function's terms; a single array becomes a term named after the function."""
        try:
            found = type(self).function(ReadOnlyMotion(motion))
        except ValueError as error:
            if "read-only" not in str(error):
                raise
            allowed = "a copy of a channel, as in motion['feet'].copy()"
            modified = contract_error(self.entry, "modifies the motion passed to it", allowed)
            modified.where = self.entry.place_of(error)
            raise modified from error
        return dict(found) if isinstance(found, Mapping) else {self.entry.label: found}


class ScoreChannel(Fitness):
    """The fitness of a body that computes its own score in the channel `score`."""

    needs: ClassVar[tuple[str, ...]] = ()

    def terms(self, motion: Motion) -> dict[str, Array]:
        """Return the channel `score` as the only term."""
        if "score" not in motion:
            raise GaitsimError(
                "no fitness was passed, and the body returned no score",
                where=f"the body returned the channels {', '.join(motion)}",
                allowed="a channel 'score', or one array (population,), which is the score",
                remedy="return a score from the body, or pass a function as fitness=…",
            )
        return {"score": motion["score"]}


class FunctionBody(Organism):
    """A body that calls a function for its channels."""

    entry: ClassVar[PythonEntry]
    function: ClassVar[Callable[[Genomes], Any]]
    space: ClassVar[GenomeSpace]
    channels: ClassVar[Mapping[str, Channel]] = {}

    def genome_space(self) -> GenomeSpace:
        """Return the genome space that was passed with the function."""
        return type(self).space

    def move(self, genomes: Genomes) -> Motion:
        """Return the function's result as a motion; a single array becomes the channel `score`."""
        found = type(self).function(genomes)
        if isinstance(found, Motion):
            return found
        channels = found if isinstance(found, Mapping) else {"score": found}
        if channels is not found and np.ndim(self._channel("score", found, len(genomes))) != 1:
            what = f"returned an array of shape {np.shape(found)}"
            expected = f"a score for each individual, (population,) = ({len(genomes)},)"
            raise contract_error(self.entry, what, f"{expected}, or a dict of channels")
        if not channels:
            raise contract_error(self.entry, "returned no channel", _CHANNELS)
        return Motion(1.0, {k: self._channel(k, v, len(genomes)) for k, v in channels.items()})

    def _channel(self, name: Any, values: Any, population: int) -> Array:
        if not (isinstance(name, str) and name.isprintable() and 0 < len(name) <= 200):
            raise contract_error(self.entry, f"names a channel {name!r:.80}", "a printable string")
        try:
            array = np.asarray(values)
        except ValueError:  # lists of different lengths
            array = np.empty(0, object)
        if array.dtype.kind not in "fiub":
            what = f"returned {values!r:.80} for the channel {name!r}"
            raise contract_error(self.entry, what, "real numbers")
        if array.shape[:1] != (population,):
            what = f"returned the channel {name!r} with the shape {array.shape}"
            raise contract_error(self.entry, what, f"{_FIRST} ({population}, …)")
        return array

    def skeleton(self, motion: Motion, individual: int) -> Skeleton:
        """Raise an error, because a function cannot be drawn."""
        raise GaitsimError(
            f"the {self.entry} cannot be drawn: it is a function without a skeleton",
            allowed="a body with a skeleton",
            remedy="write a subclass of gs.Organism with the method skeleton()",
        )


_FIRST = "an array whose first axis is the population,"
_CHANNELS = f"a dict of channels, or one array: {_FIRST[:-1]}"


def placeholder(entry: PythonEntry) -> type[Plugin]:
    """Return a class that accepts any options, and raises an error when its code is needed."""
    base = MissingBody if entry.kind == "organism" else MissingFitness
    return type(base.__name__, (base,), {"entry": entry, "__module__": __name__})


class MissingFitness(Fitness):
    """A placeholder for a fitness that is not registered in this process."""

    model_config = ConfigDict(extra="allow")

    entry: ClassVar[PythonEntry]
    needs: ClassVar[tuple[str, ...]] = ()

    def terms(self, motion: Motion) -> dict[str, Array]:
        """Raise the error of the missing function."""
        raise self.entry.missing_error


class MissingBody(Organism):
    """A placeholder for a body that is not registered in this process."""

    model_config = ConfigDict(extra="allow")

    entry: ClassVar[PythonEntry]
    channels: ClassVar[Mapping[str, Channel]] = {}

    def genome_space(self) -> GenomeSpace:
        """Raise the error of the missing function."""
        raise self.entry.missing_error

    def move(self, genomes: Genomes) -> Motion:
        """Raise the error of the missing function."""
        raise self.entry.missing_error

    def skeleton(self, motion: Motion, individual: int) -> Skeleton:
        """Raise the error of the missing function."""
        raise self.entry.missing_error
