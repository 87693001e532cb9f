"""What a plugin's options allow, in words, and values from the command line."""

import tomllib
from typing import Any, Literal, Union, get_args, get_origin

from pydantic import BaseModel
from pydantic.fields import FieldInfo

_TYPES = {int: "a whole number", float: "a number", str: "a text", bool: "true or false"}
_BOUNDS = {"gt": ">", "ge": "≥", "lt": "<", "le": "≤"}


def unit(field: FieldInfo) -> str:
    """The unit of an option, or ''."""
    extra = field.json_schema_extra
    return str(extra.get("unit", "")) if isinstance(extra, dict) else ""


def allowed(field: FieldInfo) -> str:
    """What an option takes, such as 'a number ≥ 0.2 and ≤ 5, in Hz'."""
    bounds = " and ".join(
        f"{sign} {getattr(item, name):g}"
        for name, sign in _BOUNDS.items()
        for item in field.metadata
        if getattr(item, name, None) is not None
    )
    text = f"{_type(field.annotation)} {bounds}".strip()
    return f"{text}, in {unit(field)}" if unit(field) else text


def _type(annotation: Any) -> str:
    if get_origin(annotation) is Literal:
        return " or ".join(
            f'"{value}"' if isinstance(value, str) else str(value) for value in get_args(annotation)
        )
    members = [member for member in get_args(annotation) if member is not type(None)]
    if get_origin(annotation) is Union or type(annotation).__name__ == "UnionType":
        return " or ".join(_type(member) for member in members)
    if get_origin(annotation) in (tuple, list):
        return f"a list of values, each {_type(members[0])}" if members else "a list"
    return _TYPES.get(annotation, getattr(annotation, "__name__", str(annotation)))


def values(model: BaseModel) -> dict[str, Any]:
    """The options of a model as TOML can hold them, without those that are not set."""
    return model.model_dump(mode="json", exclude_none=True)


def parse_assignment(text: str) -> tuple[str, Any]:
    """KEY=VALUE, the value as TOML writes it; a text needs no quotes; 'none' is None.

    Raises:
        ValueError: there is no '=' or no key.
    """
    key, equals, value = text.partition("=")
    key, value = key.strip(), value.strip()
    if not (key and equals):
        raise ValueError(f"{text!r} is not KEY=VALUE")
    if value.lower() == "none":
        return key, None
    try:
        table = tomllib.loads(f"value = {value}")
    except tomllib.TOMLDecodeError:
        return key, value
    return key, table["value"] if list(table) == ["value"] else value
