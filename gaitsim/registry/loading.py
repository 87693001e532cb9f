"""Load plugin classes, validated against their contracts, and the TOML files of packages."""

import re
from collections.abc import Callable, Mapping
from importlib.metadata import EntryPoint
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

from gaitsim.errors import GaitsimError, PluginError, unknown
from gaitsim.registry.entry_points import (
    ENGINES,
    EXPERIMENTS,
    REFLEX,
    Entry,
    PythonEntry,
    contract_error,
    entries,
    find,
    guard_process,
    plugin_errors,
)
from gaitsim.registry.kernel_cache import allow_missing_cache
from gaitsim.toml import parse

if TYPE_CHECKING:
    from gaitsim.contracts import Plugin, Product, Reflex

T = TypeVar("T")


def load_class(kind: str, name: str) -> "type[Plugin]":
    """Return the plugin class of a name, validated against its contract."""
    return load_entry(find(kind, name))


def load_entry(entry: Entry) -> "type[Plugin]":
    """Return the plugin class of an entry, validated against its contract."""
    # Imported here because listing names needs neither NumPy nor pydantic.
    from gaitsim import contracts
    from gaitsim.registry.options import problems

    if isinstance(entry, PythonEntry):
        from gaitsim.registry.python_plugins import plugin_class

        return plugin_class(entry)
    loaded = load_object(entry)
    expected: type[Plugin] = getattr(contracts, entry.kind.capitalize())
    contract = f"gaitsim.contracts.{expected.__name__}"
    if not (isinstance(loaded, type) and issubclass(loaded, expected)):
        named = isinstance(loaded, type)
        what = f"the class {loaded.__name__}" if named else f"a {type(loaded).__name__}"
        raise PluginError(
            f"{entry} is not a subclass of {expected.__name__}, but {what}",
            where=entry.target,
            allowed=f"a subclass of {contract}",
            remedy=f"correct the entry point in the pyproject.toml of {entry.package}",
        )
    abstract = sorted(getattr(loaded, "__abstractmethods__", ()))
    if abstract:
        raise contract_error(
            entry, f"does not implement {', '.join(abstract)}", f"every method of {contract}"
        )
    if found := problems(entry.kind, loaded):
        raise contract_error(entry, f"breaks its contract: {'; '.join(found)}", f"see {contract}")
    return loaded


def load_object(entry: Entry) -> Any:
    """Import the object of an entry; it can be anything."""
    allow_missing_cache()
    guard_process()
    with plugin_errors(entry, "being imported"):
        return EntryPoint(entry.name, entry.target, f"gaitsim.{entry.kind}").load()


def load_engine(name: str, own: str) -> Any:
    """Return the module of a physics engine that a package adds.

    Args:
        name: name of the engine, the value of a body's option `engine`.
        own: engine that the body needs no package for.

    Raises:
        GaitsimError: no installed package provides the engine; its key is 'engine'.
    """
    try:
        return load_object(find(ENGINES, name))
    except GaitsimError as error:
        error.key, error.allowed = "engine", ", ".join((own, *entries(ENGINES)))
        raise


def scan(kind: str) -> "tuple[dict[str, type[Plugin]], dict[str, GaitsimError]]":
    """Load every plugin of a kind; return the classes, and the errors of the others, by name."""
    classes: dict[str, type[Plugin]] = {}
    failures: dict[str, GaitsimError] = {}
    for name in entries(kind):
        try:
            classes[name] = load_class(kind, name)
        except GaitsimError as error:
            failures[name] = error
    return classes, failures


def read_preset(name: str, kind: str = EXPERIMENTS) -> str:
    """Return the TOML text of a preset or study.

    The package is imported only if it is in an archive.

    Args:
        name: name of the preset or study.
        kind: `EXPERIMENTS` or `STUDIES`.
    """
    entry = find(kind, name)
    with plugin_errors(entry, "being read"):
        text = _read(entry, f"{name}.toml")
    if text is None:
        raise contract_error(entry, f"has no file {name}.toml")
    return text


def describe_preset(name: str) -> str:
    """Return the description of a preset, or why it cannot be read."""
    try:  # not by an outline: that would import NumPy, and slow down lists
        return str(parse(read_preset(name), f"preset {name}").get("description", ""))
    except GaitsimError as error:
        return f"broken: {error.what}"


def summary(entry: Entry) -> str:
    """Return the first paragraph of the docstring of an entry's module, function or class.

    It is read from the source, because an import takes up to 100 ms; '' if it is not found there.
    """
    module, _, name = entry.target.partition(":")
    top, *inner = module.split(".")
    start = rf"^(?:class|def) {re.escape(name)}\b(?:(?!\n\S).|\n\))*?:\n[ \t]+" if name else r"\A"
    try:
        spec = find_spec(top)
        for folder in (spec and spec.submodule_search_locations) or ():
            file = Path(folder, *inner[:-1], f"{(inner or ['__init__'])[-1]}.py")
            text = file.read_text(encoding="utf-8")
            if found := re.search(start + _DOCSTRING, text, re.MULTILINE | re.DOTALL):
                return " ".join(found[1].split())
    except (OSError, ValueError, ImportError):
        pass
    return ""


_DOCSTRING = r'"""(.*?)(?:"""|\n[ \t]*\n)'


def _read(entry: Entry, file: str) -> str | None:
    # Only locate the package's folders: an import would run its code.
    top, *inner = entry.target.split(".")
    spec = find_spec(top)
    for folder in (spec and spec.submodule_search_locations) or ():
        path = Path(folder, *inner, file)
        if path.is_file():
            return path.read_text(encoding="utf-8-sig")
    from importlib.resources import files

    resource = files(entry.target) / file
    return resource.read_text(encoding="utf-8-sig") if resource.is_file() else None


def load_reflexes(tables: Mapping[str, Mapping[str, Any]]) -> "dict[str, Reflex]":
    """Return the reflexes that a body names in its option `reflexes`, in this order.

    Args:
        tables: options of each reflex by its name, such as `{"heading": {"gain": 4.0}}`.

    Raises:
        GaitsimError: a reflex is unknown or broken, does not have an option, or an option is
            invalid; its key is that of the option, such as `reflexes.heading.gain`.
    """
    return {name: _load_reflex(name, given) for name, given in tables.items()}


def _load_reflex(name: str, given: Mapping[str, Any]) -> "Reflex":
    from gaitsim.registry.options import validated

    table = f"reflexes.{name}"
    try:
        entry = find(REFLEX, name)
        model: type[Reflex] = load_entry(entry)  # type: ignore[assignment]
    except GaitsimError as error:
        error.key = table
        raise
    if not isinstance(given, Mapping):
        allowed = f"a table of options: {', '.join(model.model_fields) or 'none'}"
        raise GaitsimError(f"invalid {table}: {given!r}", where=table, allowed=allowed, key=table)
    for option in given:
        if option not in model.model_fields:
            key = f"{table}.{option}"
            what = f"option of the reflex {name!r}:"
            raise unknown(what, option, model.model_fields, where=key, key=key)
    with plugin_errors(entry, "validating its options"):
        return validated(model, given, table)


def call_reflex(name: str, doing: str, method: Callable[..., T], *given: Any) -> T:
    """Call a method of a reflex in each control step; an error names its package.

    Args:
        name: name of the reflex.
        doing: task of the method, such as 'starting'.
        method: method of the reflex.
        given: arguments of the method.

    Raises:
        GaitsimError: the method raises an error.
    """
    try:
        return method(*given)
    except BaseException:  # entered only now, as robots call reflexes thousands of times
        with plugin_errors(find(REFLEX, name), doing):
            raise


def products(kind: str) -> "dict[str, type[Product]]":
    """Return the plugins of a kind that can be loaded, by name, grouped as in menus."""
    found: dict[str, type[Product]] = scan(kind)[0]  # type: ignore[assignment]
    return dict(sorted(found.items(), key=lambda item: item[1].group))


def load_product(kind: str, name: str, options: Mapping[str, Any]) -> "Product":
    """Return a plugin with the options of a Python function; None stands for the default.

    Raises:
        GaitsimError: the plugin is unknown, does not have an option, or an option is invalid.
    """
    from gaitsim.registry.options import validated

    product: type[Product] = load_class(kind, name)  # type: ignore[assignment]
    given = {option: value for option, value in options.items() if value is not None}
    for option in given:
        if option not in product.model_fields:
            error = unknown(f"option of {name!r}", option, product.model_fields)
            others = [one for one, other in products(kind).items() if option in other.model_fields]
            if others:
                error.add_remedy(f"omit it, or choose {' or '.join(others)}")
            raise error
    return validated(product, given)


def call_product(
    kind: str, name: str, doing: str, returns: type[T], method: Callable[..., object], *given: Any
) -> T:
    """Call a method of a plot or an exporter; an error names its package.

    Args:
        kind: 'plot' or 'exporter'.
        name: name of the plugin.
        doing: task of the method, such as 'drawing'.
        returns: type of the result.
        method: method of the plugin.
        given: arguments of the method.

    Raises:
        GaitsimError: the method raises an error, or returns something else.
    """
    entry = find(kind, name)
    expected: GaitsimError | None = None
    with plugin_errors(entry, doing):
        try:
            found = method(*given)
        except GaitsimError as error:  # data are missing: the user's error, not the plugin's
            expected = error
    if expected is not None:
        raise expected
    if not isinstance(found, returns):
        what = f"returned a {type(found).__name__} while {doing}"
        raise contract_error(entry, what, returns.__name__)
    return found
