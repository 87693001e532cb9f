"""An experiment that is being put together: a ready one, and what is changed in it.

What is changed is kept as the command line's assignments, so the UI can make nothing that
`gaitsim run … --set …` cannot. Pure: no screen, no file but those read.
"""

import re
import shlex
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

from pydantic import BaseModel
from pydantic.fields import FieldInfo
from pydantic_core import to_jsonable_python

from gaitsim import toml
from gaitsim.errors import ExperimentError, GaitsimError
from gaitsim.experiment import (
    Evolution,
    Experiment,
    Islands,
    Typed,
    load_experiment,
    parse_experiment,
)
from gaitsim.registry import KINDS, options
from gaitsim.registry.class_validation import PLUGIN
from gaitsim.runs.files.folder import RUNS
from gaitsim.tui.catalogue import Catalogue

SECTIONS = ("evolution", "islands", *KINDS)
_KEY = re.compile(r"\bkey ([\w.-]+)")
_SECTION = re.compile(r"\bsection (\w+)")


@dataclass(frozen=True, eq=False)
class Ready:
    """A ready experiment: a preset or a file.

    Attributes:
        reference: a preset's name or a file's path, as `gaitsim run` takes it.
        text: as resolved TOML.
        values: the same, by section and key.
    """

    reference: str
    text: str
    values: Mapping[str, Any]

    def plugin(self, kind: str) -> str:
        """The name of its plugin of a kind."""
        return str(self.values[kind][PLUGIN])


def load_ready(reference: str) -> Ready:
    """The ready experiment of a preset's name or a file's path.

    Raises:
        GaitsimError: there is none, or it has problems.
    """
    text = load_experiment(reference).to_toml()
    return Ready(reference, text, toml.parse(text, reference))


@dataclass(frozen=True)
class Draft:
    """A ready experiment, and what is changed in it.

    Attributes:
        ready: the ready experiment.
        changes: what is assigned, as text, by key; in the order in which it was.
    """

    ready: Ready
    changes: Mapping[str, str] = field(default_factory=dict)

    @property
    def overrides(self) -> dict[str, Typed]:
        """The changes. The choice of a plugin stands before its options."""
        keys = sorted(self.changes, key=lambda key: not key.endswith(f".{PLUGIN}"))
        return {key: Typed(self.changes[key].strip()) for key in keys}

    def assign(self, key: str, text: str | None) -> "Draft":
        """With an option changed; None leaves it as it is in the ready experiment."""
        changes = {name: value for name, value in self.changes.items() if name != key}
        return replace(self, changes=changes if text is None else changes | {key: text})

    def choose(self, kind: str, name: str) -> "Draft":
        """With another plugin; what was changed of the old one's options is dropped."""
        changes = {k: v for k, v in self.changes.items() if not k.startswith(f"{kind}.")}
        chosen = {} if name == self.ready.plugin(kind) else {f"{kind}.{PLUGIN}": name}
        return replace(self, changes=changes | chosen)

    def command(self, run: Path) -> str:
        """The command that evolves it, its run in the folder `run`."""
        words = ["gaitsim", "run", self.ready.reference]
        for key in self.overrides:
            words += ["--set", f"{key}={self.changes[key]}"]
        if run.parent != RUNS:
            words += ["--out", str(run)]
        return shlex.join(words)


@dataclass(frozen=True)
class Option:
    """An option of a form.

    Attributes:
        key: as `--set` takes it.
        field: its declaration.
        ready: its text where it is not changed.
        text: its text now.
    """

    key: str
    field: FieldInfo
    ready: str
    text: str


@dataclass(frozen=True)
class Form:
    """A section of the experiment.

    Attributes:
        section: its name.
        plugin: the name of its plugin; '' for evolution.
        about: what the plugin is.
        options: its options.
        problem: why there are none.
    """

    section: str
    plugin: str
    about: str = ""
    options: tuple[Option, ...] = ()
    problem: GaitsimError | None = None


@dataclass(frozen=True)
class Reading:
    """What a draft says.

    Attributes:
        draft: what was read.
        experiment: as it would be evolved; None where it has problems.
        problems: all of them, by the key or section where they are; '' for any other place.
        forms: the sections, by name.
        offered: the plugins that work with the rest, by kind.
        toml: the experiment file; '' where it has problems.
    """

    draft: Draft
    experiment: Experiment | None
    problems: Mapping[str, GaitsimError]
    forms: Mapping[str, Form]
    offered: Mapping[str, tuple[str, ...]]
    toml: str

    @property
    def name(self) -> str:
        """Of the experiment."""
        return self.draft.changes.get("name", str(self.draft.ready.values["name"]))

    def chosen(self, kind: str) -> str:
        """The plugin of a kind."""
        return self.forms[kind].plugin


def read(draft: Draft, catalogue: Catalogue) -> Reading:
    """Read a draft, with all its problems."""
    ready = draft.ready
    problems: dict[str, GaitsimError] = {}
    experiment = None
    try:
        experiment = parse_experiment(ready.text, ready.reference, draft.overrides)
        written = experiment.to_toml()
    except ExperimentError as error:
        written = ""
        for problem in error.problems:
            problems.setdefault(key_of(problem), problem)
    except GaitsimError as error:
        written, problems[""] = "", error
    forms = {section: _form(section, draft, catalogue) for section in SECTIONS}
    offered = catalogue.offered(forms["organism"].plugin, experiment)
    return Reading(draft, experiment, problems, forms, offered, written)


def choose(reading: Reading, kind: str, name: str, catalogue: Catalogue) -> Draft:
    """The draft with another plugin; another body brings parts that work with it.

    What does not work with a body gives way to what a ready experiment of that body has.
    """
    draft = reading.draft.choose(kind, name)
    if kind != "organism":
        return draft
    offered = catalogue.offered(name, None)
    model = catalogue.preset_of(name)
    for other in ("fitness", "crossover", "mutation"):
        works = offered[other]
        if works and reading.chosen(other) not in works:
            usual = model.plugins.get(other, "") if model else ""
            best = usual if usual in works else works[0]
            draft = draft.choose(other, best)
    return draft


def key_of(problem: GaitsimError) -> str:
    """The key or section where a problem is, by its own words."""
    found = _KEY.search(problem.where) or _SECTION.search(problem.where)
    return found[1] if found else ""


def _form(section: str, draft: Draft, catalogue: Catalogue) -> Form:
    model: type[BaseModel] = Islands if section == "islands" else Evolution
    plugin = about = ""
    values: Mapping[str, Any] = draft.ready.values[section]
    if section in KINDS:
        ready = draft.ready.plugin(section)
        plugin = draft.changes.get(f"{section}.{PLUGIN}", ready)
        if plugin != ready:
            values = {}
        known = catalogue.classes[section].get(plugin)
        if known is None:
            problem = catalogue.failure(section, plugin)
            return Form(section, plugin, problem=problem)
        model, about = known, catalogue.about(section, plugin)
    made = []
    for name, declared in model.model_fields.items():
        key = f"{section}.{name}"
        text = options.written(declared, values[name]) if name in values else _default(declared)
        made.append(Option(key, declared, text, draft.changes.get(key, text)))
    return Form(section, plugin, about, tuple(made))


def _default(declared: FieldInfo) -> str:
    if declared.is_required():
        return ""
    value = declared.get_default(call_default_factory=True)
    return options.written(declared, to_jsonable_python(value, serialize_unknown=True))
