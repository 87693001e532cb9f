"""The base of all plugins: a frozen model whose fields are its options."""

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


def folder_of(info: ValidationInfo) -> Path | None:
    """Return the folder to which paths in an option are relative; None if no file may be read.

    Call it in the validator of an option that takes the path of a file and stores the file's
    content. In an experiment file, paths are relative to the folder of the file; on the command
    line and in Python, to the current folder. The experiment of a run, a checkpoint or a champion
    already contains the content of the file. A path in it is invalid, because opening a run must
    not read other files.
    """
    if info.context is None:
        return Path()
    found: Path | None = info.context.get(info.field_name)
    return found


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
