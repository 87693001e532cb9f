"""Checkpoints and champions: their contents, checked to the last key, and their files."""

from dataclasses import dataclass, fields
from itertools import pairwise
from pathlib import Path
from typing import Annotated, Any, ClassVar, TypeVar

import numpy as np
from numpy.typing import NDArray
from pydantic import AfterValidator, ConfigDict, StrictStr, TypeAdapter, ValidationError

from gaitsim.contracts import Array, Genomes
from gaitsim.contracts.search import STATE_DTYPES
from gaitsim.errors import CheckpointError, RunError
from gaitsim.runs.files import safe_pickle
from gaitsim.runs.files.atomic import set_aside, write_bytes, write_rotating
from gaitsim.runs.files.schema import (
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

_T = TypeVar("_T")
_GENES = ("<f8", "|u1")
_REAL = ("<f8",)
_SCORES = array(("population",), _REAL, "finite or −inf", lambda scores: scores < np.inf)
_TERM = array(("population",), _REAL, "a number", lambda term: np.array(True))
_POPULATION = array(("population", "genes"), _GENES, "finite", np.isfinite)
_STATE = array(None, STATE_DTYPES, "a number", lambda values: np.array(True))
_GENOME = array(("genes",), _GENES, "finite", np.isfinite)


@dataclass(frozen=True)
class Stage:
    """A stage that has ended, since the experiment was changed after it.

    Args:
        generation: its last generation.
        experiment: its experiment as resolved TOML.
        versions: of gaitsim, NumPy and each plugin's package then, by name.
    """

    __pydantic_config__: ClassVar[ConfigDict] = EXACT_KEYS

    generation: Number
    experiment: Toml
    versions: Names


@dataclass(frozen=True, eq=False)
class Checkpoint:
    """The state from which a run is resumed, to the bit.

    Args:
        experiment: the experiment as resolved TOML.
        versions: of gaitsim, NumPy and each plugin's package, by name.
        generation: of this population, counted from 1.
        evaluations: how many individuals were evaluated so far.
        genomes: (population, genes), float64 and finite, or uint8.
        scores: (population,) float64; −inf for an individual that failed.
        terms: of the scores by name, each (population,) float64; finite but for
            individuals that failed.
        reasons: why a score is −inf, by the individual's index written as a string.
        stagnation: generations since the best score last rose.
        best_score: the best score so far; −inf where none was finite.
        threshold: the score that the next champion must beat; None where none is saved.
        stages: the stages before the current one, in order.
        values: the terms and measures that the search reads, each (population,) float64.
        state: of the search by name, arrays of any shape.
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


@dataclass(frozen=True, eq=False)
class Champion:
    """One individual that was worth keeping.

    Args:
        experiment: the experiment as resolved TOML.
        versions: of gaitsim, NumPy and each plugin's package, by name.
        generation: in which it was found, counted from 1.
        genome: (genes,), float64 and finite, or uint8.
        score: its score, finite.
        terms: of its score by name, finite.
    """

    kind: ClassVar[str] = "champion"
    __pydantic_config__: ClassVar[ConfigDict] = EXACT_KEYS

    experiment: Toml
    versions: Names
    generation: Number
    genome: Annotated[Array, _GENOME]
    score: Finite
    terms: dict[Name, Finite]


def write_checkpoint(path: Path, checkpoint: Checkpoint, previous: Path | None = None) -> None:
    """Write `checkpoint` to `path` atomically, and keep the old file as `previous`.

    Raises:
        RunError: the file cannot be written; the old one is still there.
        ValueError: the checkpoint is invalid; see `Checkpoint`.
    """
    data = pack(checkpoint)
    if previous is None:
        write_bytes(path, data, follow=False)
    else:
        write_rotating(path, previous, data)


def write_champion(path: Path, champion: Champion) -> None:
    """Write `champion` to `path` atomically.

    Raises:
        RunError: the file cannot be written; the old one is still there.
        ValueError: the champion is invalid; see `Champion`.
    """
    write_bytes(path, pack(champion), follow=False)


def read_checkpoint(path: Path) -> Checkpoint:
    """Read a checkpoint; nothing in the file is executed. The arrays are writable copies.

    Raises:
        SchemaVersionError: it is whole, but of an older or a newer gaitsim.
        CheckpointError: it is missing, damaged, foreign or hostile.
        RunError: permission denied.
    """
    return _unpack(path, Checkpoint.kind, _CHECKPOINT)


def read_champion(path: Path) -> Champion:
    """Read a champion, as safely as `read_checkpoint`, with the same errors."""
    return _unpack(path, Champion.kind, _CHAMPION)


def read_with_fallback(
    path: Path, previous: Path, *, rename: bool = True
) -> tuple[Checkpoint, str | None]:
    """Read the checkpoint at `path`, or the one before it where that is missing or damaged.

    Args:
        path: the checkpoint.
        previous: the one before it.
        rename: whether to rename a damaged `a.pickle` to `a.damaged-1.pickle`, so that it is
            kept. Only for the writer of the run.

    Returns:
        The checkpoint, and a warning where it is the one before.

    Raises:
        SchemaVersionError: a file is whole, but of an older or a newer gaitsim.
        CheckpointError: neither can be read; both stay where they are.
        RunError: a file may not be read.
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
            allowed="one of the two as gaitsim wrote it",
            remedy="bring one back from a copy of the folder, or start a new run",
        ) from error
    instead = f"{previous.name}, of generation {checkpoint.generation}, is used instead"
    if not (rename and path.exists()):
        return checkpoint, f"{damage}; {instead}"
    try:
        return checkpoint, f"{damage}; it is kept as {set_aside(path, 'damaged').name}, {instead}"
    except RunError as error:  # where nothing can be renamed, nothing is overwritten either
        return checkpoint, f"{damage}; {instead}; {error.what}"


def _check(checkpoint: Checkpoint) -> Checkpoint:
    """Check that the values of a checkpoint fit each other."""
    individuals = len(checkpoint.genomes)
    failed = checkpoint.scores == -np.inf
    if len(checkpoint.scores) != individuals:
        raise ValueError(f"scores should be as many as the {individuals} genomes")
    for term_name, term in checkpoint.terms.items():
        if len(term) != individuals:
            raise ValueError(f"terms.{term_name} should be as long as the {individuals} genomes")
        if not (np.isfinite(term) | failed).all():
            raise ValueError(f"terms.{term_name} should be finite where the score is")
    if not checkpoint.reasons.keys() <= {str(index) for index in np.flatnonzero(failed)}:
        raise ValueError("reasons should be given for individuals with the score −inf alone")
    for value_name, values in checkpoint.values.items():
        if len(values) != individuals:
            raise ValueError(f"values.{value_name} should be as long as the {individuals} genomes")
    evaluated = individuals * checkpoint.generation
    # More, where a stage with other scores began.
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


_CHECKPOINT: TypeAdapter[Checkpoint] = TypeAdapter(Annotated[Checkpoint, AfterValidator(_check)])
_CHAMPION = TypeAdapter(Champion)


def pack(record: Checkpoint | Champion) -> bytes:
    """Return the file of `record`, after the check that it can be read.

    Raises:
        ValueError: it cannot; see `Checkpoint` and `Champion`.
    """
    content = _plain(record)
    try:
        (_CHECKPOINT if isinstance(record, Checkpoint) else _CHAMPION).validate_python(content)
    except ValidationError as error:
        key, wrong = first_problem(error, record.kind)
        raise ValueError(f"this {record.kind} cannot be written: {key}: {wrong}") from error
    return safe_pickle.dumps({"kind": record.kind, **content})


def _unpack(path: Path, kind: str, adapter: TypeAdapter[_T]) -> _T:
    content = safe_pickle.load(path)
    key, allowed = "kind", repr(kind)
    try:
        if content.pop("kind", None) == kind:
            return adapter.validate_python(content)
    except ValidationError as error:
        key, allowed = first_problem(error, kind)
    except MemoryError as error:
        raise CheckpointError(
            f"{path.name} needs more memory than there is",
            where=str(path),
            remedy="close other programs, or use a machine with more memory",
        ) from error
    raise CheckpointError(
        f"{path.name} does not hold a {kind} as gaitsim writes it: {key} is wrong",
        where=str(path),
        allowed=f"{key}: {allowed}",
        remedy="use a file that gaitsim wrote: this one is of another kind or was changed",
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
        case Checkpoint() | Champion() | Stage():
            return {item.name: _plain(getattr(value, item.name)) for item in fields(value)}
        case _:
            return value
