"""Functions and objects that a user passes in Python, as plugins of this process."""

import functools
import inspect
import pickle
import sys
from collections.abc import Callable, Iterable, Mapping
from dataclasses import replace
from types import CodeType
from typing import Any, ClassVar

import numpy as np
from pydantic import ConfigDict

from gaitsim.contracts import (
    Array,
    Channel,
    Fitness,
    Genomes,
    GenomeSpace,
    Measure,
    Motion,
    Organism,
    Plugin,
    Skeleton,
)
from gaitsim.errors import GaitsimError
from gaitsim.registry import options
from gaitsim.registry.entry_points import (
    ARGUMENTS,
    OUTSIDE,
    PYTHON,
    SCORE,
    PythonEntry,
    contract_error,
    entries,
    register,
)
from gaitsim.registry.options import PLUGIN, problems


class UnknownChannelError(KeyError):
    """Raised if a fitness reads a channel that the motion does not have."""

    def __str__(self) -> str:
        return str(self.args[0])


class ReadOnlyMotion(Motion):
    """A motion whose arrays are read-only."""

    def __init__(self, motion: Motion) -> None:
        vars(self).update(vars(motion))  # both keep the channels that either has computed

    def __getitem__(self, name: str) -> Array:
        if name not in self:
            known = ", ".join(self) or "none"
            raise UnknownChannelError(f"the motion has no channel {name!r}; it has {known}")
        view = np.asarray(super().__getitem__(name)).view()
        view.flags.writeable = False
        return view

    def __setitem__(self, name: str, values: object) -> None:
        raise ValueError("the motion is read-only")


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
        """Return the channel `score`, or all channels if each has the shape (population,)."""
        if "score" in motion:
            return {"score": motion["score"]}
        terms = dict(motion)
        if all(values.ndim == 1 for values in terms.values()):
            return terms
        raise GaitsimError(
            "no fitness was passed, and the body returned no score",
            where=f"the body returned the channels {', '.join(motion)}",
            allowed="a channel 'score'; one array (population,), which is the score; or a dict of "
            "such arrays, which are its terms",
            remedy="return a score from the body, or pass a function as fitness=…",
        )


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
        """Return the function's result as a motion; see `motion_of`.

        A function written for one genome may return an array (genes,), which would pass for the
        scores of a population of the same size. Such a population is evaluated in two parts.
        """
        if not len(genomes) == self.space.genes > 1:
            return self._call(genomes)
        one, others = self._call(genomes[:1]), self._call(genomes[1:])
        if list(one) != list(others):
            what = f"returned the channels {', '.join(others)} after {', '.join(one)}"
            raise contract_error(self.entry, what, "the same names for all genomes")
        failures = one.failures | {index + 1: why for index, why in others.failures.items()}
        channels = {name: np.concatenate([one[name], others[name]]) for name in one}
        return Motion(one.frame_rate, channels, failures=failures)

    def _call(self, genomes: Genomes) -> Motion:
        try:
            return motion_of(self.entry, type(self).function(genomes), len(genomes))
        except Exception as error:
            if self._takes_one(genomes[0].copy()):
                wrong = contract_error(
                    self.entry,
                    f"returns one number for one genome, ({self.space.genes},), but gaitsim calls "
                    "it with a whole population",
                    f"a function of genomes (population, genes) = {genomes.shape}",
                )
                name = self.entry.argument.partition("=")[2]
                wrong.remedy = f"pass body=gs.scalar({name})"
                wrong.where = self.entry.target
                raise wrong from error
            raise

    def _takes_one(self, genome: Array) -> bool:
        """Return whether the function turns one genome, (genes,), into one number."""
        try:
            found = np.asarray(type(self).function(genome))
        except Exception:
            return False
        return found.ndim == 0 and found.dtype.kind in "fiub"

    def measures(self, motion: Motion) -> dict[str, Measure]:
        """Return the channels (population,) besides the score; {} if they are its terms."""
        flat = {name: motion[name] for name in motion if np.ndim(motion[name]) == 1}
        if "score" not in flat and len(flat) == len(motion):
            return {}
        return {
            name: Measure(values, "", "a value that the function returned")
            for name, values in flat.items()
            if name != "score"
        }

    def skeleton(self, motion: Motion, individual: int) -> Skeleton:
        """Raise an error, because a function cannot be drawn."""
        raise GaitsimError(
            f"the {self.entry} cannot be drawn: it is a function without a skeleton",
            allowed="a body with a skeleton",
            remedy="write a subclass of gs.Organism with the method skeleton()",
        )


def motion_of(entry: PythonEntry, found: Any, population: int) -> Motion:
    """Return the result of a function of genomes as a motion.

    An array (population,) becomes the channel `score`; a tuple of such arrays, or an array
    (population, objectives), the channels 'objective 1', 'objective 2' and so on.
    """
    if isinstance(found, Motion):
        return found
    if isinstance(found, Mapping):
        if not found:
            raise contract_error(entry, "returned no channel", _CHANNELS)
        channels = dict(found)
    elif isinstance(found, tuple) and all(np.shape(one) == (population,) for one in found):
        channels = dict(zip(objective_names(len(found)), found, strict=True))
    else:
        array = _channel(entry, "score", found, population)
        if array.ndim == 1:
            channels = {"score": array}
        elif array.ndim == 2 and array.shape[1] > 1:
            channels = dict(zip(objective_names(array.shape[1]), array.T, strict=True))
        else:
            what = f"returned an array of shape {np.shape(found)}"
            expected = f"a score for each individual, (population,) = ({population},)"
            more = "several objectives, (population, objectives), or a dict of channels"
            raise contract_error(entry, what, f"{expected}; {more}")
    return Motion(
        1.0, {name: _channel(entry, name, one, population) for name, one in channels.items()}
    )


def objective_names(number: int) -> list[str]:
    """Return the names of objectives that a function returned without names."""
    return [f"{OBJECTIVE} {index}" for index in range(1, number + 1)]


OBJECTIVE = "objective"


def _channel(entry: PythonEntry, name: Any, values: Any, population: int) -> Array:
    if not (isinstance(name, str) and name.isprintable() and 0 < len(name) <= 200):
        raise contract_error(entry, f"names a channel {name!r:.80}", "a printable string")
    try:
        array = np.asarray(values)
    except ValueError:  # lists of different lengths
        array = np.empty(0, object)
    if array.dtype.kind not in "fiub":
        what = f"returned {values!r:.80} for the channel {name!r}"
        raise contract_error(entry, what, "real numbers")
    if array.shape[:1] != (population,):
        what = f"returned the channel {name!r} with the shape {array.shape}"
        raise contract_error(entry, what, f"{_FIRST} ({population}, …)")
    return array


def scalar(function: Callable[[Array], Any]) -> Callable[[Genomes], Any]:
    """Return a body for `gaitsim.evolve` from a function of one genome; also a decorator.

    The body calls the function for one genome after another.

    Args:
        function: function of a genome, (genes,), that returns a number, which is the score; a tuple
            of numbers, which are objectives; or a dict of numbers, which are terms. Higher scores
            are better.
    """
    if not callable(function) or isinstance(function, type):
        raise GaitsimError(
            f"{function!r:.80} is not a function",
            where="scalar",
            allowed="a function of one genome, (genes,)",
        )

    @functools.wraps(function)
    def each(genomes: Genomes) -> Any:
        if np.ndim(genomes) == 1:
            return function(genomes)
        found = [function(genome) for genome in genomes]
        first = found[0]
        if isinstance(first, Mapping):
            if wrong := next((one for one in found if _names(one) != _names(first)), None):
                raise ValueError(f"it returned {wrong!r:.80} after {first!r:.80}")
            return {name: _numbers([one[name] for one in found]) for name in first}
        if isinstance(first, tuple):
            return np.stack([_numbers(list(one)) for one in found])
        return _numbers(found)

    return each


def _names(result: Any) -> list[Any] | None:
    return list(result) if isinstance(result, Mapping) else None


def _numbers(values: list[Any]) -> Array:
    """Return numbers as an array; raise an error for anything else."""
    for value in values:
        if np.ndim(value) or np.asarray(value).dtype.kind not in "fiub":
            shape = f", an array of shape {np.shape(value)}," if np.ndim(value) else ""
            raise ValueError(f"it returned {value!r:.80}{shape} instead of a number")
    return np.array(values)


_FIRST = "an array whose first axis is the population,"
_CHANNELS = f"a dict of channels, or one array: {_FIRST[:-1]}"


def plugin_class(entry: PythonEntry) -> type[Plugin]:
    """Return the class of an entry.

    If it is not registered, a placeholder accepts any options, and raises an error when its code is
    needed.
    """
    if entry.model is not None:
        return entry.model
    if (entry.kind, entry.name) == ("fitness", SCORE):
        return ScoreChannel
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


_BASES: dict[str, type[Plugin]] = {"fitness": Fitness, "organism": Organism}
_SIGNATURES = {
    "fitness": "def forward(motion): return motion['feet'][:, -1].mean(axis=(1, 2))",
    "organism": "def sphere(genomes): return -(genomes**2).sum(axis=1)",
}


def python_options(
    fitness: Any = None, body: Any = None, space: Any = None
) -> dict[str, dict[str, Any]]:
    """Register a fitness and a body in this process; return the sections that choose them.

    Args:
        fitness: function (motion) -> scores (population,) or a dict of such terms; or an instance
            of a subclass of `Fitness`; or None.
        body: function (genomes) -> dict of channels or scores (population,); or an instance of a
            subclass of `Organism`; or None.
        space: genome space of a body that is a function.
    """
    found: dict[str, dict[str, Any]] = {}
    if body is not None and not isinstance(body, Organism):
        _code_of("organism", body)  # first: a class passed by mistake needs no space
    _check_space(body, space)
    if body is not None:
        found["organism"] = _section("organism", body, space)
        if fitness is None and not isinstance(body, Organism):
            found["fitness"] = {PLUGIN: SCORE}
    if fitness is not None:
        found["fitness"] = _section("fitness", fitness, None)
    return found


def _check_space(body: Any, space: Any) -> None:
    example = "space=gs.RealSpace([-5, -5], [5, 5])"
    if isinstance(body, Organism) or body is None:
        if space is not None:
            reason = "has its own genome space" if body is not None else "is missing"
            raise GaitsimError(
                f"a space is allowed only with a body that is a function, but the body {reason}",
                where="space",
                remedy="omit the space" if body is not None else "also pass a body",
            )
    elif not isinstance(space, GenomeSpace):
        named = isinstance(space, type)
        what = f"the class {space.__name__}" if named else f"a {type(space).__name__}"
        raise GaitsimError(
            "a body that is a function needs a genome space"
            if space is None
            else f"{what} is not a genome space",
            where="space",
            allowed="a gs.RealSpace or a gs.BitSpace",
            remedy=f"pass the bounds of the genes, as in {example}",
        )


def _section(kind: str, thing: Any, space: GenomeSpace | None) -> dict[str, Any]:
    """Return the section of an experiment that chooses a function or an object."""
    if isinstance(thing, _BASES[kind]) and isinstance(thing, Plugin):
        values = dict.fromkeys(type(thing).model_fields, options.NOT_SET)
        return {PLUGIN: _name_of(kind, type(thing)), **values, **options.values(thing)}
    code = _code_of(kind, thing)
    label, target = thing.__name__.strip("<>"), f"{code.co_filename}, line {code.co_firstlineno}"
    name = f"{PYTHON}{label}"
    entry = PythonEntry(kind, name, target, OUTSIDE, "", file=code.co_filename)
    _register_function(entry, thing, space)
    return {PLUGIN: name}


def _register_function(entry: PythonEntry, function: Any, space: GenomeSpace | None) -> None:
    parts = {"entry": entry, "function": staticmethod(function), "__module__": __name__}
    parts |= {"space": space} if space is not None else {}
    base = FunctionFitness if entry.kind == "fitness" else FunctionBody
    model = type(entry.label, (base,), {**parts, "__doc__": inspect.getdoc(function)})
    register(replace(entry, model=model))


def pickled(entries: Iterable[PythonEntry]) -> bytes:
    """Return functions and classes for `register_pickled` in another process.

    Functions of a module are pickled by reference; those of `__main__`, of notebooks and inside
    functions with their code, and the global variables and closures that they use.

    Raises:
        GaitsimError: a function cannot be pickled, or is not registered in this process.
    """
    import cloudpickle

    found = []
    for entry in entries:
        if entry.model is None:
            raise entry.missing_error
        bases = (FunctionFitness, FunctionBody)
        thing = entry.model.function if issubclass(entry.model, bases) else entry.model
        parts = replace(entry, model=None), thing, getattr(entry.model, "space", None)
        try:
            found.append((str(entry), entry.target, cloudpickle.dumps(parts)))
        except Exception as error:  # whatever the user's objects raise
            raise GaitsimError(
                f"the {entry} cannot be sent to workers: {error}".replace("\n", " "),
                where=entry.target,
                allowed="a function whose global variables and closure can be pickled",
                remedy=f"create such objects inside {entry.label}, or move it to a module, which "
                "workers import; or omit workers",
            ) from error
    return pickle.dumps((sys.version_info[:2], found))


def register_pickled(functions: bytes) -> None:
    """Register the functions and classes that `pickled` returned in another process."""
    version, found = pickle.loads(functions)
    if version != sys.version_info[:2]:
        there, here = (".".join(map(str, one)) for one in (version, sys.version_info[:2]))
        what = f"a worker has Python {here}, which cannot load functions of Python {there}"
        raise GaitsimError(what, remedy=f"start the workers with Python {there}")
    for name, target, data in found:
        try:
            entry, thing, space = pickle.loads(data)
        except Exception as error:
            raise GaitsimError(
                f"a worker cannot load the {name}: {type(error).__name__}: {error}",
                where=target,
                remedy="define it in a module that workers can import, or omit workers",
            ) from error
        if isinstance(thing, type) and issubclass(thing, Plugin):
            register(replace(entry, model=thing))
        else:
            _register_function(entry, thing, space)


def _name_of(kind: str, model: type[Plugin]) -> str:
    """Return the name of a class in its installed package, or else a new `python:` name."""
    target = f"{model.__module__}:{model.__qualname__}"
    for name, claims in entries(kind).items():
        if [claim.target for claim in claims] == [target]:
            return name
    code = next((code for part in vars(model).values() if (code := _code(part))), None)
    file = code.co_filename if code else ""
    name = f"{PYTHON}{model.__name__}"
    where = f"{file}, class {model.__name__}" if file else f"class {model.__name__}"
    entry = PythonEntry(kind, name, where, OUTSIDE, "", file=file)
    if found := problems(kind, model):
        raise contract_error(entry, f"breaks its contract: {'; '.join(found)}")
    register(replace(entry, model=model))
    return name


def _code_of(kind: str, thing: Any) -> CodeType:
    """Return the code of a function."""
    argument = ARGUMENTS[kind]
    base = f"gs.{_BASES[kind].__name__}"
    name = getattr(thing, "__name__", "")
    what, remedy = "", f"write a function, as in {_SIGNATURES[kind]}"
    if isinstance(thing, type):
        what = f"{name} is a class, not an instance"
        remedy = f"{argument}={name}()" if issubclass(thing, _BASES[kind]) else remedy
    elif isinstance(thing, functools.partial):
        inner = getattr(thing.func, "__name__", "function")
        what = f"a functools.partial of {inner} has no name, which is needed to resume a run"
        remedy = f"write a function that calls {inner} with these arguments"
    elif not callable(thing):
        what = f"{thing!r:.80} is not a function"
    elif (code := _code(thing)) is None:
        what = f"{thing!r:.80} has no Python code"
    elif inspect.iscoroutinefunction(thing) or inspect.isgeneratorfunction(thing):
        what = f"{name} is an async or generator function, which cannot return an array"
    else:
        return code
    raise GaitsimError(
        what,
        where=argument,
        allowed=f"a function, or an instance of a subclass of {base}",
        remedy=remedy,
    )


def _code(thing: Any) -> CodeType | None:
    """Return the code of a function, a method or a wrapper, such as Numba's; None without code."""
    inner = thing.fget if isinstance(thing, property) else thing
    found = getattr(inspect.unwrap(inner), "__code__", None) if callable(inner) else None
    if isinstance(thing, staticmethod | classmethod):
        found = getattr(thing.__func__, "__code__", None)
    return found if isinstance(found, CodeType) else None
