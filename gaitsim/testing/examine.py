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

from gaitsim.contracts import Crossover, Fitness, Mutation, Organism, Plugin, Search, Selection
from gaitsim.errors import ContractError, ExperimentError, GaitsimError
from gaitsim.experiment import load_experiment, parse_experiment
from gaitsim.registry import EXPERIMENTS, Entry, load_entry, plugin_errors
from gaitsim.testing.report import Finding, Report, advice, error, reported
from gaitsim.testing.rules.bits import digest
from gaitsim.testing.rules.bodies import body_rules, moved_by, some_genomes
from gaitsim.testing.rules.common import fitting
from gaitsim.testing.rules.declared import declared, rebuilt, round_trip
from gaitsim.testing.rules.fitnesses import fitness_rules
from gaitsim.testing.rules.operators import operator_rules
from gaitsim.testing.rules.partners import partner
from gaitsim.testing.rules.presets import preset_rules, two_generations
from gaitsim.testing.rules.searches import search_rules
from gaitsim.testing.rules.selections import selection_rules
from gaitsim.testing.rules.trials import parts, trial, with_stand_ins

SLOW_IMPORT = 3.0  # seconds, without the libraries that gaitsim itself imports

OnStatus = Callable[[str], None]


def examine(
    entry: Entry, options: Mapping[str, Any], on_status: OnStatus = lambda text: None
) -> Report:
    """Check a plugin against every rule of its kind.

    Args:
        entry: entry of the plugin.
        options: options that differ from the defaults.
        on_status: called with the name of each step before it starts, for the message about a
            timeout.
    """
    findings: list[Finding] = []
    figures: dict[str, float] = {}
    found = ""
    try:
        for finding in _rules(entry, options, figures, on_status):
            findings.append(finding)
        if all(finding.level == "advice" for finding in findings):
            on_status("computing everything a second time")
            with plugin_errors(entry, "computing everything a second time"):
                found = outcome(entry, options)
    except GaitsimError as problem:
        findings.append(_finding(entry, problem))
    return Report(entry, tuple(findings), figures, found)


def _finding(entry: Entry, problem: GaitsimError) -> Finding:
    actual, fix, cause = problem.what, problem.remedy, problem.__cause__
    if isinstance(problem, ExperimentError):
        actual = str(problem)
    elif isinstance(problem, ContractError):  # its remedy is for users, not for plugin authors
        fix = f"see gaitsim.contracts.{entry.kind.capitalize()}"
    place = _place(entry, cause) if cause is not None else ""
    if place:
        actual, fix = f"{actual} ({place})", "correct the code at this line"
    elif isinstance(cause, ModuleNotFoundError):
        fix = f"add the module, or correct the entry point {entry.target!r}"
    return error("failure", problem.allowed or "no exception", actual, fix)


def _place(entry: Entry, cause: BaseException) -> str:
    """Return the file and line of the plugin's package that raised an exception; '' if unknown."""
    package = entry.target.partition(":")[0].partition(".")[0]
    place = ""
    for frame, line in walk_tb(cause.__traceback__):
        if str(frame.f_globals.get("__name__")).partition(".")[0] == package:
            place = f"{frame.f_code.co_filename}, line {line}"
    return place


def _rules(
    entry: Entry, options: Mapping[str, Any], figures: dict[str, float], on_status: OnStatus
) -> Iterator[Finding]:
    if entry.kind == EXPERIMENTS:
        on_status("reading the preset, moving its first individuals and breeding")
        yield from preset_rules(entry)
        return
    on_status("importing the plugin")
    yield from _imported(entry, figures)
    model = load_entry(entry)
    before = _global_randomness()
    with plugin_errors(entry, "declaring its options"):
        wrong = yield from reported(declared(model))
    on_status("validating its options")
    options = with_stand_ins(model, options)
    with plugin_errors(entry, "validating its options"):
        # Without options, as from Python, which does not validate defaults; otherwise as from a
        # file.
        plugin = rebuilt(model, options) if options else model()
    with plugin_errors(entry, "writing its options"):
        wrong |= yield from reported(round_trip(entry.kind, plugin))
    if wrong:
        return
    yield from _of_kind(entry, plugin, figures, on_status)
    if _global_randomness() != before:
        yield error(
            "randomness",
            "no use of the global random generators, because runs must be reproducible",
            "the plugin draws from 'random' or 'numpy.random'",
            "draw from the argument 'rng', or from np.random.default_rng(seed)",
        )


def _imported(entry: Entry, figures: dict[str, float]) -> Iterator[Finding]:
    begun = time.perf_counter()
    with plugin_errors(entry, "being imported"):
        module = entry.target.partition(":")[0]
        new = module not in sys.modules
        import_module(module)
    if new:
        figures["import_seconds"] = time.perf_counter() - begun
        if figures["import_seconds"] > SLOW_IMPORT:
            yield advice(
                "import time",
                f"at most {SLOW_IMPORT:g} s",
                f"{figures['import_seconds']:.1f} s",
                "import heavy libraries inside functions, and compute nothing at import",
            )


def _of_kind(
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
        case _:
            assert isinstance(plugin, Mutation)
            doing, rules = "mutating children", operator_rules(plugin, figures)
    on_status(doing)
    with plugin_errors(entry, doing):
        yield from rules


def _global_randomness() -> str:
    """Return a digest of the state of the global generators."""
    state = np.random.get_state(legacy=False)  # noqa: NPY002 - to detect its use
    return digest([repr(random.getstate()), repr(state)])


def outcome(entry: Entry, options: Mapping[str, Any]) -> str:
    """Return a digest of the results of a plugin, for comparison with another process.

    Raises:
        GaitsimError: the plugin fails, or its options are invalid.
    """
    if entry.kind == EXPERIMENTS:
        experiment = load_experiment(entry.name)
        return digest(two_generations(parse_experiment(experiment.to_toml(), entry.name)))
    try:
        model = load_entry(entry)
        plugin = rebuilt(model, with_stand_ins(model, options))
    except ValidationError as problem:
        raise GaitsimError(str(problem)) from None
    return digest(_computed(entry, plugin))


def _computed(entry: Entry, plugin: Plugin) -> object:
    rng = np.random.default_rng(11)
    if isinstance(plugin, Organism):
        motion = moved_by(entry, plugin)
        return [motion, plugin.skeleton(motion, 0)]
    if isinstance(plugin, Fitness):
        found = partner(entry, plugin)
        return plugin.terms(moved_by(*found)) if found else []
    if isinstance(plugin, Search):
        trials = filter(None, (trial(plugin, space) for _, space in fitting(plugin)))
        return [[state, parts(last)] for each in trials for state, last in each.run(3)]
    if isinstance(plugin, Selection):
        return plugin.parents(np.sin(np.arange(30.0)), 20, rng)
    assert isinstance(plugin, Crossover | Mutation)
    made = []
    for _, space in fitting(plugin):
        genomes = some_genomes(space, 8)
        if isinstance(plugin, Crossover):
            made.append(plugin.cross(genomes, genomes[::-1].copy(), space, rng))
        else:
            made.append(plugin.mutate(genomes, space, rng))
    return made
