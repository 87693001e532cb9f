"""Experiments written as TOML are read back unchanged."""

import dataclasses
import tomllib

import pytest
from hypothesis import HealthCheck, given, settings, strategies as st

from gaitsim import registry
from gaitsim.errors import ExperimentError
from gaitsim.experiment import (
    SCHEMA,
    load_experiment,
    parse_assignments,
    parse_experiment,
    with_overrides,
)
from gaitsim.registry import EXPERIMENTS, KINDS


@pytest.mark.parametrize("name", registry.entries(EXPERIMENTS))
def test_each_preset_comes_back_from_its_toml(name):
    experiment = load_experiment(name)
    text = experiment.to_toml()
    again = parse_experiment(text, "again")
    assert again == experiment
    assert again.to_toml() == text


def test_every_option_is_written_with_its_meaning():
    experiment = load_experiment("spider-genetic")
    text = experiment.to_toml()
    models = {"evolution": experiment.evolution} | {k: experiment.plugin(k) for k in KINDS}
    for section, model in models.items():
        lines = text.split(f"\n[{section}]\n")[1].split("\n[")[0].splitlines()
        for name, field in type(model).model_fields.items():
            (line,) = (line for line in lines if line.startswith((f"{name} ", f"# {name} ")))
            assert " ".join(field.description.split()) in line
    assert tomllib.loads(text)["schema"] == SCHEMA
    meaning = "number of individuals in each generation, on each island"
    assert f"{meaning} (a whole number ≥ 2 and ≤ 1,000,000)" in text


ODD_OPTIONS = '''
from enum import StrEnum
from pydantic import BaseModel, Field

class Colour(StrEnum):
    red = "red"
    blue = "blue"

class Leg(BaseModel, extra="forbid"):
    length: float = 0.1
    names: list[str] = Field(default_factory=list)

class Odd(Body):
    """Options of many types."""
    flag: bool = option(False, "a flag")
    label: str = option("", "two\\nlines of help")
    unset: float | None = option(3.0, "not set though its default is")
    unset_text: str | None = option(None, "text or nothing")
    pair: tuple[float, float] = option((0.0, 1.0), "two numbers")
    table: dict[str, int] = option({}, "names and numbers")
    leg: Leg = option(Leg(), "a leg")
    legs: list[Leg] = option([], "legs")
    colour: Colour = option(Colour.red, "a colour")
    either: Literal["auto"] | float | bool = option("auto", "a word, a number or a switch")
    hostile: int = option(1, "a bell \\a and \\0", unit="m\\nlast = 5")
    bare: int = 3
    last: int = option(1, "the last")
'''


def odd(install, working, custom, parsed, **options):
    install(
        "fake", working + ODD_OPTIONS, {"organism": {"odd": "Odd"}, "fitness": {"far": "Distance"}}
    )
    text = custom(organism="odd", fitness="far")
    experiment = parsed(text=text)
    kind = type(experiment.organism)
    return dataclasses.replace(experiment, organism=kind(**options))


def test_options_of_any_type_come_back(parsed, custom, install, working):
    experiment = odd(
        install,
        working,
        custom,
        parsed,
        flag=True,
        label='"[bold]"\n\t\\ é \0 🕷 #',
        unset=None,
        pair=(0.1, 1e22),
        table={"a b": 1, "": 2, 'c"': -3},
        leg={"length": 0.3, "names": ["x", "none"]},
        legs=[{"length": 1.0}, {"names": [""]}],
        colour="blue",
        last=7,
    )
    text = experiment.to_toml()
    again = parse_experiment(text, "again")
    assert again == experiment
    assert again.organism.last == 7
    assert again.organism.unset is None
    assert again.to_toml() == text


TEXTS = st.text(st.characters(codec="utf-8"))


@given(label=TEXTS, name=TEXTS, number=st.floats(allow_nan=False, allow_infinity=False))
@settings(
    max_examples=40,
    suppress_health_check=[HealthCheck.function_scoped_fixture],  # it is only read
)
def test_any_text_and_number_come_back(experiment_of_odd_options, label, name, number):
    kind = type(experiment_of_odd_options.organism)
    organism = kind(label=label, table={name: 1}, unset_text=label, pair=(number, -number))
    experiment = dataclasses.replace(experiment_of_odd_options, organism=organism)
    again = parse_experiment(experiment.to_toml(), "again").organism
    assert (again.label, again.table) == (label, {name: 1})
    assert str(again.pair) == str((number, -number))
    if label.lower() != "none":
        assert again.unset_text == label


@pytest.fixture
def experiment_of_odd_options(parsed, custom, install, working):
    return odd(install, working, custom, parsed)


def test_options_of_any_type_are_set_from_the_command_line(parsed, custom, install, working):
    experiment = odd(install, working, custom, parsed)
    changes = [
        "organism.flag=true",
        "organism.label=12",
        "organism.unset=none",
        "organism.unset_text=[bold]",
        "organism.pair=[1, 2.5]",
        "organism.table.b=4",
        "organism.leg.length=0.7",
        "organism.colour=blue",
    ]
    body = with_overrides(experiment, parse_assignments(changes)).organism
    assert (body.flag, body.label, body.unset, body.unset_text) == (True, "12", None, "[bold]")
    assert (body.pair, body.table, body.leg.length) == ((1.0, 2.5), {"b": 4}, 0.7)
    assert body.colour == "blue"
    with pytest.raises(ExperimentError, match="a table with the keys length, names"):
        with_overrides(experiment, {"organism.leg.lenght": 1})
