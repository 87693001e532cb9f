"""Commands generated from the models of actions."""

import inspect
from collections.abc import Callable, Iterator
from typing import Annotated, Any

import typer
from pydantic.fields import FieldInfo

from gaitsim.actions.action import Action
from gaitsim.cli import completion
from gaitsim.registry.options import declared, flag, unit, validated, value_type


def command(action: type[Action]) -> Callable[..., None]:
    """Return the function of a command, whose signature Typer turns into options.

    An action with `plugins` also has the options of all plugins of that kind, which it receives as
    `options`, and the options that choose individuals.
    """
    parameters = {name: _parameter(name, field) for name, field in action.model_fields.items()}
    extra: set[str] = set()
    if kind := action.plugins:
        from gaitsim.actions.products import SWITCHES, describe

        found = {one.name: one for one in _plugin_parameters(kind)}
        del parameters["options"]
        switch = SWITCHES[kind].removeprefix("--")
        parameters[switch] = _parameter(switch, action.model_fields[switch], names=describe(kind))
        extra = {*found}
        parameters |= found

    def run(**given: Any) -> None:
        values = {name: value for name, value in given.items() if value is not None}
        if kind:
            options = {name: values.pop(name) for name in [*values] if name in extra}
            values["options"] = options
        validated(action, values).do()

    run.__name__ = action.__name__
    run.__doc__ = inspect.getdoc(action)
    run.__annotations__ = {name: one.annotation for name, one in parameters.items()}
    run.__signature__ = inspect.Signature([*parameters.values()])  # type: ignore[attr-defined]
    return run


def _plugin_parameters(kind: str) -> Iterator[inspect.Parameter]:
    """Yield the options that choose individuals, and those of all plugins of a kind."""
    from gaitsim.actions.products import SWITCHES, all_fields, individual_fields

    for name, field, owners in (*individual_fields(kind), *all_fields(kind)):
        prefix = f"For {SWITCHES[kind]} {', '.join(owners)}: " if owners else ""
        yield _parameter(name, field, prefix, of_plugin=True)


def _parameter(
    name: str, field: FieldInfo, prefix: str = "", names: str = "", *, of_plugin: bool = False
) -> inspect.Parameter:
    """Return the parameter of an option; those of plugins are None unless they are given."""
    required = inspect.Parameter.empty
    default = None if of_plugin else required if field.is_required() else field.default
    annotation, info = typed(name, field, prefix)
    if names:
        info.help = info.help.format(names).removesuffix(".")
    if of_plugin and field.default is not None and not isinstance(field.default, bool):
        shown = f"{field.default:g}" if isinstance(field.default, float) else field.default
        info.help += f" Default: {shown}."
    kind = inspect.Parameter.KEYWORD_ONLY
    return inspect.Parameter(name, kind, default=default, annotation=Annotated[annotation, info])


def typed(name: str, field: FieldInfo, prefix: str = "") -> tuple[Any, Any]:
    """Return the type of an option for Typer, and its declaration."""
    annotation = value_type(field)
    bounds = {
        end: getattr(one, end)
        for one in field.metadata
        for end in ("ge", "le")
        if hasattr(one, end)
    }
    phrase = prefix + (field.description or "") + (f", in {unit(field)}" if unit(field) else "")
    repeated = annotation == list[str] and not declared(field, "argument")
    help = sentence(phrase, repeated=repeated)
    if default := declared(field, "unset"):
        help += f" Default: {default}."
    settings: dict[str, Any] = {"help": help, "metavar": declared(field, "placeholder") or None}
    if word := declared(field, "completion"):
        settings["autocompletion"] = getattr(completion, word)
    if panel := declared(field, "panel"):
        settings["rich_help_panel"] = panel
    if declared(field, "argument"):
        optional = not field.is_required() and field.default is None
        return annotation | None if optional else annotation, typer.Argument(**settings)
    words = [flag(name, field)]
    if annotation is bool and field.default:
        words = [f"{words[0]}/--no-{words[0][2:]}"]
    if field.default is None or annotation is bool:
        annotation = annotation | None if annotation is not bool else bool
    return annotation, typer.Option(*words, min=bounds.get("ge"), max=bounds.get("le"), **settings)


def sentence(phrase: str, *, repeated: bool = False) -> str:
    """Return a phrase as a sentence."""
    return phrase[:1].upper() + phrase[1:] + "; may be repeated" * repeated + "."
