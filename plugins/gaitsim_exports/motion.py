"""Motions of one or many individuals, all channels, as .npz, .csv or .parquet."""

import csv
import io
import json
from collections.abc import Iterator, Mapping
from pathlib import Path

import numpy as np

from gaitsim.contracts import Subject
from gaitsim.errors import GaitsimError, not_installed
from gaitsim.gait.gait_files import check_folder
from gaitsim.gait.motion_table import Columns, motion_arrays, motion_columns
from gaitsim.individual import Individual
from gaitsim.storage.files.atomic import write_bytes
from gaitsim.storage.snapshot import RunSnapshot
from gaitsim.storage.verification import populations

Places = Mapping[str, int]


def write_motion(subject: Subject, path: Path, every: int | None, population: str | None) -> str:
    """Write a file, and return a description of its content.

    Args:
        subject: the chosen individuals, or the run.
        path: path of the file, whose suffix chooses its kind.
        every: interval of the generations whose best individuals to write; None for the chosen
            individuals.
        population: generations whose whole populations to write, as the option describes them.

    Raises:
        GaitsimError: the suffix is unknown, the options are invalid, or a package is missing.
    """
    suffix = path.suffix.lower()
    if suffix not in (".npz", ".csv", ".parquet"):
        raise GaitsimError(f"unknown extension for motions: {path}", allowed=".npz, .csv, .parquet")
    check_folder(path)
    if suffix == ".parquet":
        _check_pyarrow()
    if every is not None and population is not None:
        raise GaitsimError("--every and --population cannot be combined", allowed="one of the two")
    found = [*_individuals(subject, every, population)]
    individuals = [individual for individual, _ in found]
    places = [place for _, place in found]
    subject.begin(len(individuals))
    for individual in individuals:
        _ = individual.motion
        subject.advance(1)
    if suffix == ".npz":
        arrays, about = motion_arrays(individuals, places)
        write_bytes(path, _npz(arrays, json.dumps(about, ensure_ascii=False)))
        size = f"{len(about['channels'])} channels"
    else:
        columns = motion_columns(individuals, places)
        write_bytes(path, _csv(columns) if suffix == ".csv" else _parquet(columns))
        size = f"{len(columns['frame']):,} rows × {len(columns)} columns"
    plural = "s" * (len(individuals) != 1)
    rate = individuals[0].motion.frame_rate
    return f"{len(individuals):,} individual{plural}, {size} at {rate:g} Hz"


def _individuals(
    subject: Subject, every: int | None, population: str | None
) -> Iterator[tuple[Individual, Places]]:
    """Yield the individuals, each with its number in its population, if that is written."""
    if every is None and population is None:
        yield from ((individual, {}) for individual in subject.individuals)
        return
    if not isinstance(subject.run, RunSnapshot):
        raise GaitsimError(
            "the options every and population need a whole run, not one individual",
            remedy="use the run itself, from gaitsim.load()",
        )
    run = subject.run
    if every is not None:
        best = run.history["best"]
        numbers = [n for n in range(every, run.generation + 1, every) if np.isfinite(best[n - 1])]
        if not numbers:
            raise GaitsimError(
                f"no generation to export: the run has {run.generation}", where="--every"
            )
        yield from ((run.individual(number), {}) for number in numbers)
        return
    for generation in populations(run, _generations(population or "", run.generation)):
        experiment = run.experiment_at(generation.number)
        for index, genome in enumerate(generation.genomes):
            individual = Individual(
                experiment,
                float(generation.scores[index]),
                generation.evaluation.terms_of(index),
                generation.number,
                genome,
                run.path,
            )
            yield individual, {"individual": index + 1}


def _generations(text: str, last: int) -> list[int]:
    """Return the generations of the option `population`."""
    words = text.removeprefix("every").strip()
    if text == "last":
        return [last]
    parts = [part.strip() for part in words.split(",")]
    numbers = [int(part) for part in parts if part.isascii() and part.isdecimal()]
    every = words != text
    if len(numbers) < len(parts) or (every and len(numbers) > 1) or not all(numbers):
        raise GaitsimError(
            f"invalid generations: {text!r}",
            where="--population",
            allowed="'last', numbers separated by commas, such as 10,20, or 'every N'",
        )
    found = [*range(numbers[0], last + 1, numbers[0])] if every else numbers
    if not found:
        raise GaitsimError(f"no generation to export: the run has {last}", where="--population")
    return found


def _npz(arrays: Columns, about: str) -> bytes:
    file = io.BytesIO()
    np.savez_compressed(file, allow_pickle=False, about=np.array(about), **arrays)
    return file.getvalue()


def _csv(columns: Columns) -> bytes:
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(columns)
    writer.writerows(zip(*(values.tolist() for values in columns.values()), strict=True))
    return text.getvalue().encode()


def _check_pyarrow() -> None:
    try:
        import pyarrow  # noqa: F401
    except ImportError:
        raise not_installed("a .parquet file", "pyarrow", "pandas") from None


def _parquet(columns: Columns) -> bytes:
    import pyarrow
    from pyarrow import parquet

    file = io.BytesIO()
    parquet.write_table(pyarrow.table(columns), file, compression="zstd")
    return file.getvalue()
