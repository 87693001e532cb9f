"""Options of plugins: their allowed values in words, and values from a command line."""

import re
import types
from collections.abc import Iterator, Mapping
from contextlib import suppress
from enum import Enum
from pathlib import Path
from typing import Annotated, Any, Literal, TypeVar, Union, get_args, get_origin

from pydantic import BaseModel, BeforeValidator, ValidationError
from pydantic.fields import FieldInfo
from pydantic_core import to_jsonable_python

from gaitsim.contracts.product import RESERVED, TWO, Input
from gaitsim.errors import GaitsimError, nearest
from gaitsim.registry.entry_points import PRODUCTS, REFLEX
from gaitsim.toml import brief, is_long, literal, parse, text as toml_text

T = TypeVar("T", bound=BaseModel)
NOT_SET = "none"
"""The value that unsets an option, as TOML has no null."""

_TYPES = {
    int: "a whole number",
    float: "a number",
    str: "a string",
    bool: "true or false",
    Path: "a path",
    Any: "anything",
}
_BOUNDS = {
    "gt": "> {}",
    "ge": "≥ {}",
    "lt": "< {}",
    "le": "≤ {}",
    "multiple_of": "divisible by {}",
    "min_length": "of at least {} long",
    "max_length": "of at most {} long",
}


def declared(field: FieldInfo, name: str) -> str:
    """Return an argument of the declaration of an option, such as its unit; '' for none."""
    extra = field.json_schema_extra
    return str(extra.get(name, "")) if isinstance(extra, dict) else ""


def unit(field: FieldInfo) -> str:
    """Return the unit of an option; '' for none."""
    return declared(field, "unit")


def type_and_bounds(field: FieldInfo) -> str:
    """Return the type and bounds of an option, such as 'a number ≥ 0.2 and ≤ 5'."""
    return declared(field, "allowed") or _bounded(_type(field.annotation), field.metadata)


def allowed(field: FieldInfo) -> str:
    """Return the type, bounds and unit of an option, such as 'a number ≥ 0.2 and ≤ 5, in Hz'."""
    unit = declared(field, "unit")
    return type_and_bounds(field) + (f", in {unit}" if unit else "")


def meaning(field: FieldInfo) -> str:
    """Return the description of an option on one line; '' if it has none."""
    default = declared(field, "unset")
    return " ".join((field.description or "").split()) + (f"; none: {default}" if default else "")


def default(field: FieldInfo) -> str:
    """Return the default as TOML writes it; 'required' if there is none."""
    if field.is_required():
        return "required"
    value = field.get_default(call_default_factory=True)
    return literal(to_jsonable_python(value, serialize_unknown=True))


def _bounded(kind: str, metadata: list[Any]) -> str:
    """Return a type with its bounds, such as 'a string of at least 1 character'."""
    what = "character" if kind.startswith("a string") else "value"
    bounds = " and ".join(
        form.format(_number(getattr(item, name)))
        for name, form in _BOUNDS.items()
        for item in metadata
        if getattr(item, name, None) is not None
    )
    bounds = re.sub(r"\b(\S+) long", lambda m: f"{m[1]} {what}{'s' * (m[1] != '1')}", bounds)
    return f"{kind} {bounds}".strip()


def _number(value: Any) -> str:
    """Return 1000000 as '1,000,000', 0.2 as '0.2', 5.0 as '5'."""
    if isinstance(value, float) and value.is_integer() and abs(value) < 1e15:
        value = int(value)
    return f"{value:,}" if isinstance(value, int | float) else str(value)


def _type(annotation: Any) -> str:
    origin, members = get_origin(annotation), get_args(annotation)
    if origin is Annotated and members[0] == tuple[str, ...]:
        return "one or more, separated by commas"
    if origin is Annotated:
        bounds = [
            bound
            for item in members[1:]
            for bound in (item.metadata if isinstance(item, FieldInfo) else [item])
        ]
        return _bounded(_type(members[0]), bounds)
    if choices := _choices(annotation):
        return " or ".join(map(literal, choices))
    if origin in (Union, types.UnionType):
        return " or ".join(_type(member) for member in members if member is not type(None))
    if origin is dict:
        return f"a table of names, each with {_type(members[1])}" if members else "a table"
    if origin in (tuple, list):
        if not members:
            return "a list"
        if origin is list or members[-1] is Ellipsis:
            return f"a list of values, each {_type(members[0])}"
        return f"a list of {len(members)} values: {', '.join(map(_type, members))}"
    if isinstance(annotation, type) and issubclass(annotation, BaseModel):
        return f"a table with the keys {', '.join(annotation.model_fields)}"
    return _TYPES.get(annotation, getattr(annotation, "__name__", str(annotation)))


def _choices(annotation: Any) -> list[Any]:
    """Return the values of a Literal or an Enum; [] for other types."""
    if get_origin(annotation) is Literal:
        return [*get_args(annotation)]
    enum = isinstance(annotation, type) and issubclass(annotation, Enum)
    return [member.value for member in annotation] if enum else []


def members(field: FieldInfo) -> list[Any]:
    """Return the type of an option, or the types of a union."""
    annotation = field.annotation
    union = get_origin(annotation) in (Union, types.UnionType)
    return list(get_args(annotation)) if union else [annotation]


def string_choices(field: FieldInfo) -> list[str]:
    """Return the strings among the choices of an option."""
    found = [choice for one in members(field) for choice in _choices(one)]
    return [choice for choice in found if isinstance(choice, str)]


def choices(field: FieldInfo) -> list[str]:
    """Return the choices of an option as `--set` reads them; [] if it also takes other values."""
    if field.annotation is bool:
        return ["true", "false"]
    found = [_choices(one) for one in members(field) if one is not type(None)]
    listed = [format_value(field, choice) for choices in found for choice in choices]
    return [*listed, *([NOT_SET] * optional(field))] if all(found) else []


def optional(field: FieldInfo) -> bool:
    """Return whether an option may be unset."""
    return type(None) in members(field)


def format_value(field: FieldInfo, value: Any) -> str:
    """Return the text that `--set` reads as a value of an option."""
    if value is None or (value == NOT_SET and optional(field)):
        return NOT_SET
    if isinstance(value, str) and value == value.strip():
        read = convert_value(field, parse_value(value), value)
        return value if read == value else toml_text(value)
    return toml_text(value)


def format_brief(field: FieldInfo, value: Any) -> str:
    """Return a value for display: as `--set` reads it, or shortened if it is long."""
    return brief(value) if is_long(value) else format_value(field, value)


def values(model: BaseModel) -> dict[str, Any]:
    """Return the options of a model in types that TOML supports, without unset ones."""
    return model.model_dump(mode="json", exclude_none=True)


def parse_value(text: str) -> Any:
    """Return the value of a TOML expression; a text that is not TOML is returned unchanged."""
    try:
        table = parse(f"value = {text}", "")
    except GaitsimError:
        return text
    return table["value"] if list(table) == ["value"] else text


def convert_value(field: FieldInfo, value: Any, typed: str | None) -> Any:
    """Convert a value from a file or a command line to a value of an option.

    'none' becomes None if the option may be unset. A value on a command line becomes a string if
    the option takes strings: `--set label=12` needs no quotes.

    Args:
        field: field of the option.
        value: value as TOML reads it.
        typed: text on the command line; None for a value from a file.
    """
    types = members(field)
    if isinstance(value, str):
        if value.lower() == NOT_SET and type(None) in types:
            return None
        if typed is not None and float in types and str not in types:
            with suppress(ValueError):
                return float(value)  # Python reads '.5' as a number, TOML does not
    elif typed is not None and (typed in string_choices(field) or types == [str]):
        return typed
    return value


OPERATORS = ("selection", "crossover", "mutation")
"""The kinds of plugin that a search uses only if it declares them."""

PLUGIN = "plugin"
"""The key that names the plugin in a section of an experiment; no option can have that name."""


def problems(kind: str, plugin: type[BaseModel]) -> list[str]:
    """Return the errors in a plugin class, one sentence each."""
    found = []
    if kind == "organism":
        from gaitsim.contracts import Channel

        channels = getattr(plugin, "channels", None)
        if not (
            isinstance(channels, Mapping)
            and _are_strings(channels.keys())
            and all(isinstance(channel, Channel) for channel in channels.values())
        ):
            found.append("channels must be a dict that maps the name of each channel to a Channel")
        elif (angles := channels.get("joint_angles")) and (
            angles.axes != ("frames", "joints") or angles.unit != "rad"
        ):
            found.append("joint_angles must be Channel(('frames', 'joints'), 'rad', …)")
    if kind in ("fitness", REFLEX):
        found += _needs_problems(kind, plugin)
    if kind in ("search", "crossover", "mutation"):
        spaces = getattr(plugin, "spaces", None)
        if not (isinstance(spaces, tuple) and spaces and all(map(_is_space, spaces))):
            found.append("spaces must be a tuple of classes such as RealSpace and BitSpace")
    if kind == "search":
        operators: Any = getattr(plugin, "operators", None)
        if not (isinstance(operators, tuple) and {*operators} <= {*OPERATORS}):
            found.append(f"operators must be a tuple of names among {', '.join(OPERATORS)}")
    # A crossover declares `children` as an option or as a class attribute.
    if kind == "crossover" and "children" not in plugin.model_fields:
        children = getattr(plugin, "children", None)
        if not isinstance(children, int) or children not in (1, 2):
            found.append("children must be 1 or 2")
    if kind in PRODUCTS:
        found += _product_problems(kind, plugin)
    if PLUGIN in plugin.model_fields:
        found.append(f"an option cannot be named {PLUGIN!r}: this key names the plugin in a file")
    return found


def _needs_problems(kind: str, plugin: type[BaseModel]) -> Iterator[str]:
    from gaitsim.contracts import OBSERVATIONS

    needs: Any = getattr(plugin, "needs", None)
    if kind == "fitness" and not _are_strings(needs):
        yield "needs must be a tuple of channel names"
    if kind == REFLEX and not (isinstance(needs, tuple) and {*needs} <= {*OBSERVATIONS}):
        yield f"needs must be a tuple of names among {', '.join(OBSERVATIONS)}"


def _product_problems(kind: str, plugin: type[BaseModel]) -> Iterator[str]:
    texts = ("title", "group", "note", "items", *(("suffix", "stem") if kind == "exporter" else ()))
    for name in texts:
        if not isinstance(getattr(plugin, name, None), str):
            yield f"{name} must be a string"
    if getattr(plugin, "input", None) not in (known := get_args(Input)):
        yield f"input must be {' or '.join(map(repr, known))}"
    reserved = {f"--{name}" for name in RESERVED}
    for name, field in plugin.model_fields.items():
        word = flag(name, field)
        if name in RESERVED or word in reserved:
            taken = name if name in RESERVED else word
            yield f"an option cannot be named {taken!r}: the command has that option"
        elif not word.startswith("--"):
            yield f"the flag {word!r} must begin with '--'"


def _are_strings(names: Any) -> bool:
    if isinstance(names, str) or names is None:
        return False
    try:
        return all(isinstance(name, str) for name in names)
    except TypeError:
        return False


def _is_space(thing: object) -> bool:
    from gaitsim.contracts import GenomeSpace

    return isinstance(thing, type) and issubclass(thing, GenomeSpace)


def flag(name: str, field: FieldInfo) -> str:
    """Return the flag of an option, such as '--keyframe-ms'."""
    return declared(field, "flag") or f"--{name.replace('_', '-')}"


def value_type(field: FieldInfo) -> Any:
    """Return the type of an option on the command line.

    It is `list[str]` for a flag that may be repeated, `tuple[str, str]` for one with two values,
    and `str` for values that a validator of the option parses.
    """
    found = [one for one in members(field) if one is not type(None)]
    annotation, *more = get_args(found[0]) if get_origin(found[0]) is Annotated else found
    more += [one for one in field.metadata if isinstance(one, BeforeValidator)]
    if not more:
        return annotation
    if annotation != tuple[str, ...]:
        return str
    return tuple[str, str] if TWO in more else list[str]


def read_options(
    model: type[T], given: Mapping[str, Any], table: str = ""
) -> tuple[T | None, dict[str, GaitsimError]]:
    """Validate options; return them, or None and the errors by the name of the option.

    Args:
        model: class with the options.
        given: options, all of which the class has.
        table: key of the table of a file that contains them, which is validated strictly: '12' is
            not a number. '' for options of a command or a function, which messages call by flags.
    """
    try:
        return model.model_validate(given, strict=bool(table)), {}
    except ValidationError as error:
        wrong = {str(detail["loc"][0]): detail["input"] for detail in error.errors()}
    except GaitsimError as error:
        names = {flag(name, field): name for name, field in model.model_fields.items()}
        return None, {names.get(error.where, ""): error}
    found = {}
    for name in wrong:
        field = model.model_fields[name]
        known, value = string_choices(field), given.get(name, "")
        label = f"{table}.{name}" if table else flag(name, field)
        found[name] = GaitsimError(
            f"invalid {label}: {value!r:.200}",
            where=label,
            allowed=", ".join(known) or allowed(field),
            remedy=nearest(str(value), known),
            key=label if table else "",
        )
    return None, found


def validated(model: type[T], given: Mapping[str, Any], table: str = "") -> T:
    """Return validated options, from the arguments of `read_options`.

    Raises:
        GaitsimError: an option is invalid.
    """
    found, problems = read_options(model, given, table)
    if found is None:
        raise next(iter(problems.values()))
    return found
