"""Read a study file, and report all its problems at once."""

import itertools
import json
import math
import os
from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Annotated, Any, Self

from pydantic import BaseModel, ConfigDict, Field, ValidationError, model_validator

from gaitsim.plugin import (
    STUDIES,
    ExperimentError,
    GaitsimError,
    option,
    options,
    read_preset,
    toml,
)
from gaitsim.plugin.runs import (
    Experiment,
    Problems,
    invalid_value,
    load_experiment,
    missing_option,
    read_file,
)

SCHEMA = 1
MOST_CELLS = 100_000
MOST_SCORES = 50_000_000  # in all cells, repeats and recorded generations: 400 MB
LEAST_FRESH = 100  # fresh repeats; fewer do not suffice for intervals of skewed scores
_MOST_PROBLEMS = 20
STUDY = "study.toml"  # the file of a study in its folder
EXPERIMENT = "experiment"  # the axis that every study has
POPULATION = "evolution.population"
STATISTICS = ("mean", "std", "median", "q25", "q75", "min", "max")
RESERVED = (EXPERIMENT, "generation", "evaluations", "repeats", *STATISTICS)

Scalar = int | float | str | bool


class Range(BaseModel):
    """Equally spaced numbers: `from`, `from` + `step` and so on, up to and including `to`."""

    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False)

    start: int | float = Field(alias="from")
    to: int | float
    step: int | float = Field(1, gt=0)

    @model_validator(mode="after")
    def _check(self) -> Self:
        if self.to < self.start:
            raise ValueError(f"the range from {self.start} to {self.to} is empty")
        if (self.to - self.start) / self.step > MOST_CELLS:
            raise ValueError(f"the range has more than {MOST_CELLS:,} values")
        return self

    def values(self) -> list[Scalar]:
        """Return the numbers; integers if `from` and `step` are integers."""
        count = int((self.to - self.start) / self.step + 1e-9) + 1
        found = [self.start + index * self.step for index in range(count)]
        # Rounded, so that 0.1 + 0.1 + 0.1 becomes 0.3, as users would write it.
        return [float(f"{one:.12g}") if isinstance(one, float) else one for one in found]


class Published(BaseModel):
    """A published cell at which the target was reached."""

    model_config = ConfigDict(frozen=True, extra="forbid")

    population: int = Field(ge=1)
    generations: int = Field(ge=1)


class Study(BaseModel):
    """The experiments and axes of a sweep, its repeats, and the generations to record."""

    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False)

    schema_: int = Field(SCHEMA, alias="schema", ge=1, description="version of the file format")
    name: Annotated[str, Field(pattern=r"^[A-Za-z0-9_][A-Za-z0-9_. -]*$", max_length=200)] = Field(
        "study", description="name of the study and its folder: letters, digits, '_', '-', '.'"
    )
    description: str = option("", "description on one line, for lists")
    experiments: Annotated[tuple[str, ...], Field(min_length=1)] = Field(
        description="presets or files of experiments, the first axis"
    )
    set: dict[str, Any] = Field(
        default={},
        description="options to change in all experiments, such as { 'mutation.rate' = 0.1 }",
    )
    repeats: int = option(30, "number of repeats of each cell", ge=1, le=1_000_000)
    record_every: int = option(1, "interval between recorded generations", ge=1)
    target: float | None = option(None, "mean best score to reach")
    confirm: int | None = option(
        None,
        "number of fresh repeats in each of two sets: the first chooses a cell, the second tests "
        "whether it reaches the target; none means ten times 'repeats', at least 100",
        ge=LEAST_FRESH,
        le=1_000_000,
    )
    axes: dict[str, Range | tuple[Scalar, ...]] = Field(
        default={}, description="values of options, such as 'mutation.rate' = [0.01, 0.1]"
    )
    published: dict[str, Published] = Field(
        default={},
        description="published cells by experiment, shown beside the results; 'never' if missing",
    )

    def values(self, axis: str) -> list[Scalar]:
        """Return the values of an axis, in order."""
        given = self.axes[axis]
        return given.values() if isinstance(given, Range) else list(given)

    @property
    def fresh(self) -> "Study":
        """The same study, with `repeats` set to the number of fresh repeats."""
        default = max(LEAST_FRESH, 10 * self.repeats)
        return self.model_copy(update={"repeats": self.confirm or default})


@dataclass(frozen=True)
class Cell:
    """One point of the sweep.

    Attributes:
        index: position of the cell, counted from 0; the last axis varies fastest.
        point: values of the cell by the names of the axes, the experiment first.
        experiment: experiment to repeat. Unless the seed is an axis, it is the seed of the study's
            first experiment plus the index.
    """

    index: int
    point: dict[str, Scalar]
    experiment: Experiment


def read_study(reference: str) -> tuple[Study, str]:
    """Return a study and its text, from the name of a bundled study or the path of a TOML file."""
    path = Path(reference)
    if path.suffix == ".toml" or path.name != reference:
        template = "the study.toml that 'gaitsim study millipede-operators' writes"
        text = read_file(path, "study", template, "name a bundled study: millipede-operators")
        source = str(path)
    else:
        text, source = read_preset(reference, STUDIES), f"study {reference}"
    return parse_study(text, source), text


def parse_study(text: str, source: str) -> Study:
    """Return the study that a TOML text describes."""
    problems = Problems(source)
    try:
        data = toml.parse(text, source)
    except GaitsimError as error:
        raise ExperimentError([error], "study") from None
    schema = data.get("schema", SCHEMA)
    if isinstance(schema, int) and schema > SCHEMA:
        problems.report(
            "schema",
            f"schema {schema} belongs to a newer version of gaitsim",
            f"up to {SCHEMA}",
            "update gaitsim: pip install --upgrade gaitsim",
        )
        raise ExperimentError(problems.found, "study")
    try:
        study = Study.model_validate_json(json.dumps(data, default=str), strict=True)
    except ValidationError as error:
        _explain(problems, data, error)
        raise ExperimentError(problems.found, "study") from None
    for axis, values in study.axes.items():
        if axis in RESERVED:
            problems.report(
                f"axes.{axis}",
                f"{axis!r} is a column of the study's results, so it cannot be an axis",
            )
        elif isinstance(values, tuple) and not values:
            problems.report(f"axes.{axis}", "the axis has no values", "at least one value")
        elif len(set(map(str, study.values(axis)))) < len(study.values(axis)):
            problems.report(f"axes.{axis}", "the axis has a value twice", "different values")
        if axis in study.set:
            problems.report(
                f"axes.{axis}", f"{axis!r} is both an axis and in 'set'", "one of the two"
            )
    if len(set(study.experiments)) < len(study.experiments):
        problems.report("experiments", "an experiment is listed twice", "different experiments")
    for experiment in study.published:
        if experiment not in study.experiments:
            problems.report(
                f"published.{experiment}",
                f"{toml.literal(experiment)} is not among the study's experiments",
                ", ".join(study.experiments),
            )
    if problems.found:
        raise ExperimentError(problems.found, "study")
    return study


def _explain(problems: Problems, data: Mapping[str, Any], error: ValidationError) -> None:
    met = set()
    fields = {field.alias or name: field for name, field in Study.model_fields.items()}
    for detail in error.errors(include_url=False):
        # Pydantic reports a problem for each member of a union; one is enough.
        parts = [str(part) for part in detail["loc"][:2]]
        key = ".".join(parts)
        if key in met:
            continue
        met.add(key)
        if detail["type"] == "extra_forbidden" and len(detail["loc"]) == 1:
            problems.add_unknown_key("", parts[0], list(fields))
        elif detail["type"] == "missing" and len(detail["loc"]) == 1:
            problems.report(key, missing_option(key, fields[parts[0]]))
        elif parts[0] == "axes":
            problems.report(
                key,
                str(detail["ctx"]["error"]) if detail["type"] == "value_error" else detail["msg"],
                "a list of values, or { from = 3, to = 79, step = 2 }",
            )
        else:
            field = fields[parts[0]]
            what = invalid_value(key, toml.literal(data.get(parts[0])), options.meaning(field))
            problems.report(key, what, options.allowed(field))


def experiment_files(study: Study) -> dict[str, str]:
    """Return the study's experiments as the texts of files: `1.toml`, `2.toml` …

    The files are stored with the study, which then does not depend on installed presets.
    """
    return {
        f"{place}.toml": load_experiment(reference).to_toml()
        for place, reference in enumerate(study.experiments, 1)
    }


def cells(study: Study, folder: Path | None = None, source: str = "the study") -> list[Cell]:
    """Return every cell of a study, with its experiment loaded and checked.

    Args:
        study: the study.
        folder: folder of the files of `experiment_files`; None loads the experiments by name.
        source: origin of the study, for errors.
    """
    axes: dict[str, list[Scalar]] = {EXPERIMENT: [*study.experiments]}
    axes |= {axis: study.values(axis) for axis in study.axes}
    count = math.prod(map(len, axes.values()))
    if count > MOST_CELLS:
        raise GaitsimError(
            f"the study {study.name} has {count:,} cells", allowed=f"at most {MOST_CELLS:,}"
        )
    found: list[Cell] = []
    problems: dict[str, GaitsimError] = {}
    scores = fresh = 0
    for index, values in enumerate(itertools.product(*axes.values())):
        point = dict(zip(axes, values, strict=True))
        changes = study.set | {axis: point[axis] for axis in study.axes}
        try:
            name = str(point[EXPERIMENT])
            kept = folder / f"{study.experiments.index(name) + 1}.toml" if folder else None
            reference = str(kept) if kept and os.path.lexists(kept) else name
            experiment = load_experiment(reference, changes, source)
            # Cells must be independent samples: equal random numbers would bias all of them alike.
            if "seed" not in study.axes:
                first = found[0].experiment.seed if found else experiment.seed
                experiment = replace(experiment, seed=(first + index) % 2**63)
        except ExperimentError as error:
            for problem in error.problems:
                problems[str(problem)] = problem
        except GaitsimError as error:
            problems[str(error)] = error
        else:
            found.append(Cell(index, point, experiment))
            recorded = -(-experiment.evolution.generations // study.record_every)
            scores += study.repeats * recorded
            fresh = 0 if study.target is None else study.fresh.repeats * recorded
        if max(scores, fresh) > MOST_SCORES:
            raise GaitsimError(
                f"the study {study.name} would record more than {MOST_SCORES:,} scores",
                where=source,
                allowed=f"at most {MOST_SCORES:,} over all cells, repeats and recorded "
                "generations, and in the fresh repeats of one cell",
                remedy="record fewer generations with 'record_every', or lower 'repeats' or "
                "'confirm'",
            )
        if len(problems) >= _MOST_PROBLEMS:
            problems[""] = GaitsimError(f"cells after the first {index + 1:,} were not checked")
            break
    if problems:
        raise ExperimentError(list(problems.values()), "study")
    return found
