"""Checks of the declarations of every plugin: its name, its docstring and its options."""

import os
from collections.abc import Iterator
from multiprocessing import get_context
from multiprocessing.pool import Pool
from typing import Any

import pytest
from pydantic import ValidationError
from pydantic.fields import FieldInfo

from gaitsim import toml
from gaitsim.contracts import Plugin
from gaitsim.registry import PLUGINS, PRODUCTS, Entry, options as plugin_options
from gaitsim.testing.finding import advise, require
from gaitsim.testing.packages import CHECKED, other_claims
from gaitsim.testing.results import digest_results
from gaitsim.testing.trials import PLACEHOLDERS, build_plugin

KINDS = CHECKED
_BOUNDS = ("gt", "ge", "lt", "le")


def test_name(entry: Entry) -> None:
    """No other package registers the name."""
    others = other_claims(entry)
    require(
        not others,
        f"also registered by {' and '.join(others)}",
        f"a unique name: if several packages register {entry.name!r}, none can be used",
        "choose a different name in the entry points",
    )


def test_declarations(request: pytest.FixtureRequest, entry: Entry) -> None:
    """The class has a docstring, is frozen, and describes its options."""
    if entry.kind not in PLUGINS:
        return
    model: type[Plugin] = request.getfixturevalue("model")
    advise(
        (model.__dict__.get("__doc__") or "").strip(),
        f"{model.__name__} has no docstring",
        "a sentence about the plugin, which 'gaitsim plugins show' prints",
        "add a docstring below the class statement",
    )
    require(
        model.model_config.get("frozen"),
        f"instances of {model.__name__} can be changed",
        "a frozen model, like its base class",
        "remove 'frozen' from its model_config",
    )
    for name, field in model.model_fields.items():
        _check_option(name, field)


def _check_option(name: str, field: FieldInfo) -> None:
    default = plugin_options.default(field)
    require(
        not field.is_required() or name in PLACEHOLDERS,
        f"the option {name} has no default",
        "a default for every option, so that the plugin works without options",
        f"{name}: … = option(DEFAULT, …)",
    )
    require(
        plugin_options.meaning(field),
        f"the option {name} has no description",
        "a description of every option",
        f"{name}: … = option({default}, 'description')",
    )
    bounded = any(
        getattr(item, bound, None) is not None for item in field.metadata for bound in _BOUNDS
    )
    advise(
        bounded or field.annotation not in (int, float),
        f"the option {name} accepts any number",
        "bounds for every number, so that invalid values are reported early",
        f"{name}: … = option({default}, …, ge=…, le=…)",
    )


def test_options(request: pytest.FixtureRequest, entry: Entry) -> None:
    """Options are within their bounds, and the same after writing and reading a file."""
    import tomlkit

    if entry.kind not in PLUGINS:
        return
    plugin: Plugin = request.getfixturevalue("plugin")
    expected = "the same options after writing and reading a file"
    fix = "use option types that TOML supports: numbers, strings, booleans and lists of them"
    reason = ""
    try:
        text = tomlkit.dumps({entry.kind: plugin_options.values(plugin)})
    except Exception as problem:  # the serialiser of a custom type may raise anything
        reason = str(problem)
    require(not reason, f"the options cannot be written: {reason}", expected, fix)
    wrong = ""
    try:
        back = build_plugin(type(plugin), toml.parse(text, "")[entry.kind])
    except ValidationError as problem:
        first = problem.errors()[0]
        wrong = f"{'.'.join(map(str, first['loc']))} = {first['input']!r}: {first['msg']}"
    require(not wrong, wrong, "defaults within the bounds", "change the default or the bounds")
    require(back == plugin, f"{plugin!r} is read as {back!r}", expected, fix)


@pytest.fixture(scope="session")
def another_process() -> Iterator[Pool]:
    """A process with another order of sets."""
    seed = "2" if os.environ.get("PYTHONHASHSEED") == "1" else "1"
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("PYTHONHASHSEED", seed)
        pool = get_context("spawn").Pool(1)
    yield pool
    pool.terminate()


def test_another_process(
    request: pytest.FixtureRequest, entry: Entry, options: dict[str, Any]
) -> None:
    """Another process computes the same bits."""
    if entry.kind not in PLUGINS or entry.kind in PRODUCTS:  # files of runs contain times
        return
    request.getfixturevalue("plugin")
    pool: Pool = request.getfixturevalue("another_process")
    require(
        pool.apply(digest_results, [entry, options]) == digest_results(entry, options),
        "different bits in another process, such as a worker",
        "the same bits in every process",
        "depend only on options and genomes: not on the order of a set, on id() or hash(), "
        "the environment, or earlier results",
    )
