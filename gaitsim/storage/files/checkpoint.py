"""Checkpoints and champions: their strictly checked contents, and their files."""

from dataclasses import dataclass, fields
from itertools import pairwise
from pathlib import Path
from typing import Annotated, Any, ClassVar

import numpy as np
from numpy.typing import NDArray
from pydantic import AfterValidator, ConfigDict, StrictStr, TypeAdapter, ValidationError

from gaitsim.contracts import Array, Genomes
from gaitsim.contracts.search import STATE_DTYPES
from gaitsim.errors import CheckpointError, RunError
from gaitsim.storage.files import safe_pickle
from gaitsim.storage.files.atomic import set_aside, write_bytes, write_rotating
from gaitsim.storage.files.schema import (
    EXACT_KEYS,
    BelowInfinity,
    Count,
    Finite,
    Name,
    Names,
    Number,
    Toml,
    array,
    first_problem,
    plain_array,
)

_GENES = ("<f8", "|u1")
_REAL = ("<f8",)
_SCORES = array(("population",), _REAL, "finite or −inf", lambda scores: scores < np.inf)
_TERM = array(("population",), _REAL, "a number", lambda term: np.array(True))
_POPULATION = array(("population", "genes"), _GENES, "finite", np.isfinite)
_STATE = array(None, STATE_DTYPES, "a number", lambda values: np.array(True))
_GENOME = array(("genes",), _GENES, "finite", np.isfinite)


@dataclass(frozen=True)
class Stage:
    """A stage that ended because the experiment was changed.

    Args:
        generation: last generation of the stage.
        experiment: experiment of the stage as resolved TOML.
        versions: versions of gaitsim, NumPy and each plugin's package in the stage, by name.
    """

    __pydantic_config__: ClassVar[ConfigDict] = EXACT_KEYS

    generation: Number
    experiment: Toml
    versions: Names


@dataclass(frozen=True, eq=False)
class Checkpoint:
    """The state from which a run resumes bit-identically.

    Args:
        experiment: experiment as resolved TOML.
        versions: versions of gaitsim, NumPy and each plugin's package, by name.
        generation: number of the generation, counted from 1.
        evaluations: number of individuals evaluated so far.
        genomes: genomes, (population, genes), float64 and finite, or uint8.
        scores: scores, (population,) float64; −inf for an individual that failed.
        terms: terms of the scores by name, each (population,) float64; finite except for
            individuals that failed.
        reasons: reasons for scores of −inf, by the individual's index as a string.
        stagnation: generations since the best score last increased.
        best_score: best score so far; −inf if none was finite.
        threshold: score that the next champion must beat; None if champions are not saved.
        stages: stages before the current one, in order.
        values: terms and measures that the search reads, each (population,) float64.
        state: state of the search by name, arrays of any shape.
        finished: reason why the search itself ended the run; '' if it continues.
    """

    kind: ClassVar[str] = "population"
    __pydantic_config__: ClassVar[ConfigDict] = EXACT_KEYS

    experiment: Toml
    versions: Names
    generation: Number
    evaluations: Count
    genomes: Annotated[Genomes, _POPULATION]
    scores: Annotated[NDArray[np.float64], _SCORES]
    terms: dict[Name, Annotated[NDArray[np.float64], _TERM]]
    reasons: dict[Name, StrictStr]
    stagnation: Count
    best_score: BelowInfinity
    threshold: Finite | None
    stages: tuple[Stage, ...]
    values: dict[Name, Annotated[NDArray[np.float64], _TERM]]
    state: dict[Name, Annotated[Array, _STATE]]
    finished: StrictStr = ""


@dataclass(frozen=True, eq=False)
class Champion:
    """A saved individual.

    Args:
        experiment: experiment as resolved TOML.
        versions: versions of gaitsim, NumPy and each plugin's package, by name.
        generation: generation of the individual, counted from 1.
        genome: genome, (genes,), float64 and finite, or uint8.
        score: score, finite.
        terms: terms of the score by name, finite.
    """

    kind: ClassVar[str] = "champion"
    __pydantic_config__: ClassVar[ConfigDict] = EXACT_KEYS

    experiment: Toml
    versions: Names
    generation: Number
    genome: Annotated[Array, _GENOME]
    score: Finite
    terms: dict[Name, Finite]


@dataclass(frozen=True, eq=False)
class Start:
    """The genomes around which a run begins.

    Args:
        experiment: experiment of the genomes as resolved TOML.
        genomes: genomes, (starts, genes), float64 and finite, or uint8.
        generation: generation of the individual that the run starts from, counted from 1; 0 for
            other genomes, such as those passed in Python or of a recorded drive.
        score: score of that individual; 0 for other genomes.
    """

    kind: ClassVar[str] = "start"
    __pydantic_config__: ClassVar[ConfigDict] = EXACT_KEYS

    experiment: Toml
    genomes: Annotated[Genomes, _POPULATION]
    generation: Count = 0
    score: Finite = 0.0

    @classmethod
    def of(cls, champion: Champion) -> "Start":
        """Return the start from a saved individual."""
        return cls(champion.experiment, champion.genome[None], champion.generation, champion.score)


def write_checkpoint(path: Path, checkpoint: Checkpoint, previous: Path | None = None) -> None:
    """Write `checkpoint` to `path` atomically, and keep the old file as `previous`."""
    data = pack(checkpoint)
    if previous is None:
        write_bytes(path, data, follow=False)
    else:
        write_rotating(path, previous, data)


def write_champion(path: Path, champion: Champion) -> None:
    """Write `champion` to `path` atomically."""
    write_bytes(path, pack(champion), follow=False)


def read_checkpoint(path: Path) -> Checkpoint:
    """Read a checkpoint without executing anything in it. The arrays are writable copies."""
    found: Checkpoint = _unpack(path, Checkpoint.kind)
    return found


def read_champion(path: Path) -> Champion:
    """Read a champion, as safely as `read_checkpoint`, with the same errors."""
    found: Champion = _unpack(path, Champion.kind)
    return found


def read_start(path: Path) -> Start:
    """Read the start of a run, which may be a champion, as safely as `read_checkpoint`."""
    found: Start | Champion = _unpack(path, Start.kind, Champion.kind)
    return Start.of(found) if isinstance(found, Champion) else found


def read_with_fallback(
    path: Path, previous: Path, *, rename: bool = True
) -> tuple[Checkpoint, str | None]:
    """Read the checkpoint at `path`, or the previous one if that is missing or damaged.

    Args:
        path: path of the checkpoint.
        previous: path of the previous checkpoint.
        rename: whether to rename a damaged `a.pickle` to `a.damaged-1.pickle`, so that it is
            kept. Only for the writer of the run.

    Returns:
        The checkpoint, and a warning if it is the previous one, else None.
    """
    try:
        return read_checkpoint(path), None
    except safe_pickle.SchemaVersionError:
        raise
    except CheckpointError as error:
        damage = error.what
    try:
        checkpoint = read_checkpoint(previous)
    except safe_pickle.SchemaVersionError:
        raise
    except CheckpointError as error:
        raise CheckpointError(
            f"neither checkpoint can be read: {damage}; {error.what}",
            where=f"{path} and {previous}",
            allowed="at least one intact checkpoint",
            remedy="restore one from a copy of the folder, or start a new run",
        ) from error
    instead = f"{previous.name} of generation {checkpoint.generation} is used instead"
    if not (rename and path.exists()):
        return checkpoint, f"{damage}; {instead}"
    try:
        return checkpoint, f"{damage}; it is kept as {set_aside(path, 'damaged').name}, {instead}"
    except RunError as error:  # a folder that forbids renames keeps the file, too
        return checkpoint, f"{damage}; {instead}; {error.what}"


def _check(checkpoint: Checkpoint) -> Checkpoint:
    """Check that the values of a checkpoint are consistent."""
    individuals = len(checkpoint.genomes)
    failed = checkpoint.scores == -np.inf
    if len(checkpoint.scores) != individuals:
        raise ValueError(f"scores should match the {individuals} genomes in number")
    for kind, columns in (("terms", checkpoint.terms), ("values", checkpoint.values)):
        for name, column in columns.items():
            if len(column) != individuals:
                raise ValueError(f"{kind}.{name} should match the {individuals} genomes in number")
            if kind == "terms" and not (np.isfinite(column) | failed).all():
                raise ValueError(f"terms.{name} should be finite if the score is finite")
    if not checkpoint.reasons.keys() <= {str(index) for index in np.flatnonzero(failed)}:
        raise ValueError("only individuals with the score −inf should have reasons")
    evaluated = individuals * checkpoint.generation
    # Stages that re-evaluate the population add evaluations.
    if not evaluated <= checkpoint.evaluations:
        raise ValueError(f"evaluations should be at least {evaluated:,}")
    if checkpoint.stagnation >= checkpoint.generation:
        raise ValueError("stagnation should be below the generation")
    if checkpoint.best_score < checkpoint.scores.max():
        raise ValueError("best_score should not be below a score")
    ends = [0, *(stage.generation for stage in checkpoint.stages), checkpoint.generation]
    if checkpoint.stages and not all(before < end for before, end in pairwise(ends)):
        raise ValueError("stages should end in order, before the checkpoint's generation")
    return checkpoint


_ADAPTERS: dict[str, TypeAdapter[Any]] = {
    Checkpoint.kind: TypeAdapter(Annotated[Checkpoint, AfterValidator(_check)]),
    Champion.kind: TypeAdapter(Champion),
    Start.kind: TypeAdapter(Start),
}


def pack(record: Checkpoint | Champion | Start) -> bytes:
    """Return the bytes of a file with `record`, after checking that it can be read."""
    content = _plain(record)
    try:
        _ADAPTERS[record.kind].validate_python(content)
    except ValidationError as error:
        key, wrong = first_problem(error, record.kind)
        raise ValueError(f"cannot write this {record.kind}: {key}: {wrong}") from error
    return safe_pickle.dumps({"kind": record.kind, **content})


def _unpack(path: Path, kind: str, *older: str) -> Any:
    content = safe_pickle.load(path)
    wrong, allowed = "it is of another kind", f"a file of the kind {kind!r}"
    try:
        found = content.pop("kind", None)
        if found in (kind, *older):
            return _ADAPTERS[found].validate_python(content)
    except ValidationError as error:
        wrong, allowed = ": ".join(first_problem(error, kind)), ""
    except MemoryError as error:
        raise CheckpointError(
            f"cannot read {path.name}: it needs more memory than is available",
            where=str(path),
            remedy="close other programs, or use a machine with more memory",
        ) from error
    raise CheckpointError(
        f"{path.name} is not a valid {kind}: {wrong}",
        where=str(path),
        allowed=allowed,
        remedy="use a file that gaitsim wrote and that was not changed",
    )


def _plain(value: Any) -> Any:
    match value:
        case np.ndarray():
            return plain_array(value)
        case np.generic():
            return value.item()
        case dict():
            return {key: _plain(inner) for key, inner in value.items()}
        case list() | tuple():
            return [_plain(inner) for inner in value]
        case Checkpoint() | Champion() | Start() | Stage():
            return {item.name: _plain(getattr(value, item.name)) for item in fields(value)}
        case _:
            return value
