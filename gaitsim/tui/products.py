"""The products of a run: plots, files and other products, as forms and commands.

The forms come from the same declarations as the commands.
"""

import json
import shlex
from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Any

from pydantic import BaseModel
from pydantic.fields import FieldInfo

from gaitsim.actions.action import Action, SeveralIndividuals
from gaitsim.actions.analyse import Analyse
from gaitsim.actions.differences import Differences
from gaitsim.actions.plot import MakePlot
from gaitsim.actions.products import ALL, SWITCHES, fields, fields_of_all
from gaitsim.actions.video import MakeVideo
from gaitsim.errors import GaitsimError
from gaitsim.opening import read_regular
from gaitsim.registry import COMMANDS, entries, find, load_class, options
from gaitsim.registry.loading import call_product, load_object, products
from gaitsim.registry.options import declared, flag, read_options, validated, value_type
from gaitsim.storage.files.atomic import write_bytes
from gaitsim.storage.files.folder import EXPORTS
from gaitsim.storage.settings import user_folder

if TYPE_CHECKING:
    from gaitsim.individual import Individual


@dataclass(frozen=True)
class CommandForm:
    """A command with a form.

    Attributes:
        title: name in a list.
        command: words of the command, without the run.
        action: model of the command's options; None for a plot or an export.
        plugin: kind and name of the plugin of a plot or an export.
    """

    title: str
    command: tuple[str, ...]
    action: type[Action] | None = None
    plugin: tuple[str, str] = ("", "")

    def fields(self) -> dict[str, FieldInfo]:
        """Return the options of the form by name."""
        if self.action is not None:
            known = self.action.model_fields
            return {
                name: field
                for name, field in known.items()
                if name not in self.action.not_in_forms and declared(field, "argument") != "hidden"
            }
        kind, name = self.plugin
        found = fields_of_all(kind) if name == ALL else fields(load_class(kind, name))  # type: ignore[arg-type]
        return found | ({"format": MakePlot.model_fields["format"]} if kind == "plot" else {})

    def read(
        self, run: Path | None, texts: Mapping[str, str]
    ) -> tuple[tuple[str, ...], dict[str, GaitsimError]]:
        """Read typed options; return the arguments of `gaitsim`, or () and the problems by name."""
        known = self.fields()
        typed = {name: text.strip() for name, text in texts.items() if name in known}
        given = self._values(texts)
        problems: dict[str, GaitsimError] = {}
        for model in self._models():
            own = {name: value for name, value in given.items() if name in model.model_fields}
            hidden = {
                name: str(run)
                for name, field in model.model_fields.items()
                if declared(field, "argument") and name not in own
            }
            problems |= read_options(model, hidden | own)[1]
        for name, field in known.items():
            needed = declared(field, "argument") and (run is None or value_type(field) == list[str])
            if needed and not given.get(name):
                problems[name] = GaitsimError(f"invalid {name}: ''", allowed="a value")
        if problems:
            return (), problems
        return self._arguments(run, known, typed), {}

    def build(self, texts: Mapping[str, str]) -> Action:
        """Return the action of a form, with typed options."""
        assert self.action is not None, "plots and exports are plugins"
        return validated(self.action, self._values(texts))

    def _values(self, texts: Mapping[str, str]) -> dict[str, Any]:
        """Return the typed values, without unset ones."""
        known = self.fields()
        values = {name: _value(known[name], texts[name].strip()) for name in texts if name in known}
        return {name: value for name, value in values.items() if value is not None}

    def _models(self) -> tuple[type[BaseModel], ...]:
        if self.action is not None:
            return (self.action,)
        kind, name = self.plugin
        names = list(products(kind)) if name == ALL else [name]
        return SeveralIndividuals, *(load_class(kind, one) for one in names)

    def _arguments(
        self, run: Path | None, known: Mapping[str, FieldInfo], typed: Mapping[str, str]
    ) -> tuple[str, ...]:
        # The words of an action precede the run; the kind of a plot or an export follows it.
        words = 1 if self.action is None else len(self.command)
        subjects, flags = [str(run)] * (run is not None), list[str]()
        for name, text in typed.items():
            field = known[name]
            word, kind = flag(name, field), value_type(field)
            if text in ("", default(field)):
                continue
            if declared(field, "argument"):
                subjects = [*subjects, *split_words(text)] if kind == list[str] else [text]
            elif kind is bool:
                flags.append(word if text == "true" else f"--no-{word[2:]}")
            elif kind == list[str]:
                flags += [f"{word}={one}" for one in split_names(text)]
            elif kind == tuple[str, str]:
                flags += [word, *split_names(text)]
            elif declared(field, "written") and run is not None and Path(text).name == text:
                flags += [word, str(run / EXPORTS / text)]
            else:
                flags += [word, text]
        return (*self.command[:words], *subjects, *self.command[words:], *flags)

    def check(self, individual: "Individual") -> None:
        """Check that the product can be made from an individual and its run.

        Raises:
            GaitsimError: data are missing, or a package that is needed is not installed.
        """
        kind, name = self.plugin
        if self.action is not None:
            self.action.check(individual)
        elif name != ALL:
            product: Any = load_class(kind, name)()
            call_product(kind, name, "checking", object, product.check, individual)


def default(field: FieldInfo) -> str:
    """Return the text of an option's default."""
    return "" if field.is_required() else options.format_value(field, field.get_default())


def _value(field: FieldInfo, text: str) -> Any:
    """Return a typed value; None for an option that is not set."""
    if not text or (text == options.NOT_SET and options.optional(field)):
        return None
    kind = value_type(field)
    if kind == list[str] and declared(field, "argument"):
        return tuple(split_words(text))
    texts = kind in (str, Path, list[str], tuple[str, str])
    return options.convert_value(field, text if texts else options.parse_value(text), text)


@cache
def forms(menu: str = "") -> dict[str, tuple[CommandForm, ...]]:
    """Return the products of the export dialog by group, or the commands of a package's menu."""
    packages: dict[str, list[CommandForm]] = {"More": []}
    for name in entries(COMMANDS):
        with suppress(GaitsimError):  # `gaitsim --help` reports a broken command
            action = load_object(find(COMMANDS, name))
            if isinstance(action, type) and issubclass(action, Action) and action.menu:
                form = CommandForm(action.title, tuple(name.split(".")), action)
                packages.setdefault(action.menu, []).append(form)
    if menu:
        return {menu: tuple(packages.get(menu, ()))}
    groups: dict[str, list[CommandForm]] = {}
    for kind, heading in (("exporter", ""), ("plot", "Plot")):
        for name, one in products(kind).items():
            verb = "export" if kind == "exporter" else kind
            form = CommandForm(one.title, (verb, SWITCHES[kind], name), None, (kind, name))
            groups.setdefault(heading or one.group, []).append(form)
    groups["Plot"].append(CommandForm("All plots", ("plot", "--kind", ALL), None, ("plot", ALL)))
    actions: dict[str, type[Action]] = {
        "video": MakeVideo,
        "analyse": Analyse,
        "differences": Differences,
    }
    groups["More"] = [CommandForm(one.title, (verb,), one) for verb, one in actions.items()]
    groups["More"] += packages["More"]
    return {group: tuple(found) for group, found in groups.items()}


def _memory() -> Path:
    return user_folder("XDG_STATE_HOME", ".local/state") / "options.json"


def remembered(form: CommandForm) -> dict[str, str]:
    """Return the texts of those options of a form that are kept for the next time."""
    kept = form.action.remembered if form.action is not None else ()
    try:
        found = json.loads(read_regular(_memory(), 10_000, follow=True))
        return {name: str(found[name]) for name in kept if name in found}
    except (OSError, ValueError, TypeError, RecursionError):
        return {}


def remember(form: CommandForm, texts: Mapping[str, str]) -> None:
    """Keep the texts of those options of a form for the next time."""
    kept = form.action.remembered if form.action is not None else ()
    found = {name: texts[name] for name in kept if name in texts}
    if found:
        with suppress(OSError, GaitsimError):
            _memory().parent.mkdir(parents=True, exist_ok=True)
            write_bytes(_memory(), json.dumps(found).encode())


def unavailable_products(
    run: Path, forms: Sequence[CommandForm]
) -> dict[CommandForm, GaitsimError]:
    """Return the products that cannot be exported from a run, with the commands' errors.

    Raises:
        GaitsimError: nothing can be exported: the run has no champion, or its folder is read-only.
    """
    from gaitsim.storage.files.folder import exports_folder
    from gaitsim.storage.snapshot import RunSnapshot

    exports_folder(run)
    champion = RunSnapshot(run).individual()
    found = {}
    for form in forms:
        try:
            form.check(champion)
        except GaitsimError as error:
            found[form] = error
    return found


def split_names(text: str) -> list[str]:
    """Return the comma-separated names in a string; names may contain spaces."""
    return [name.strip() for name in text.split(",") if name.strip()]


def split_words(text: str) -> list[str]:
    """Return the words of a string; quoted words may contain spaces."""
    try:
        return shlex.split(text)
    except ValueError:  # a quotation mark is missing
        return [text]
