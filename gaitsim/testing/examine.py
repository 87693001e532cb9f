"""Examine one plugin or preset in this process."""

import random
import sys
import time
from collections.abc import Callable, Iterator, Mapping
from importlib import import_module
from traceback import walk_tb
from typing import Any

import numpy as np
from pydantic import ValidationError

from gaitsim.contracts import (
    Crossover,
    Fitness,
    Mutation,
    Organism,
    Plugin,
    Product,
    Reflex,
    Search,
    Selection,
)
from gaitsim.errors import ContractError, ExperimentError, GaitsimError
from gaitsim.experiment import load_experiment, parse_experiment
from gaitsim.registry import EXPERIMENTS, Entry, load_entry, plugin_errors
from gaitsim.testing.report import Finding, Report, advice, any_error, error
from gaitsim.testing.rules.bodies import body_rules, sample_genomes, sample_motion
from gaitsim.testing.rules.common import digest, supported_spaces
from gaitsim.testing.rules.declared import (
    build_plugin,
    check_declarations,
    check_round_trip,
    preset_rules,
    two_generations,
)
from gaitsim.testing.rules.fitnesses import find_body, fitness_rules
from gaitsim.testing.rules.operators import operator_rules, selection_rules
from gaitsim.testing.rules.products import product_rules
from gaitsim.testing.rules.reflexes import BODIES, Trial, reflex_rules
from gaitsim.testing.rules.searches import search_rules
from gaitsim.testing.rules.trials import make_trial, result_arrays, with_placeholders

SLOW_IMPORT = 3.0  # seconds, without the libraries that gaitsim itself imports

OnStatus = Callable[[str], None]


def examine(
    entry: Entry, options: Mapping[str, Any], on_status: OnStatus = lambda text: None
) -> Report:
    """Check a plugin or preset against all rules of its kind.

    Args:
        entry: entry of the plugin or preset.
        options: options that differ from the defaults.
        on_status: function that is called with the description of each step before it starts, so
            that the message about a timeout can name the step.
    """
    findings: list[Finding] = []
    figures: dict[str, float] = {}
    results: dict[str, Any] = {}
    digest_found = ""
    try:
        for finding in _rules(entry, options, figures, results, on_status):
            findings.append(finding)
        if all(finding.level == "advice" for finding in findings):
            on_status("computing everything a second time")
            with plugin_errors(entry, "computing everything a second time"):
                digest_found = digest(results) if results else digest_results(entry, options)
    except GaitsimError as problem:
        findings.append(_failure(entry, problem))
    return Report(entry, tuple(findings), figures, digest_found)


def _failure(entry: Entry, problem: GaitsimError) -> Finding:
    actual, fix, cause = problem.what, problem.remedy, problem.__cause__
    if isinstance(problem, ExperimentError):
        actual = str(problem)
    elif isinstance(problem, ContractError):  # its remedy is for users, not for plugin authors
        fix = f"see gaitsim.contracts.{entry.kind.capitalize()}"
    place = _location(entry, cause) if cause is not None else ""
    if place:
        actual, fix = f"{actual} ({place})", "correct the code at this line"
    elif isinstance(cause, ModuleNotFoundError):
        fix = f"add the module, or correct the entry point {entry.target!r}"
    return error("failure", problem.allowed or "no exception", actual, fix)


def _location(entry: Entry, cause: BaseException) -> str:
    """Return the file and line of the plugin's package that raised an exception, or ''."""
    package = entry.target.partition(":")[0].partition(".")[0]
    place = ""
    for frame, line in walk_tb(cause.__traceback__):
        if str(frame.f_globals.get("__name__")).partition(".")[0] == package:
            place = f"{frame.f_code.co_filename}, line {line}"
    return place


def _rules(
    entry: Entry,
    options: Mapping[str, Any],
    figures: dict[str, float],
    results: dict[str, Any],
    on_status: OnStatus,
) -> Iterator[Finding]:
    if entry.kind == EXPERIMENTS:
        on_status("reading the preset, moving its first individuals and breeding")
        yield from preset_rules(entry, results)
        return
    on_status("importing the plugin")
    yield from _check_import(entry, figures)
    model = load_entry(entry)
    before = _global_random_state()
    with plugin_errors(entry, "declaring its options"):
        failed = yield from any_error(check_declarations(model))
    on_status("validating its options")
    options = with_placeholders(model, options)
    with plugin_errors(entry, "validating its options"):
        # Options are validated as in a file. Without options, the plugin is created as in Python,
        # which does not validate defaults.
        plugin = build_plugin(model, options) if options else model()
    with plugin_errors(entry, "writing its options"):
        failed |= yield from any_error(check_round_trip(entry.kind, plugin))
    if failed:
        return
    yield from _rules_of_kind(entry, plugin, figures, on_status)
    if _global_random_state() != before:
        yield error(
            "randomness",
            "random numbers only from given generators, because runs must be reproducible",
            "the plugin draws from 'random' or 'numpy.random'",
            "draw from the argument 'rng', or from np.random.default_rng(seed)",
        )


def _check_import(entry: Entry, figures: dict[str, float]) -> Iterator[Finding]:
    start = time.perf_counter()
    with plugin_errors(entry, "being imported"):
        module = entry.target.partition(":")[0]
        new = module not in sys.modules
        import_module(module)
    if new:
        figures["import_seconds"] = time.perf_counter() - start
        if figures["import_seconds"] > SLOW_IMPORT:
            yield advice(
                "import time",
                f"at most {SLOW_IMPORT:g} s",
                f"{figures['import_seconds']:.1f} s",
                "import heavy libraries inside functions, and compute nothing at import",
            )


def _rules_of_kind(
    entry: Entry, plugin: Plugin, figures: dict[str, float], on_status: OnStatus
) -> Iterator[Finding]:
    rules: Iterator[Finding]
    match plugin:
        case Organism():
            doing, rules = "moving populations", body_rules(entry, plugin, figures)
        case Fitness():
            doing, rules = "evaluating a population", fitness_rules(entry, plugin, on_status)
        case Search():
            doing, rules = "calling ask() and tell()", search_rules(plugin, figures)
        case Selection():
            doing, rules = "selecting parents", selection_rules(plugin, figures)
        case Crossover():
            doing, rules = "crossing parents", operator_rules(plugin, figures)
        case Reflex():
            doing, rules = "advancing control steps", reflex_rules(plugin)
        case Product():
            doing, rules = "making the product", product_rules(plugin)
        case _:
            assert isinstance(plugin, Mutation)
            doing, rules = "mutating children", operator_rules(plugin, figures)
    on_status(doing)
    with plugin_errors(entry, doing):
        yield from rules


def _global_random_state() -> str:
    """Return a digest of the state of the global random generators."""
    state = np.random.get_state(legacy=False)  # noqa: NPY002 - to detect its use
    return digest([repr(random.getstate()), repr(state)])


def digest_results(entry: Entry, options: Mapping[str, Any]) -> str:
    """Return a digest of the results of a plugin, for comparison with another process."""
    if entry.kind == EXPERIMENTS:
        experiment = load_experiment(entry.name)
        return digest(two_generations(parse_experiment(experiment.to_toml(), entry.name)))
    try:
        model = load_entry(entry)
        plugin = build_plugin(model, with_placeholders(model, options))
    except ValidationError as problem:
        raise GaitsimError(str(problem)) from None
    return digest(_compute(entry, plugin))


def _compute(entry: Entry, plugin: Plugin) -> object:
    rng = np.random.default_rng(11)
    if isinstance(plugin, Organism):
        motion = sample_motion(entry, plugin)
        return [motion, plugin.skeleton(motion, 0)]
    if isinstance(plugin, Product):
        return []  # its input contains times, which differ between processes
    if isinstance(plugin, Reflex):
        return [Trial(plugin, legs).run() for legs in BODIES.values()]
    if isinstance(plugin, Fitness):
        found = find_body(entry, plugin)
        return plugin.terms(sample_motion(*found)) if found else []
    if isinstance(plugin, Search):
        trials = filter(None, (make_trial(plugin, space) for _, space in supported_spaces(plugin)))
        return [[state, result_arrays(last)] for each in trials for state, last in each.run(3)]
    if isinstance(plugin, Selection):
        return plugin.parents(np.sin(np.arange(30.0)), 20, rng)
    assert isinstance(plugin, Crossover | Mutation)
    children = []
    for _, space in supported_spaces(plugin):
        genomes = sample_genomes(space, 8)
        if isinstance(plugin, Crossover):
            children.append(plugin.cross(genomes, genomes[::-1].copy(), space, rng))
        else:
            children.append(plugin.mutate(genomes, space, rng))
    return children
