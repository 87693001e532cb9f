"""A command line changes any option; invalid changes are errors."""

import tomllib

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st

from gaitsim.errors import ExperimentError
from gaitsim.experiment import (
    load_experiment,
    parse_assignments,
    with_overrides,
)
from gaitsim.registry import KINDS


def test_invalid_assignments_are_reported_at_once():
    wrong = ["", "=", "=1", " = 1", "a", "a.b", "a..b=1", ".a=1", "a.=1"]
    with pytest.raises(ExperimentError) as raised:
        parse_assignments(["seed=1", *wrong])
    assert len(raised.value.problems) == len(wrong)
    assert {problem.where for problem in raised.value.problems} == {"command line"}


@pytest.mark.parametrize(
    ("key", "value", "expected"),
    [
        ("seed", np.int64(7), 7),
        ("mutation.rate", np.float32(0.5), 0.5),
        ("evolution.population", 40, 40),
        ("evolution.fitness_threshold", None, None),
        ("crossover.plugin", "none", "none"),
    ],
)
def test_a_value_keeps_its_type(key, value, expected):
    experiment = load_experiment("spider-genetic", {key: value})
    section, _, name = key.rpartition(".")
    found = getattr(getattr(experiment, section) if section else experiment, name, None)
    if name == "plugin":
        found = experiment.entries[section].name
    assert found == expected
    assert type(found) is type(expected)


@pytest.mark.parametrize(
    ("key", "value"),
    [
        ("mutation.rate", "0.1"),  # only a typed text is read as a number
        ("evolution.population", 2**70),
        ("evolution.population", True),
        ("name", "\udcff"),
        ("mutation.rate", object()),
        ("crossover.plugin", 3),
        ("a key", 1),
        (3, 1),
        ("evolution", {"population": 40}),
    ],
)
def test_a_value_of_another_type_is_refused_with_its_key_and_place(key, value):
    with pytest.raises(ExperimentError) as raised:
        load_experiment("spider-genetic", {key: value}, "the study")
    (problem,) = raised.value.problems
    assert problem.where.startswith("the study")
    assert problem.key in (str(key), "")


def test_every_option_is_reached_from_the_command_line(parsed):
    experiment = load_experiment("spider-genetic")
    data = tomllib.loads(experiment.to_toml())
    sections = {"evolution": experiment.evolution}
    sections.update({kind: experiment.plugin(kind) for kind in KINDS})
    for section, model in sections.items():
        for name in type(model).model_fields:
            value = data[section].get(name, 500)  # those not set take a whole number
            shown = f'"{value}"' if isinstance(value, str) else str(value)
            again = with_overrides(experiment, parse_assignments([f"{section}.{name}={shown}"]))
            found = getattr(again, section)
            assert getattr(found, name) == (tuple(value) if isinstance(value, list) else value)
    assert parsed("seed=7", "name=n", "description=d").seed == 7


def test_another_plugin_drops_the_options_of_the_old_one_but_keeps_what_was_typed(parsed, problem):
    experiment = parsed("fitness.slip_weight=3")
    other = with_overrides(experiment, {"fitness.plugin": "spider-classic"})
    assert other.entries["fitness"].name == "spider-classic"
    assert other.fitness == type(other.fitness)()
    for changes in (
        ["mutation.rate=0.5", "mutation.plugin=reset"],
        ["mutation.plugin=reset", "mutation.rate=0.5"],
    ):
        assert parsed(*changes).mutation.rate == 0.5
    assert parsed("fitness.plugin=spider-walk").fitness == parsed().fitness
    assert "slip_weight" in problem("fitness.plugin=spider-classic", "fitness.slip_weight=1").what


@pytest.mark.parametrize(
    ("change", "where", "what"),
    [
        ("", "", '"" is not KEY=VALUE'),
        ("evolution..population=3", "", "is not KEY=VALUE"),
        ("evolution=3", "key evolution", '"evolution" is a section'),
        ("evol.population=3", "key evol.population", 'unknown section "evol"'),
        ("worlds.ranges={glue=[0, 1]}", "key worlds.ranges.glue", "no condition 'glue'"),
        ("population=3", "key population", 'unknown key "population"'),
        ("evolution.popul=3", "key evolution.popul", 'unknown key "popul"'),
        (
            "evolution.population.x=1",
            "key evolution.population.x",
            '"evolution.population" is an option, not a section',
        ),
        (
            "evolution.population=none",
            "key evolution.population",
            "invalid evolution.population: none (",
        ),
        ("evolution.population=\0", "key evolution.population", "invalid evolution.population: "),
        ("mutation.rate=[bold]", "key mutation.rate", "invalid mutation.rate: [bold] ("),
        ("mutation.rate=nan", "key mutation.rate", "invalid mutation.rate: nan is not finite ("),
        ("organism.encoding=\udcff", "", "is not valid UTF-8"),
        ("organism.plugin=3", "key organism.plugin", "unknown organism plugin '3'"),
        ("search.elites=200", "x.toml, key evolution.population", "200 elites leave no room"),
    ],
)
def test_an_invalid_override_is_refused(problem, change, where, what):
    found = problem(change)
    assert found.where.startswith(
        where if ".toml" in where else "command line" + f", {where}" * bool(where)
    )
    assert what in found.what
    assert len(str(found)) < 600


@pytest.mark.parametrize(
    ("key", "hint"),
    [
        ("population", "'evolution.population'"),
        ("rate", "'mutation.rate'"),
        ("evolution.populatoin", "'population'"),
    ],
)
def test_a_key_is_refused_with_the_nearest(problem, key, hint):
    assert problem(f"{key}=3").remedy == f"did you mean {hint}?"


@given(st.text())
@settings(max_examples=25)
def test_any_change_is_taken_or_refused(parsed, text):
    for change in (text, f"seed={text}", f"mutation.rate={text}", f"{text}=1"):
        try:
            parsed(change)
        except ExperimentError:
            continue
