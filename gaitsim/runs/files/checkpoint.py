"""What a checkpoint and a champion hold, checked to the last key when they are read."""

from dataclasses import dataclass, field, fields
from itertools import pairwise
from pathlib import Path
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from gaitsim.contracts import Array, Genomes
from gaitsim.errors import CheckpointError, RunError
from gaitsim.runs.files import safe_pickle
from gaitsim.runs.files.atomic import set_aside, write_bytes, write_rotating
from gaitsim.runs.files.schema import (
    MismatchError,
    array,
    below_infinity,
    count,
    each,
    exactly,
    finite,
    name,
    named,
    optional,
    plain_array,
    record,
    text,
)


@dataclass(frozen=True)
class Stage:
    """A stage that came to its end, since the experiment was changed after it.

    Args:
        generation: its last one.
        experiment: that held up to it, as resolved TOML.
        versions: of gaitsim, NumPy and each plugin's package then, by name.
    """

    generation: int
    experiment: str
    versions: dict[str, str]


@dataclass(frozen=True, eq=False)
class Checkpoint:
    """The state that a run is resumed from, to the bit.

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
        stages: those before the present one, in the order of their generations.
    """

    kind: ClassVar[str] = "population"

    experiment: str
    versions: dict[str, str]
    generation: int
    evaluations: int
    genomes: Genomes
    scores: NDArray[np.float64]
    terms: dict[str, NDArray[np.float64]]
    reasons: dict[str, str]
    stagnation: int
    best_score: float
    threshold: float | None
    stages: tuple[Stage, ...] = field(default=())


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

    experiment: str
    versions: dict[str, str]
    generation: int
    genome: Array
    score: float
    terms: dict[str, float]


def write_checkpoint(path: Path, checkpoint: Checkpoint, previous: Path | None = None) -> None:
    """Write `checkpoint` to `path` at one stroke; what stood there is kept as `previous`.

    Raises:
        RunError: the file cannot be written; what stood there still does.
        ValueError: the checkpoint is not one; see `Checkpoint`.
    """
    data = pack(checkpoint)
    if previous is None:
        write_bytes(path, data)
    else:
        write_rotating(path, previous, data)


def write_champion(path: Path, champion: Champion) -> None:
    """Write `champion` to `path` at one stroke.

    Raises:
        RunError: the file cannot be written; what stood there still does.
        ValueError: the champion is not one; see `Champion`.
    """
    write_bytes(path, pack(champion))


def read_checkpoint(path: Path) -> Checkpoint:
    """Read a checkpoint; nothing in the file is executed. The arrays are writable copies.

    Raises:
        SchemaVersionError: it is whole, but of an older or a newer gaitsim.
        CheckpointError: it is missing, damaged, foreign or hostile.
        RunError: it may not be read.
    """
    checkpoint: Checkpoint = _unpack(path, Checkpoint.kind)
    return checkpoint


def read_champion(path: Path) -> Champion:
    """Read a champion, as safely as `read_checkpoint`, with the same errors."""
    champion: Champion = _unpack(path, Champion.kind)
    return champion


def read_with_fallback(
    path: Path, previous: Path, *, rename: bool = True
) -> tuple[Checkpoint, str | None]:
    """Read the checkpoint at `path`, or the one before it where that is missing or damaged.

    Args:
        path: the checkpoint.
        previous: the one before it.
        rename: whether a damaged file is renamed, to be looked at: `a.pickle` to
            `a.damaged-1.pickle`. Only for who will write the next one.

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


def _check_checkpoint(**values: Any) -> Checkpoint:
    """A checkpoint whose values fit each other."""
    checkpoint = Checkpoint(**values)
    individuals = len(checkpoint.genomes)
    failed = checkpoint.scores == -np.inf
    if len(checkpoint.scores) != individuals:
        raise MismatchError("scores", f"as many as the {individuals} genomes")
    for term_name, term in checkpoint.terms.items():
        if len(term) != individuals:
            raise MismatchError(f"terms.{term_name}", f"as long as the {individuals} genomes")
        if not (np.isfinite(term) | failed).all():
            raise MismatchError(f"terms.{term_name}", "finite where the score is")
    if not checkpoint.reasons.keys() <= {str(index) for index in np.flatnonzero(failed)}:
        raise MismatchError("reasons", "given for individuals with the score −inf alone")
    ends = [0, *(stage.generation for stage in checkpoint.stages), checkpoint.generation]
    if checkpoint.stages and not all(before < end for before, end in pairwise(ends)):
        raise MismatchError("stages", "in the order of their generations, before the checkpoint's")
    return checkpoint


_NUMBER = exactly(int, "a whole number, 1 or more", lambda value: value >= 1)
_GENES = ("<f8", "|u1")
_REAL = ("<f8",)
_CHECKPOINT = record(
    _check_checkpoint,
    {
        "experiment": text,
        "versions": named(name),
        "generation": _NUMBER,
        "evaluations": count,
        "genomes": array(("population", "genes"), _GENES, "finite", np.isfinite),
        "scores": array(("population",), _REAL, "finite or −inf", lambda scores: scores < np.inf),
        "terms": named(array(("population",), _REAL, "a number", np.ones_like)),
        "reasons": named(text),
        "stagnation": count,
        "best_score": below_infinity,
        "threshold": optional(finite),
        "stages": each(
            record(Stage, {"generation": _NUMBER, "experiment": text, "versions": named(name)})
        ),
    },
)
_CHAMPION = record(
    Champion,
    {
        "experiment": text,
        "versions": named(name),
        "generation": _NUMBER,
        "genome": array(("genes",), _GENES, "finite", np.isfinite),
        "score": finite,
        "terms": named(finite),
    },
)
_RULES = {Checkpoint.kind: _CHECKPOINT, Champion.kind: _CHAMPION}


def pack(record: Checkpoint | Champion) -> bytes:
    """The file of `record`, which the rule that will read it has accepted.

    Raises:
        ValueError: it is not one; see `Checkpoint` and `Champion`.
    """
    content = _plain(record)
    try:
        _RULES[record.kind](content, record.kind)
    except MismatchError as error:
        raise ValueError(f"this {record.kind} cannot be written: {error}") from error
    return safe_pickle.dumps({"kind": record.kind, **content})


def _unpack(path: Path, kind: str) -> Any:
    content = safe_pickle.load(path)
    found = content.pop("kind", None)
    try:
        exactly(str, repr(kind), lambda found: found == kind)(found, "kind")
        return _RULES[kind](content, kind)
    except MismatchError as error:
        raise CheckpointError(
            f"{path.name} does not hold a {kind} as gaitsim writes it: {error.key} is wrong",
            where=str(path),
            allowed=f"{error.key}: {error.allowed}",
            remedy="use a file that gaitsim wrote: this one is of another kind or was changed",
        ) from error
    except MemoryError as error:
        raise CheckpointError(
            f"{path.name} needs more memory than there is",
            where=str(path),
            remedy="close other programs, or use a machine with more memory",
        ) from error


def _plain(value: Any) -> Any:
    """`value` as builtins."""
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
