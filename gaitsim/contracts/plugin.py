"""The base of all plugins: a frozen model whose fields are its options."""

from pathlib import Path
from typing import Any, Self

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
) -> Any:
    """Declare one option of a plugin: its default, meaning, unit and bounds.

    The one declaration feeds the check of experiment files, `--set`, the forms
    and the documentation.

    Args:
        default: value where none is given.
        help: what the option does, one sentence.
        unit: its SI unit, `''` for a pure number.
        ge: smallest value allowed; `gt` excludes the bound itself.
        gt: bound that the value must exceed.
        le: largest value allowed; `lt` excludes the bound itself.
        lt: bound that the value must stay below.
    """
    return Field(
        default,
        description=help,
        json_schema_extra={"unit": unit},
        ge=ge,
        gt=gt,
        le=le,
        lt=lt,
    )


def folder_of(info: ValidationInfo) -> Path | None:
    """Return the folder where a relative path in an option starts; None where none may be read.

    For the validator of an option that takes the path of a file and keeps the file's content. It
    is the folder of an experiment file; for values from the command line or from Python, the
    current folder. The experiment of a run, a checkpoint or a champion contains what was read:
    a path in it is invalid, as opening a run reads no other files.
    """
    if info.context is None:
        return Path()
    found: Path | None = info.context.get(info.field_name)
    return found


class Plugin(BaseModel):
    """Base of all kinds of plugin.

    Subclasses are frozen pydantic models: the fields are the options, declared
    with `option`. Two plugins of one class with equal options are equal.
    """

    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False)

    def at(self, generation: int) -> Self:
        """Return the plugin with its options at `generation`, from 1.

        Override it for schedules, such as a mutation strength that decays. By default, options
        stay the same.
        """
        return self
