"""Motions of one or many individuals, all channels, as .npz, .csv or .parquet."""

import csv
import json
from collections.abc import Iterable, Iterator, Sequence
from contextlib import ExitStack
from itertools import islice
from pathlib import Path

import numpy as np

from gaitsim.contracts import Subject
from gaitsim.errors import GaitsimError, not_installed
from gaitsim.gait.changed import with_changed_body
from gaitsim.gait.gait_files import check_folder
from gaitsim.gait.motion_table import Columns, Place, motion_arrays, motion_columns
from gaitsim.individual import Individual
from gaitsim.storage.files.atomic import replacing
from gaitsim.storage.snapshot import RunSnapshot
from gaitsim.storage.verification import populations

_GROUP = 100  # individuals in a row group of Parquet


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
    count, individuals = _individuals(subject, every, population)
    subject.begin(count)
    moved = _advancing(individuals, subject)
    with replacing(path) as partial:
        if suffix == ".npz":
            arrays, about = motion_arrays(moved)
            text = np.array(json.dumps(about, ensure_ascii=False))
            with partial.open("wb") as file:
                np.savez_compressed(file, allow_pickle=False, about=text, **arrays)
            size = f"{len(about['channels'])} channels"
        else:
            write = _write_csv if suffix == ".csv" else _write_parquet
            rows, columns = write(partial, _tables(moved))
            size = f"{rows:,} rows × {columns} columns"
    return f"{count:,} individual{'s' * (count != 1)}, {size}"


def _individuals(
    subject: Subject, every: int | None, population: str | None
) -> tuple[int, Iterator[tuple[Individual, Place]]]:
    """Return the number of individuals, and each with its number in its population."""
    if every is None and population is None:
        return len(subject.individuals), ((individual, {}) for individual in subject.individuals)
    if not isinstance(subject.run, RunSnapshot):
        raise GaitsimError(
            "the options every and population need a whole run, not one individual",
            remedy="use the run itself, from gaitsim.load()",
        )
    run, chosen = subject.run, subject.individuals
    champion = run.individual()
    if [(one.generation, one.member) for one in chosen] != [(champion.generation, None)]:
        raise GaitsimError(
            "generations or a member cannot be combined with --every or --population",
            allowed="one of the two",
        )
    count, individuals = _of_run(run, every, population)
    # The damage and the world that the user chose apply to all.
    if changes := chosen[0].changes:
        individuals = ((with_changed_body(one, changes), place) for one, place in individuals)
    return count, individuals


def _of_run(
    run: RunSnapshot, every: int | None, population: str | None
) -> tuple[int, Iterator[tuple[Individual, Place]]]:
    if every is not None:
        best = run.history["best"]
        numbers = [n for n in range(every, run.generation + 1, every) if np.isfinite(best[n - 1])]
        if not numbers:
            raise GaitsimError(
                f"no generation to export: the run has {run.generation}", where="--every"
            )
        return len(numbers), ((run.individual(number), {}) for number in numbers)
    numbers = sorted({*_generations(population or "", run.generation)})
    sizes = [run.stage_at(number).outline for number in numbers]
    count = sum(one.evolution.population * one.islands.number for one in sizes)
    return count, _whole(run, numbers)


def _whole(run: RunSnapshot, numbers: Sequence[int]) -> Iterator[tuple[Individual, Place]]:
    """Yield all individuals of some generations."""
    for generation in populations(run, numbers):
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


def _advancing(
    individuals: Iterable[tuple[Individual, Place]], subject: Subject
) -> Iterator[tuple[Individual, Place]]:
    for one in individuals:
        yield one
        subject.advance(1)


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


def _tables(individuals: Iterable[tuple[Individual, Place]]) -> Iterator[Columns]:
    """Yield the columns of each individual, which must be the same for all."""
    names: list[str] = []
    for individual, place in individuals:
        columns = motion_columns(individual, place)
        names = names or [*columns]
        if names != [*columns]:
            raise GaitsimError(
                f"{individual.label} has other channels than the first individual",
                allowed="individuals of the same body",
                remedy="export the stages of the run to different files",
            )
        yield columns


def _write_csv(path: Path, tables: Iterable[Columns]) -> tuple[int, int]:
    """Write tables below each other, and return the numbers of rows and columns."""
    rows, columns = 0, 0
    with path.open("w", encoding="utf-8", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        for table in tables:
            if not rows:
                writer.writerow(table)
            writer.writerows(zip(*(values.tolist() for values in table.values()), strict=True))
            rows, columns = rows + len(table["frame"]), len(table)
    return rows, columns


def _check_pyarrow() -> None:
    try:
        import pyarrow  # noqa: F401
    except ImportError:
        raise not_installed("a .parquet file", "pyarrow", "pandas") from None


def _write_parquet(path: Path, tables: Iterable[Columns]) -> tuple[int, int]:
    """Write tables below each other, and return the numbers of rows and columns."""
    import pyarrow
    from pyarrow import parquet

    rows, columns = 0, 0
    with ExitStack() as resources:
        writer = None
        made = map(pyarrow.table, tables)
        while some := [*islice(made, _GROUP)]:
            group = pyarrow.concat_tables(some)
            if writer is None:
                writer = parquet.ParquetWriter(path, group.schema, compression="zstd")
                resources.callback(writer.close)
            writer.write_table(group)
            rows, columns = rows + group.num_rows, group.num_columns
    return rows, columns
