"""The content of a challenge code: an individual, its experiment, its score and its versions."""

import json
import math
import os
import struct
from codecs import BOM_UTF16_BE, BOM_UTF16_LE
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Annotated, Any

import numpy as np
from numpy.typing import NDArray
from pydantic import AfterValidator, Field, StrictStr, TypeAdapter, ValidationError

from gaitsim import toml
from gaitsim.errors import ExperimentError, GaitsimError
from gaitsim.evaluation import evaluate
from gaitsim.experiment import PORTABLE, Experiment, Overrides, parse_experiment
from gaitsim.experiment.model import MOST_GENERATIONS
from gaitsim.experiment.overrides import COMMAND_LINE
from gaitsim.individual import Individual, Member, Numbered
from gaitsim.opening import read_regular
from gaitsim.repr_mixin import ReprField, ReprMixin
from gaitsim.sharing.code import LONGEST, WHERE, contains_code, decode, encode, invalid
from gaitsim.storage.compatibility import expected_genomes, genome_mismatch, missing_packages
from gaitsim.storage.files.checkpoint import Champion
from gaitsim.storage.files.folder import RUNS, holds_run
from gaitsim.storage.files.schema import Name, printable
from gaitsim.storage.provenance import (
    MACHINE,
    RESULTS,
    Provenance,
    current_versions,
    differences,
    read_provenance,
)
from gaitsim.toml import LARGEST

_HEAD = struct.Struct("<IIdcIII")
"""The header: generation, member or 0, score, kind of genes, number of genes, and the sizes in
bytes of the experiment and of the versions that follow."""

_BITS, _BYTES, _REALS = b"b", b"u", b"f"
_ITEMS = {_BYTES: 1, _REALS: 8}  # bytes per gene
_LARGEST_VERSIONS = 100_000  # bytes


_Version = Annotated[StrictStr, Field(max_length=5000), AfterValidator(printable)]
_VERSIONS = TypeAdapter(dict[Name, _Version])


@dataclass(frozen=True, eq=False, repr=False)
class Challenge(ReprMixin):
    """An individual with the score that its author claims.

    Attributes:
        text: resolved experiment as TOML, without comments.
        genome: genome of the individual, (genes,), float64 or uint8.
        generation: generation whose worlds the individual was scored in, counted from 1. That the
            individual comes from it is the author's statement, which nothing can check.
        member: number of the individual in a front or archive; None for the best of the
            generation. It is the author's statement, too.
        score: claimed score, finite.
        versions: packages and plugins that computed the score, with their versions, and the
            processor; {} if unknown.
    """

    text: str
    genome: NDArray[Any]
    generation: int
    member: int | None
    score: float
    versions: Mapping[str, str]

    @classmethod
    def of(cls, individual: Individual) -> "Challenge":
        """Return the challenge of an individual of a run or a search.

        Raises:
            GaitsimError: the individual has no genome or score, or its run is damaged.
        """
        if individual.genome is None:
            raise GaitsimError(
                "a gait from a file cannot be shared as a code: it has no genome",
                where=individual.title,
                allowed="an individual of a run",
            )
        for entry in individual.experiment.outside:
            raise GaitsimError(
                f"the {entry} is code outside the run, so a challenge code cannot be verified",
                where=individual.title,
                allowed="a body and a fitness from installed packages",
                remedy="move the code into a package: gaitsim plugins new",
            )
        if isinstance(individual.member, Numbered):
            raise GaitsimError(
                "an individual by its number cannot be shared: a code states the best of a "
                "generation, or a member",
                where=individual.title,
                allowed="the best of a generation, or a member",
            )
        if not math.isfinite(individual.score):
            raise GaitsimError("a failed individual has no score", where=individual.title)
        return cls(
            _compact(individual.experiment.to_toml()),
            individual.genome,
            individual.generation,
            individual.member.number if individual.member else None,
            individual.score,
            _versions_of(individual),
        )

    @classmethod
    def read(cls, code: str) -> "Challenge":
        """Return the challenge in a code, without loading plugins.

        Raises:
            GaitsimError: the text is not a code, has a different format, or is damaged or invalid.
        """
        return _unpacked(decode(code))

    @property
    def code(self) -> str:
        """The challenge as a code.

        Raises:
            GaitsimError: the challenge is too large.
        """
        return encode(_packed(self))

    @cached_property
    def experiment(self) -> Experiment:
        """The experiment, with its plugins loaded.

        Raises:
            ExperimentError: the experiment has problems, such as a plugin that is not installed.
        """
        return self.experiment_with()

    def experiment_with(
        self, overrides: Overrides | None = None, place: str = COMMAND_LINE
    ) -> Experiment:
        """Return the experiment with some options changed and its plugins loaded.

        Raises:
            ExperimentError: the experiment or the changes have problems; the error lists all.
        """
        try:
            return parse_experiment(self.text, WHERE, overrides, place)
        except ExperimentError as error:
            missing = missing_packages(self.versions)
            raise ExperimentError([*error.problems, *missing]) from None

    @cached_property
    def individual(self) -> Individual:
        """The individual with the claimed score, ready to replay.

        Raises:
            ExperimentError: the experiment has problems.
            GaitsimError: the genome does not fit the body.
        """
        wrong = genome_mismatch(self.experiment, self.genome[None], self.text, "the genome")
        if wrong:
            raise GaitsimError(
                f"the genome in the challenge code does not fit its experiment: {wrong}",
                where=WHERE,
                allowed=expected_genomes(self.experiment),
                remedy="use the versions that created the code: " + self.made_with,
            )
        member = Member(self.member) if self.member else None
        return Individual(
            self.experiment, self.score, {}, self.generation, self.genome, member=member
        )

    @property
    def made_with(self) -> str:
        """The packages that computed the score, as 'gaitsim 0.1.0, numpy 2.4.6', or 'unknown'."""
        known = {name: one for name, one in self.versions.items() if name in ("gaitsim", "numpy")}
        packages = [f"{name} {one}" for name, one in known.items()]
        others = {one for name, one in self.versions.items() if " " in name}
        return ", ".join([*packages, *sorted(others - {*packages})]) or "unknown"

    @property
    def champion(self) -> Champion:
        """The individual as a saved champion, from which a run can start."""
        kept = {name: one for name, one in self.versions.items() if 0 < len(one) <= 200}
        text = self.experiment.to_toml()
        return Champion(text, kept, self.generation, self.genome, self.score, terms={})

    def _repr_fields(self) -> Mapping[str, ReprField]:
        return {
            "score": self.score,
            "generation": self.generation,
            "member": self.member or "",
            "genes": len(self.genome),
        }


def code_of(individual: Individual) -> str:
    """Return the challenge code of an individual of a run or a search.

    Raises:
        GaitsimError: the individual has no genome or score or is too large, or its run is damaged.
    """
    return Challenge.of(individual).code


def _versions_of(individual: Individual) -> dict[str, str]:
    """Return the versions that scored an individual; {} if its run does not record them."""
    if individual.source is None or not holds_run(individual.source) or individual.changes:
        parts = current_versions(individual.experiment)
    else:
        origins = read_provenance(individual.source)
        before = [one.parts for one in origins if one.first <= individual.generation]
        parts = before[-1] if before else {}
    # The code holds the long texts, so it does not need their checksums; nor the machine, if it
    # does not affect the score.
    left_out = MACHINE if parts.get(RESULTS) == PORTABLE else ()
    return {name: one for name, one in parts.items() if one != "SHA-256" and name not in left_out}


def _compact(text: str) -> str:
    """Return a TOML text without comments, or the text itself if that would change a value."""
    data = toml.parse(text, "the experiment")
    lines = [f"{key}={toml.text(one)}" for key, one in data.items() if not isinstance(one, dict)]
    for section, values in data.items():
        if isinstance(values, dict):
            lines.append(f"[{section}]")
            lines += [f"{key}={toml.text(one)}" for key, one in values.items()]
    short = "\n".join(lines) + "\n"
    try:
        return short if toml.parse(short, "the experiment") == data else text
    except GaitsimError:  # such as a character that TOML allows only escaped
        return text


def _packed(challenge: Challenge) -> bytes:
    genome = np.ascontiguousarray(challenge.genome)
    if genome.dtype.kind == "f":
        # Byte planes put the similar signs and exponents side by side, which compresses better.
        kind, genes = _REALS, genome.astype("<f8").view(np.uint8).reshape(-1, 8).T.tobytes()
    elif genome.max(initial=0) <= 1:
        kind, genes = _BITS, np.packbits(genome).tobytes()
    else:
        kind, genes = _BYTES, genome.astype(np.uint8).tobytes()
    text = challenge.text.encode()
    versions = json.dumps(dict(challenge.versions), separators=(",", ":")).encode()
    head = _HEAD.pack(
        challenge.generation,
        challenge.member or 0,
        challenge.score,
        kind,
        len(genome),
        len(text),
        len(versions),
    )
    return head + text + versions + genes


def _unpacked(content: bytes) -> Challenge:
    """Return the challenge of a code's content."""
    if len(content) < _HEAD.size:
        raise invalid("its content is too short")
    generation, member, score, kind, genes, *lengths = _HEAD.unpack_from(content)
    size = -(-genes // 8) if kind == _BITS else genes * _ITEMS.get(kind, 0)
    if not size or len(content) != _HEAD.size + sum(lengths) + size:
        raise invalid("the lengths of its parts do not add up")
    if not math.isfinite(score):
        raise invalid(f"its score is {score}, not a finite number")
    if not 1 <= generation <= MOST_GENERATIONS:
        raise invalid(f"its generation is {generation:,}, not from 1 to {MOST_GENERATIONS:,}")
    if lengths[0] > LARGEST or lengths[1] > _LARGEST_VERSIONS:
        raise invalid("its experiment or its versions are too long")
    middle, end = _HEAD.size + lengths[0], _HEAD.size + sum(lengths)
    try:
        text = content[_HEAD.size : middle].decode()
        versions = _VERSIONS.validate_json(content[middle:end], strict=True)
    except (UnicodeDecodeError, ValidationError):
        raise invalid("its experiment or its versions are not texts") from None
    genome = _genome(kind, genes, np.frombuffer(content, np.uint8, offset=end))
    return Challenge(text, genome, generation, member or None, score, versions)


def _genome(kind: bytes, genes: int, data: NDArray[np.uint8]) -> NDArray[Any]:
    """Return the genome, (genes,), writable."""
    if kind == _BITS:
        return np.unpackbits(data, count=genes)
    if kind == _BYTES:
        return data.copy()
    genome = np.ascontiguousarray(data.reshape(8, genes).T).view("<f8").reshape(-1)
    if not np.isfinite(genome).all():
        raise invalid("a gene is not finite")
    return genome.astype(np.float64)


@dataclass(frozen=True, eq=False, repr=False)
class CodeVerdict(ReprMixin):
    """The result of verifying a challenge code.

    Attributes:
        challenge: content of the code.
        score: score of the individual on this machine; −inf if it fails.
        terms: terms of that score by name.
        failure: reason why the individual fails on this machine, or ''.
        version_differences: one message for each difference between the versions in the code and
            the installed versions.
    """

    challenge: Challenge
    score: float
    terms: dict[str, float]
    failure: str
    version_differences: tuple[str, ...]

    @property
    def identical(self) -> bool:
        """Whether the score equals the claimed score, to the last bit."""
        return struct.pack("d", self.score) == struct.pack("d", self.challenge.score)

    def _repr_fields(self) -> Mapping[str, ReprField]:
        return {
            "identical": self.identical,
            "claimed": self.challenge.score,
            "score": self.score,
            "terms": self.terms,
            "failure": self.failure,
            "version_differences": "; ".join(self.version_differences),
        }


def verify_challenge(challenge: Challenge) -> CodeVerdict:
    """Replay a challenge's individual in the worlds of its generation and compare the scores.

    Raises:
        ExperimentError: the experiment has problems, such as a plugin that is not installed.
        GaitsimError: the genome does not fit the body.
        PluginError: a plugin fails.
    """
    individual = challenge.individual
    experiment = individual.experiment
    made = Provenance(challenge.generation, dict(challenge.versions))
    found = evaluate(experiment, challenge.genome[None], challenge.generation)
    return CodeVerdict(
        challenge,
        float(found.scores[0]),
        found.terms_of(0),
        found.reasons.get(0, ""),
        tuple(differences([made], current_versions(experiment))),
    )


def find_challenge(reference: str) -> Challenge | None:
    """Return the challenge in a text that contains a code, or in a file that contains one.

    Returns None for other texts and files, and for the name or folder of a run.

    Raises:
        GaitsimError: the code has a different format, or is damaged or invalid, or the file cannot
            be read.
    """
    # Unlike pathlib, os.path accepts names that are invalid for files.
    if os.path.isfile(reference):  # noqa: PTH113
        try:
            data = read_regular(Path(reference), 2 * LONGEST, follow=True)
        except OSError as error:
            raise GaitsimError(f"cannot read {reference}: {error.strerror}") from None
        encoding = "utf-16" if data.startswith((BOM_UTF16_BE, BOM_UTF16_LE)) else "utf-8"
        text = data.decode(encoding, "replace")
    elif any(holds_run(path) for path in (Path(reference), RUNS / reference)):
        return None
    else:
        text = reference
    return Challenge.read(text) if contains_code(text) else None
