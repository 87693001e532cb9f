"""The base of all plugins: a frozen model whose fields are its options."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, ClassVar, Self

from pydantic import BaseModel, ConfigDict, Field, ValidationInfo


def option(
    default: Any,
    help: str,
    *,
    unit: str = "",
    ge: float | None = None,
    gt: float | None = None,
    le: float | None = None,
    lt: float | None = None,
    unset: str = "",
    allowed: str = "",
    placeholder: str = "",
    flag: str = "",
    completion: str = "",
    written: bool = False,
    panel: str = "",
) -> Any:
    """Declare one option of a plugin or an action: its default, description, unit and bounds.

    The declaration is used to validate experiment files and the command line, to build flags and
    forms, and to document the option.

    Args:
        default: value if the option is not set.
        help: description of the option, a phrase without a full stop.
        unit: SI unit of the option; `''` for a pure number.
        ge: smallest value allowed.
        gt: bound that the value must exceed.
        le: largest value allowed.
        lt: bound that the value must stay below.
        unset: description of the default, if the default is None.
        allowed: description of the allowed values, if the type and the bounds do not suffice.
        placeholder: placeholder of the value in the help of commands, such as 'START:END'.
        flag: flag of the option on the command line; `''` for `--name`.
        completion: name of the function in `gaitsim.cli.completion` that completes the value.
        written: whether the option names a file to write; forms put it in the run's exports folder.
        panel: heading of the option in the help of its command; `''` for that of most options.
    """
    more = {
        "unset": unset,
        "allowed": allowed,
        "placeholder": placeholder,
        "flag": flag,
        "completion": completion,
        "written": "yes" if written else "",
        "panel": panel,
    }
    return Field(
        default,
        description=help,
        json_schema_extra={"unit": unit, **{name: text for name, text in more.items() if text}},
        ge=ge,
        gt=gt,
        le=le,
        lt=lt,
    )


@dataclass(frozen=True)
class ReadableFiles:
    """The files that options may refer to; Pydantic's context of validation.

    Attributes:
        folders: folder of relative paths, by option; None forbids files.
        roots: additional folders that a file may refer to.
    """

    folders: Mapping[str, Path | None] = field(default_factory=dict)
    roots: tuple[Path, ...] = ()


def folder_of(info: ValidationInfo, name: str = "") -> Path | None:
    """Return the folder to which paths in an option are relative; None if no file may be read.

    Call it in the validator of an option that takes the path of a file and stores the file's
    content. In an experiment file, paths are relative to the folder of the file; on the command
    line and in Python, to the current folder. The experiment of a run, a checkpoint or a champion
    already contains the content of the file. A path in it is invalid, because opening a run must
    not read other files.

    Args:
        info: Pydantic's information about the validation.
        name: name of the option; a validator of the whole model must give it.
    """
    if info.context is None:
        return Path()
    context: ReadableFiles = info.context
    return context.folders.get(name or str(info.field_name))


def roots_of(info: ValidationInfo) -> tuple[Path, ...]:
    """Return additional folders that a file in an option may refer to, such as other packages."""
    return () if info.context is None else info.context.roots


class Plugin(BaseModel):
    """Base class of every kind of plugin.

    Subclasses are frozen pydantic models. Their fields are the options, each declared with
    `option`. Two plugins of the same class with equal options are equal.

    Attributes:
        portable: whether its results have the same bits on every 64-bit processor. Declare this of
            a plugin that computes only with `gaitsim.portable` and the operations that it lists.
            A subclass does not inherit the declaration.
    """

    portable: ClassVar[bool] = False

    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False)

    def at(self, generation: int) -> Self:
        """Return the plugin with its options in a generation, counted from 1.

        Override it for schedules, such as a mutation strength that decays. By default, the
        options are constant.
        """
        return self
