"""Checks of the declarations of a plugin: its docstring and its options.

What fails here is not checked further.
"""

from pydantic import ValidationError
from pydantic.fields import FieldInfo

from gaitsim.plugin import PLUGINS, Entry, Plugin, options as plugin_options, toml
from gaitsim_testing.finding import advise, require
from gaitsim_testing.trials import PLACEHOLDERS, build_plugin

KINDS = PLUGINS
_BOUNDS = ("gt", "ge", "lt", "le")


def test_declarations(model: type[Plugin]) -> None:
    """The class has a docstring, is frozen, and describes its options."""
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


def test_options(entry: Entry, plugin: Plugin) -> None:
    """Options are within their bounds, and the same after writing and reading a file."""
    import tomlkit

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
