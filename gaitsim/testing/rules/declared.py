"""Rules for the declarations of every plugin: its docstring and its options."""

import json
from collections.abc import Iterator
from typing import Any

import numpy as np
from pydantic import ValidationError
from pydantic.fields import FieldInfo

from gaitsim import toml
from gaitsim.contracts import Plugin, Results
from gaitsim.evaluation import evaluate
from gaitsim.evolution.searching import ask, initial_state, tell
from gaitsim.experiment import Experiment, load_experiment, parse_experiment
from gaitsim.registry import Entry, options
from gaitsim.testing.report import Finding, advice, error
from gaitsim.testing.rules.trials import PLACEHOLDERS

_BOUNDS = ("gt", "ge", "lt", "le")


def check_declarations(model: type[Plugin]) -> Iterator[Finding]:
    """Check the docstring and the options of a class."""
    if not (model.__dict__.get("__doc__") or "").strip():
        yield advice(
            "docstring",
            "a sentence about the plugin, which 'gaitsim plugins show' prints",
            f"{model.__name__} has no docstring",
            "add a docstring below the class statement",
        )
    if not model.model_config.get("frozen"):
        yield error(
            "options",
            "a frozen model, like its base class",
            f"instances of {model.__name__} can be changed",
            "remove 'frozen' from its model_config",
        )
    for name, field in model.model_fields.items():
        yield from _check_option(name, field)


def _check_option(name: str, field: FieldInfo) -> Iterator[Finding]:
    if field.is_required() and name not in PLACEHOLDERS:
        yield error(
            "options",
            "a default for every option, so that the plugin works without options",
            f"{name} has none",
            f"{name}: … = option(DEFAULT, …)",
        )
    if not options.meaning(field):
        yield error(
            "options",
            "a description of every option",
            f"{name} has none",
            f"{name}: … = option({options.default(field)}, 'description')",
        )
    bounded = any(
        getattr(item, bound, None) is not None for item in field.metadata for bound in _BOUNDS
    )
    if field.annotation in (int, float) and not bounded:
        yield advice(
            "options",
            "bounds for every number, so that invalid values are reported early",
            f"{name} accepts any number",
            f"{name}: … = option({options.default(field)}, …, ge=…, le=…)",
        )


def check_round_trip(kind: str, plugin: Plugin) -> Iterator[Finding]:
    """Check that options can be written to a file and read back, and are within their bounds."""
    import tomlkit

    expected = "the same options after writing and reading a file"
    fix = "use option types that TOML supports: numbers, strings, booleans and lists of them"
    try:
        text = tomlkit.dumps({kind: options.values(plugin)})
    except Exception as problem:  # the serialiser of a custom type may raise anything
        yield error("options", expected, f"cannot be written: {problem}", fix)
        return
    try:
        back = build_plugin(type(plugin), toml.parse(text, "")[kind])
    except ValidationError as problem:
        first = problem.errors()[0]
        option = ".".join(map(str, first["loc"]))
        yield error(
            "options",
            "a default within the bounds of the option",
            f"{option} = {first['input']!r}: {first['msg']}",
            f"change the default of {option}, or its bounds",
        )
        return
    if back != plugin:
        yield error("options", expected, f"{plugin!r} was read as {back!r}", fix)


def build_plugin(model: type[Plugin], values: dict[str, Any]) -> Plugin:
    """Return a plugin with options, validated as in an experiment file."""
    return model.model_validate_json(json.dumps(values), strict=True)


FEW = 3  # first individuals that move, and one that was bred; whole populations are drawn and bred


def preset_rules(entry: Entry, results: dict[str, Any]) -> Iterator[Finding]:
    """Check all rules for a preset; add its first two generations to `results`."""
    experiment = load_experiment(entry.name)
    if parse_experiment(experiment.to_toml(), "again") != experiment:
        yield error(
            "options",
            "the same experiment after writing and reading a file",
            "a different experiment",
            "use option types that TOML supports in its plugins",
        )
    if not experiment.description:
        yield advice(
            "description",
            "a description on one line, for 'gaitsim experiments list'",
            "none",
            f'description = "…" in {entry.name}.toml',
        )
    if experiment.name != entry.name:
        yield advice(
            "name",
            f"name = {entry.name!r}, so that runs have the name of the preset",
            f"name = {experiment.name!r}",
            f"correct it in {entry.name}.toml",
        )
    results |= two_generations(experiment)
    if not np.isfinite(results["scores"]).any():
        yield advice(
            "finite values",
            f"a finite score for some of {FEW} random individuals",
            "no finite score",
            "change the options of the body, or the fitness",
        )


def two_generations(experiment: Experiment) -> dict[str, Any]:
    """Return scores from the first generation, the second population, and some of its scores."""
    space = experiment.space()
    first, state = ask(experiment, space, initial_state(experiment, space), None, 1)
    evaluation = evaluate(experiment, first[:FEW])
    # Artificial scores for the search, because evaluating the whole population could be slow.
    scores = np.sin(np.arange(len(first), dtype=np.float64))
    values = {name: np.resize(some, len(first)) for name, some in evaluation.values.items()}
    results = Results(first, scores, values)
    second, _ = ask(experiment, space, tell(experiment, space, state, results, 1), results, 2)
    return {
        "scores": evaluation.scores,
        "terms": evaluation.terms,
        "second": second,
        "second scores": evaluate(experiment, second[-1:]).scores,
    }
