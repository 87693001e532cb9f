"""An experiment under construction: a preset and changes to it.

Changes are stored as the values of `--set`, so the UI can build only experiments that
`gaitsim run … --set …` can build too. This module does not depend on screens.
"""

import shlex
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

from pydantic import BaseModel
from pydantic.fields import FieldInfo
from pydantic_core import to_jsonable_python

from gaitsim import toml
from gaitsim.contracts import Question, Search
from gaitsim.errors import ExperimentError, GaitsimError
from gaitsim.experiment import (
    TRANSFERABILITY,
    WORLD,
    Evolution,
    Experiment,
    Islands,
    Transferability,
    Typed,
    Worlds,
    load_experiment,
    parse_experiment,
)
from gaitsim.experiment.loading import is_body_file
from gaitsim.registry import KINDS, options
from gaitsim.registry.options import OPERATORS, PLUGIN
from gaitsim.storage.files.folder import RUNS
from gaitsim.tui.catalogue import Catalogue

SECTIONS = ("evolution", "islands", "worlds", TRANSFERABILITY, *KINDS)
ASKED = 2  # questions about a body's file that fit below the form
_MODELS: Mapping[str, type[BaseModel]] = {
    "evolution": Evolution,
    "islands": Islands,
    "worlds": Worlds,
    TRANSFERABILITY: Transferability,
}


@dataclass(frozen=True, eq=False)
class LoadedPreset:
    """A preset or experiment file.

    Attributes:
        reference: name of a preset or path of a file, as for `gaitsim run`.
        text: resolved experiment as TOML.
        values: the same values by section and key.
    """

    reference: str
    text: str
    values: Mapping[str, Any]

    def plugin(self, kind: str) -> str:
        """Return the name of its plugin of a kind; '' for an operator that its search lacks."""
        return str(self.values.get(kind, {}).get(PLUGIN, ""))


def load_preset(reference: str) -> LoadedPreset:
    """Read a preset by its name, or an experiment file by its path."""
    text = load_experiment(reference).to_toml()
    return LoadedPreset(reference, text, toml.parse(text, reference))


@dataclass(frozen=True)
class ExperimentBuilder:
    """A preset and changes to it.

    Attributes:
        preset: preset to start from.
        changes: strings typed by the user, by key, in the order of typing.
    """

    preset: LoadedPreset
    changes: Mapping[str, str] = field(default_factory=dict)

    @property
    def overrides(self) -> dict[str, Typed]:
        """The changes, with each choice of a plugin before its options."""
        keys = sorted(self.changes, key=lambda key: not key.endswith(f".{PLUGIN}"))
        return {key: Typed(self.changes[key].strip()) for key in keys}

    @property
    def changes_text(self) -> str:
        """The number of changes, such as '2 changes'."""
        return f"{len(self.changes)} change{'s' * (len(self.changes) != 1)}"

    def assign(self, key: str, text: str | None) -> "ExperimentBuilder":
        """Return a copy with a changed option; None restores the preset's value."""
        changes = {name: value for name, value in self.changes.items() if name != key}
        return replace(self, changes=changes if text is None else changes | {key: text})

    def choose(self, kind: str, name: str) -> "ExperimentBuilder":
        """Return a copy with a different plugin, without changes to options of the old one."""
        chosen = {} if name == self.preset.plugin(kind) else {f"{kind}.{PLUGIN}": name}
        return replace(self, changes={**self.drop(kind).changes, **chosen})

    def drop(self, section: str) -> "ExperimentBuilder":
        """Return a copy without changes to a section."""
        kept = {k: v for k, v in self.changes.items() if not k.startswith(f"{section}.")}
        return replace(self, changes=kept)

    def plugin(self, kind: str) -> str:
        """Return the name of the chosen plugin; '' if there is none."""
        return self.changes.get(f"{kind}.{PLUGIN}", self.preset.plugin(kind))

    def command(self, run: Path) -> str:
        """Return the command that evolves the experiment into the run folder `run`."""
        words = ["gaitsim", "run", self.preset.reference]
        for key in self.overrides:
            words += ["--set", f"{key}={self.changes[key]}"]
        if run.parent != RUNS:
            words += ["--out", str(run)]
        return shlex.join(words)


@dataclass(frozen=True)
class Option:
    """An option of a form.

    Attributes:
        key: key of the option, as for `--set`.
        field: declaration of the option.
        preset: text of the preset's value, shortened if it is long.
        text: current text.
        long: whether the text of the preset's value is long.
    """

    key: str
    field: FieldInfo
    preset: str
    text: str
    long: bool = False


@dataclass(frozen=True)
class Form:
    """A section of the experiment.

    Attributes:
        section: name of the section.
        plugin: name of its plugin; '' for a section without one, such as evolution.
        about: documentation of the plugin.
        options: options of the section.
        problem: reason why the plugin cannot be loaded; None if it can.
    """

    section: str
    plugin: str
    about: str = ""
    options: tuple[Option, ...] = ()
    problem: GaitsimError | None = None


@dataclass(frozen=True)
class Validation:
    """The result of checking an experiment under construction.

    Attributes:
        builder: builder of the experiment.
        experiment: the experiment; None if it has problems.
        problems: problems by key or section; '' for a problem elsewhere.
        forms: forms of the sections by name.
        offered: plugins that work with the other parts, by kind.
        toml: experiment file with long values shortened; '' if it cannot be read.
        effect: a line about the effect of the experiment; '' if it has problems.
        warnings: likely mistakes in the options of the body.
        questions: guesses about the file of the body, which its options answer.
    """

    builder: ExperimentBuilder
    experiment: Experiment | None
    problems: Mapping[str, GaitsimError]
    forms: Mapping[str, Form]
    offered: Mapping[str, tuple[str, ...]]
    toml: str
    effect: str = ""
    warnings: tuple[str, ...] = ()
    questions: tuple[Question, ...] = ()

    @property
    def used_sections(self) -> tuple[str, ...]:
        """The sections that the experiment has."""
        return tuple(section for section in SECTIONS if section in self.forms)

    @property
    def name(self) -> str:
        """The name of the experiment."""
        return self.builder.changes.get("name", str(self.builder.preset.values["name"]))

    @property
    def summary(self) -> str:
        """The effect of the experiment with warnings and questions, or its first problem."""
        if not self.problems:
            asked = [f"\n? {one.text} ({one.option})" for one in self.questions[:ASKED]]
            if len(self.questions) > ASKED:
                asked.append(f" … and {len(self.questions) - ASKED} more")
            return "\n⚠ ".join([self.effect, *self.warnings]) + "".join(asked)
        key, first = next(iter(self.problems.items()))
        more = f"  (and {len(self.problems) - 1} more)" if len(self.problems) > 1 else ""
        parts = [first.what, first.allowed and f"allowed: {first.allowed}", first.remedy]
        place = "" if key in first.what else f"{key}: "
        return f"✗ {place}{'; '.join(filter(None, parts))}{more}"


def validate(
    builder: ExperimentBuilder,
    catalogue: Catalogue,
    effect: Callable[[Validation], str] = lambda found: "",
) -> Validation:
    """Check an experiment and find all its problems.

    Args:
        builder: builder of the experiment.
        catalogue: installed plugins.
        effect: function that returns a line about the effect of a valid experiment, or raises a
            GaitsimError.
    """
    problems: dict[str, GaitsimError] = {}
    experiment = None
    warnings: tuple[str, ...] = ()
    questions: tuple[Question, ...] = ()
    try:
        experiment = _experiment(builder)
        written, warnings = experiment.to_toml(brief=True), experiment.warnings()
        if is_body_file(builder.preset.reference):
            questions = experiment.questions()
    except GaitsimError as error:
        written, problems = "", _by_option(error)
    forms = {
        section: _form(section, builder, catalogue)
        for section in SECTIONS
        if _uses(builder, catalogue, section)
    }
    offered = catalogue.offered(forms["organism"].plugin, experiment)
    found = Validation(
        builder, experiment, problems, forms, offered, written, "", warnings, questions
    )
    if problems:
        return found
    try:
        return replace(found, effect=effect(found))
    except GaitsimError as error:
        return replace(found, problems=_by_option(error))


def _by_option(error: GaitsimError) -> dict[str, GaitsimError]:
    """Return the problems of an error by the key of their option; '' for one without a key."""
    problems: dict[str, GaitsimError] = {}
    for problem in error.problems if isinstance(error, ExperimentError) else (error,):
        option = ".".join((problem.key or "").split(".")[:2])  # not one of its items
        problems.setdefault(option, problem)
    return problems


def _experiment(builder: ExperimentBuilder) -> Experiment:
    """Return the experiment. A robot's file is read again, as options may scale it."""
    preset = builder.preset
    if is_body_file(preset.reference):
        return load_experiment(preset.reference, builder.overrides)
    return parse_experiment(preset.text, preset.reference, builder.overrides)


def _uses(builder: ExperimentBuilder, catalogue: Catalogue, section: str) -> bool:
    """Return whether the chosen plugins use a section; True if one of them is unknown."""
    if section == "worlds":
        body = catalogue.classes["organism"].get(builder.plugin("organism"))
        return body is None or WORLD in body.model_fields
    search = catalogue.classes["search"].get(builder.plugin("search"))
    if search is None or not issubclass(search, Search):
        return True
    if section == "islands":
        return search.several
    if section == TRANSFERABILITY:
        return bool(search.keeps)
    return section not in OPERATORS or section in search.operators


def choose_plugin(
    validation: Validation, kind: str, name: str, catalogue: Catalogue
) -> ExperimentBuilder:
    """Return the builder with a different plugin.

    After a change of the organism or the search, incompatible parts are replaced by those of a
    preset of that organism; with its search, its population.
    """
    builder = validation.builder.choose(kind, name)
    if kind not in ("organism", "search"):
        return builder
    organism = builder.plugin("organism")
    offered = catalogue.offered(organism, None)
    model = catalogue.preset_of(organism)
    for other in ("fitness", "search", *OPERATORS):
        if not _uses(builder, catalogue, other):
            builder = builder.drop(other)
            continue
        works = offered[other]
        if works and builder.plugin(other) not in works:
            usual = model.plugins.get(other, "") if model else ""
            best = usual if usual in works else works[0]
            builder = builder.choose(other, best)
            if other == "search" and model and best == usual:
                population = load_preset(model.name).values["evolution"]["population"]
                builder = builder.assign("evolution.population", str(population))
    return builder


def _form(section: str, builder: ExperimentBuilder, catalogue: Catalogue) -> Form:
    model, plugin, about = _MODELS.get(section, Evolution), "", ""
    values: Mapping[str, Any] = builder.preset.values.get(section, {})
    if section in KINDS:
        plugin = builder.plugin(section)
        if plugin != builder.preset.plugin(section):
            values = {}
        known = catalogue.classes[section].get(plugin)
        if known is None:
            problem = catalogue.failure(section, plugin)
            return Form(section, plugin, problem=problem)
        model, about = known, catalogue.about(section, plugin)
    made = []
    for name, declared in model.model_fields.items():
        key = f"{section}.{name}"
        text = (
            options.format_brief(declared, values[name]) if name in values else _default(declared)
        )
        long = toml.is_long(values.get(name))
        made.append(Option(key, declared, text, builder.changes.get(key, text), long))
    return Form(section, plugin, about, tuple(made))


def _default(declared: FieldInfo) -> str:
    if declared.is_required():
        return ""
    value = declared.get_default(call_default_factory=True)
    return options.format_value(declared, to_jsonable_python(value, serialize_unknown=True))
