"""Experiments come back from TOML as they were, and are refused with all their problems."""

import dataclasses
import errno
import tomllib
from pathlib import Path
from typing import Literal, get_args, get_origin

import numpy as np
import pytest
import tomlkit
from hypothesis import HealthCheck, assume, given, settings
from hypothesis import strategies as st
from pydantic import ValidationError

from gaitsim import registry
from gaitsim.errors import ExperimentError, GaitsimError
from gaitsim.evolution.breeding import breed
from gaitsim.experiment import (
    SCHEMA,
    Evolution,
    Experiment,
    load_experiment,
    parse_experiment,
    with_overrides,
)
from gaitsim.presets import read_preset
from gaitsim.registry import EXPERIMENTS, KINDS

SPIDER = read_preset("spider")


def parsed(*overrides, text=SPIDER):
    return parse_experiment(text, "x.toml", overrides)


def problems(*overrides, text=SPIDER):
    """What is wrong, by where: every problem's parts."""
    with pytest.raises(ExperimentError) as raised:
        parsed(*overrides, text=text)
    found = raised.value.problems
    for problem in found:
        assert problem.what
        assert problem.where
    return found


def problem(*overrides, text=SPIDER):
    found = problems(*overrides, text=text)
    assert len(found) == 1, [str(one) for one in found]
    return found[0]


def changed(old, new):
    assert old in SPIDER
    return SPIDER.replace(old, new)


def custom(text=SPIDER, **sections):
    """The spider's experiment with other plugins: kind = name."""
    data = tomllib.loads(text)
    data.update({kind: {"plugin": name} for kind, name in sections.items()})
    return tomlkit.dumps(data)


# Round trips


@pytest.mark.parametrize("name", registry.entries(EXPERIMENTS))
def test_each_preset_comes_back_from_its_toml(name):
    experiment = load_experiment(name)
    text = experiment.to_toml()
    again = parse_experiment(text, "again")
    assert again == experiment
    assert again.to_toml() == text


def test_every_option_is_written_with_its_meaning():
    experiment = load_experiment("spider")
    text = experiment.to_toml()
    for model in (experiment.evolution, *(experiment.plugin(kind) for kind in KINDS)):
        for name, field in type(model).model_fields.items():
            (line,) = (
                line for line in text.splitlines() if line.startswith((f"{name} ", f"# {name} "))
            )
            assert " ".join(field.description.split()) in line
    assert tomllib.loads(text)["schema"] == SCHEMA
    assert "individuals in each generation (a whole number ≥ 2 and ≤ 1,000,000)" in text


def test_an_experiment_is_frozen():
    experiment = load_experiment("spider")
    with pytest.raises(dataclasses.FrozenInstanceError):
        experiment.seed = 3
    with pytest.raises(ValidationError):
        experiment.evolution.population = 3
    with pytest.raises(ValidationError):
        experiment.mutation.rate = 0.3


def values_of(field):
    """Values that an option may have, of those that its declaration allows."""
    bounds = {
        name: getattr(item, name)
        for item in field.metadata
        for name in ("ge", "gt", "le", "lt")
        if getattr(item, name, None) is not None
    }
    members = get_args(field.annotation)
    if get_origin(field.annotation) is Literal:
        return st.sampled_from(members)
    kind = next(kind for kind in (bool, int, float, str) if kind in (field.annotation, *members))
    low, high = bounds.get("ge", bounds.get("gt")), bounds.get("le", bounds.get("lt"))
    drawn = {
        bool: st.booleans(),
        int: st.integers(
            low if low is not None else -(2**63), high if high is not None else 2**63 - 1
        ),
        float: st.floats(
            low,
            high,
            exclude_min="gt" in bounds,
            exclude_max="lt" in bounds,
            allow_nan=False,
            allow_infinity=False,
        ),
        str: st.text(),
    }[kind]
    return st.none() | drawn if type(None) in members else drawn


@st.composite
def models(draw, model):
    options = {name: draw(values_of(field)) for name, field in model.model_fields.items()}
    try:
        return model(**options)
    except ValidationError:  # options that do not go together
        assume(False)


@st.composite
def experiments(draw):
    evolution = draw(models(Evolution))
    size = {"population": evolution.population}
    size["elites"] = draw(st.integers(0, evolution.population - 1))
    size["max_evaluations"] = draw(st.none() | st.integers(evolution.population, 2**63 - 1))
    plugins, entries = {}, {}
    for kind in KINDS:
        name = draw(st.sampled_from(sorted(set(registry.entries(kind)) - {"bit-flip"})))
        entries[kind] = registry.find(kind, name)
        plugins[kind] = draw(models(registry.load_entry(entries[kind])))
    letters = st.characters(codec="utf-8", exclude_categories=["Cc", "Cs", "Zl", "Zp"])
    assume(set(plugins["fitness"].needs) <= set(plugins["organism"].channels))
    name = "n" + draw(st.text(letters, max_size=40)).translate(str.maketrans("", "", '/\\:*?"<>|'))
    return Experiment(
        name=name.strip(),
        description=draw(st.text(letters)),
        seed=draw(st.integers(0, 2**63 - 1)),
        evolution=evolution.model_copy(update=size),
        **plugins,
        entries=entries,
    )


@given(experiments())
@settings(derandomize=True, deadline=None, max_examples=40)
def test_any_experiment_comes_back_from_its_toml(experiment):
    assert parse_experiment(experiment.to_toml(), "again") == experiment


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
    bare: int = 3
    last: int = option(1, "the last")
'''


def odd(install, working, **options):
    install(
        "fake",
        working + ODD_OPTIONS,
        {"organism": {"odd": "Odd"}, "fitness": {"distance": "Distance"}},
    )
    text = custom(organism="odd", fitness="distance")
    experiment = parsed(text=text)
    kind = type(experiment.organism)
    return dataclasses.replace(experiment, organism=kind(**options))


def test_options_of_any_type_come_back(install, working):
    experiment = odd(
        install,
        working,
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


@given(label=st.text(st.characters(codec="utf-8")), name=st.text(st.characters(codec="utf-8")))
@settings(
    derandomize=True,
    deadline=None,
    max_examples=40,
    suppress_health_check=[HealthCheck.function_scoped_fixture],  # it is only read
)
def test_any_text_comes_back(experiment_of_odd_options, label, name):
    kind = type(experiment_of_odd_options.organism)
    organism = kind(label=label, table={name: 1}, unset_text=label)
    experiment = dataclasses.replace(experiment_of_odd_options, organism=organism)
    again = parse_experiment(experiment.to_toml(), "again").organism
    assert (again.label, again.table) == (label, {name: 1})
    if label.lower() != "none":
        assert again.unset_text == label


@pytest.fixture
def experiment_of_odd_options(install, working):
    return odd(install, working)


def test_options_of_any_type_are_set_from_the_command_line(install, working):
    experiment = odd(install, working)
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
    body = with_overrides(experiment, changes).organism
    assert (body.flag, body.label, body.unset, body.unset_text) == (True, "12", None, "[bold]")
    assert (body.pair, body.table, body.leg.length) == ((1.0, 2.5), {"b": 4}, 0.7)
    assert body.colour == "blue"
    with pytest.raises(ExperimentError, match="a table with the keys length, names"):
        with_overrides(experiment, ["organism.leg.lenght=1"])


# Files


@pytest.mark.parametrize(
    ("text", "where", "what"),
    [
        (SPIDER + "\nrate = 0.3\n", "x.toml, line 3", "a key stands twice"),
        (SPIDER + "\n[mutation]\n", "x.toml, line 3", "a section stands twice: ('mutation',)"),
        (changed("[mutation]", "[[mutation]]"), "x.toml, key mutation", "is a list of sections"),
        (changed("= 200", "= true"), "x.toml, key evolution.population", "true is not allowed"),
        (changed("= 200", "= 200.0"), "x.toml, key evolution.population", "200.0 is not allowed"),
        (changed("= 200", "= '200'"), "x.toml, key evolution.population", '"200" is not allowed'),
        (changed("= 200", "= [200]"), "x.toml, key evolution.population", "[200] is not allowed"),
        (changed("= 200", "= {a = 1}"), "x.toml, key evolution.population", "{a = 1} is not"),
        (changed("= 200", "= 2020-01-02"), "x.toml, key evolution.population", "2020-01-02 is not"),
        (changed('"sine"', "2020-01-02"), "x.toml, key organism.encoding", "2020-01-02 is not"),
        (changed('"sine"', "3"), "x.toml, key organism.encoding", "3 is not allowed"),
        (changed("0.25", "nan"), "x.toml, key evolution.delta_fitness", "nan is not a finite"),
        (changed("0.25", "inf"), "x.toml, key evolution.delta_fitness", "inf is not a finite"),
        (changed("0.25", "1e400"), "x.toml, key evolution.delta_fitness", "inf is not a finite"),
        (changed("= 200", f"= {'9' * 5000}"), "x.toml", "a whole number is too long"),
        (changed("seed = 0", f"seed = 0x{'f' * 5000}"), "x.toml, key seed", "too long"),
        (changed("seed = 0", f"seed = {2**63}"), "x.toml, key seed", "too long"),
        (changed("seed = 0", "seed = -1"), "x.toml, key seed", "-1 is out of range"),
        (changed("seed = 0", "seed = true"), "x.toml, key seed", "true is not a whole number"),
        (changed("seed = 0", "seed = 1.0"), "x.toml, key seed", "1.0 is not a whole number"),
        (changed("seed = 0", "schema = 2"), "x.toml, key schema", "by a newer gaitsim"),
        (changed("seed = 0", "schema = 0"), "x.toml, key schema", "there is no schema 0"),
        (changed("seed = 0", "schema = '1'"), "x.toml, key schema", '"1" is not a whole number'),
        (changed("seed = 0", "sead = 0"), "x.toml, key sead", 'unknown key "sead"'),
        (changed("seed = 0", "'' = 0"), "x.toml, key ", 'unknown key ""'),
        (changed("elites = 2", "elites = 200"), "x.toml, key evolution.elites", "200 elites leave"),
        (
            changed("elites = 2", "max_evaluations = 199"),
            "x.toml, key evolution.max_evaluations",
            "199 evaluations are fewer",
        ),
        (changed("rate = 0.08", "rate = -0.1"), "x.toml, key mutation.rate", "-0.1 is not allowed"),
        (changed("rate = 0.08", "rat = 0.1"), "x.toml, key mutation.rat", 'unknown key "rat"'),
        (
            changed('plugin = "spider-walk"', "plugin = 3"),
            "x.toml, key fitness.plugin",
            "3 is not the name of a plugin",
        ),
        (
            changed('plugin = "spider-walk"', ""),
            "x.toml, key fitness.plugin",
            "no fitness is chosen",
        ),
        (
            changed('plugin = "spider-walk"', 'plugin = "spider-wlak"'),
            "x.toml, key fitness.plugin",
            "unknown fitness plugin 'spider-wlak'",
        ),
        (SPIDER + "\0", "x.toml, line", "not valid TOML"),
        (f"a = {'[' * 5000}", "x.toml", "nested too deeply"),
        (f"{'a.' * 5000}a = 1", "x.toml", "nested too deeply"),
        (changed("= 200", f"= {'[' * 21}{']' * 21}"), "x.toml, key evolution", "nested too deeply"),
    ],
)
def test_a_wrong_file_is_refused_at_its_place(text, where, what):
    found = problem(text=text)
    assert found.where.startswith(where)
    assert what in found.what


def test_a_section_that_is_a_value_is_refused():
    text = "evolution = 3\norganism = 'spider'\n[fitness]" + SPIDER.partition("[fitness]")[2]
    found = {one.where: one for one in problems(text=text)}
    assert found["x.toml, key evolution"].what == "evolution is 3, not a section"
    assert found["x.toml, key organism"].what == 'organism is "spider", not a section'
    assert "[organism]" in found["x.toml, key organism"].allowed


def test_an_empty_file_lacks_the_five_plugins():
    found = problems(text="")
    assert [one.where for one in found] == [f"x.toml, key {kind}.plugin" for kind in KINDS]
    assert all(one.allowed for one in found)


def test_all_problems_are_told_at_once():
    text = (
        changed("population = 200", "population = 1")
        .replace('"sine"', '"sin"')
        .replace("size = 3", "siz = 3")
        .replace('"uniform"', '"unifrm"')
        .replace("seed = 0", "sed = 0")
    )
    found = problems("mutation.rate=7", "seed=x", text=text)
    by_place = {one.where: one for one in found}
    assert list(by_place) == [
        "x.toml, key sed",
        "command line, key seed",
        "x.toml, key evolution.population",
        "x.toml, key organism.encoding",
        "x.toml, key selection.siz",
        "x.toml, key crossover.plugin",
        "command line, key mutation.rate",
    ]
    hints = ("'seed'", "'sine'", "'size'", "'uniform'")
    for place, hint in zip(("sed", "encoding", "siz", "crossover.plugin"), hints, strict=True):
        (one,) = (one for where, one in by_place.items() if where.endswith(place))
        assert one.remedy == f"did you mean {hint}?"
    assert by_place["x.toml, key evolution.population"].allowed == (
        "a whole number ≥ 2 and ≤ 1,000,000"
    )
    assert by_place["command line, key mutation.rate"].allowed == "a number ≥ 0 and ≤ 1"
    with pytest.raises(ExperimentError, match="7 problems"):
        parsed("mutation.rate=7", "seed=x", text=text)


@pytest.mark.parametrize("name", ["[bold]", "ü 2", "a.b", "名前", "x" * 200, "12"])
def test_a_name_that_a_folder_can_have_is_taken(name):
    assert parsed(f"name='{name}'").name == name
    assert with_overrides(parsed(f"name='{name}'"), []).name == name


@pytest.mark.parametrize(
    "name",
    [
        "",
        " ",
        "a/b",
        "..",
        ".",
        ".hidden",
        "-x",
        "a\\\\b",
        "a:b",
        "x" * 201,
        "é" * 101,
        " a",
        "a\\n",
        "a\\u001b[31m",
        "a\\u0000",
        "a\\u2028b",
    ],
)
def test_a_name_that_no_folder_can_have_is_refused(name):
    found = problem(text=changed('name = "spider"', f'name = "{name}"'))
    assert found.where == "x.toml, key name"
    assert "cannot name a folder" in found.what


def test_a_description_is_one_line():
    assert "is not one line" in problem('description="a\\nb"').what
    assert parsed("description=[red]a\tb".replace("\t", " ")).description == "[red]a b"


@pytest.fixture
def here(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    return tmp_path


def test_a_file_is_found_by_its_path(here):
    (here / "mine.toml").write_text(SPIDER)
    (here / "mine").write_text(SPIDER)
    for reference in ("mine.toml", "./mine", str(here / "mine")):
        assert load_experiment(reference) == load_experiment("spider")


def test_a_byte_order_mark_and_foreign_line_ends_do_no_harm(here):
    (here / "mine.toml").write_bytes(b"\xef\xbb\xbf" + SPIDER.replace("\n", "\r\n").encode())
    assert load_experiment("mine.toml") == load_experiment("spider")


@pytest.mark.parametrize(
    ("content", "what"),
    [
        (b"name = '\xe9'", "not a text file in UTF-8"),
        (SPIDER.encode("utf-16"), "not a text file in UTF-8"),
        (b"#" * 1_000_001, "too large"),
        (b"", "5 problems"),
        (b"\x80\x04\x95", "not a text file in UTF-8"),
    ],
)
def test_a_file_that_is_no_text_is_refused(here, content, what):
    (here / "x.toml").write_bytes(content)
    with pytest.raises(GaitsimError, match=what):
        load_experiment("x.toml")


@pytest.mark.parametrize(
    ("reference", "what"),
    [
        ("no.toml", "No such file"),
        ("no/such", "No such file"),
        ("folder.toml", "Is a directory"),
        (".", "Is a directory"),
        ("./..", "Is a directory"),
        (f"{'x' * 300}.toml", "name too long"),
        ("file.toml/x", "Not a directory"),
        ("nul\0.toml", "null byte"),
        ("/dev/zero", "too large"),
    ],
)
def test_a_file_that_cannot_be_read_is_told(here, reference, what):
    (here / "folder.toml").mkdir()
    (here / "file.toml").write_text(SPIDER)
    with pytest.raises(GaitsimError, match=what):
        load_experiment(reference)


def test_a_file_without_permission_is_told(here, monkeypatch):
    def refuse(*_args, **_options):
        raise PermissionError(errno.EACCES, "Permission denied")

    (here / "x.toml").write_text(SPIDER)
    monkeypatch.setattr(Path, "open", refuse)  # root, as in many containers, may read all files
    with pytest.raises(GaitsimError, match=r"x\.toml: Permission denied"):
        load_experiment("x.toml")


@pytest.mark.parametrize("reference", ["", "..", "nul\0", "x" * 5000, "[bold]", "\udcff", "no"])
def test_an_unknown_preset_is_refused(here, reference):
    with pytest.raises(GaitsimError, match="unknown experiment") as raised:
        load_experiment(reference)
    assert "spider" in raised.value.allowed
    assert raised.value.remedy == ""


def test_an_unknown_preset_is_refused_with_the_nearest_and_the_file_of_that_name(here):
    with pytest.raises(GaitsimError) as raised:
        load_experiment("spidr")
    assert raised.value.remedy == "did you mean 'spider'?"
    (here / "spidr.toml").write_text(SPIDER)
    with pytest.raises(GaitsimError) as raised:
        load_experiment("spidr")
    assert raised.value.remedy.endswith("for the file of that name, ./spidr.toml")
    assert raised.value.remedy.startswith("did you mean 'spider'?")
    (here / "mine").write_text(SPIDER)
    with pytest.raises(GaitsimError) as raised:
        load_experiment("mine")
    assert raised.value.remedy == "for the file of that name, ./mine"


# The command line's changes


def test_every_option_is_reached_from_the_command_line():
    experiment = load_experiment("spider")
    data = tomllib.loads(experiment.to_toml())
    sections = {"evolution": experiment.evolution}
    sections.update({kind: experiment.plugin(kind) for kind in KINDS})
    for section, model in sections.items():
        for name in type(model).model_fields:
            value = data[section].get(name, 500)  # those not set take a whole number
            shown = f'"{value}"' if isinstance(value, str) else str(value)
            again = with_overrides(experiment, [f"{section}.{name}={shown}"])
            found = getattr(again, section)
            assert getattr(found, name) == value
    assert parsed("seed=7", "name=n", "description=d").seed == 7


def test_the_last_of_two_changes_counts():
    assert parsed("seed=1", "seed=2").seed == 2


def test_an_option_is_unset_by_none():
    assert parsed("evolution.fitness_threshold=none").evolution.fitness_threshold is None
    assert parsed().evolution.fitness_threshold == 0.0


def test_a_plugin_of_the_name_none_is_chosen():
    assert parsed("crossover.plugin=none").entries["crossover"].name == "none"


def test_another_plugin_drops_the_options_of_the_old_one_but_keeps_what_was_typed():
    experiment = parsed("fitness.slip_weight=3")
    other = with_overrides(experiment, ["fitness.plugin=spider-classic"])
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
        ("", "command line", '"" is not KEY=VALUE'),
        ("seed", "command line", '"seed" is not KEY=VALUE'),
        ("=3", "command line", '"=3" is not KEY=VALUE'),
        ("evolution..population=3", "command line", "is not KEY=VALUE"),
        ("evolution=3", "command line, key evolution", '"evolution" is a section'),
        ("organism={plugin='spider'}", "command line, key organism", '"organism" is a section'),
        ("evol.population=3", "command line, key evol.population", 'unknown section "evol"'),
        ("évolution.population=3", "command line, key évolution", 'unknown section "évolution"'),
        ("a.b.c=3", "command line, key a.b.c", 'unknown section "a"'),
        ("population=3", "command line, key population", 'unknown key "population"'),
        ("evolution.popul=3", "command line, key evolution.popul", 'unknown key "popul"'),
        (
            "evolution.population.x=1",
            "command line, key evolution.population.x",
            '"evolution.population" is an option, not a section',
        ),
        ("evolution.population=", "command line, key evolution.population", '"" is not allowed'),
        ("evolution.population=1e3", "command line, key evolution.population", "1e3 is not"),
        ("evolution.population=none", "command line, key evolution.population", "none is not"),
        ("evolution.population=\0", "command line, key evolution.population", "is not allowed"),
        ("mutation.rate=1\nseed=2", "command line, key mutation.rate", "is not allowed"),
        ("mutation.rate=[bold]", "command line, key mutation.rate", "[bold] is not allowed"),
        ("mutation.rate=nan", "command line, key mutation.rate", "nan is not a finite number"),
        ("mutation.rate=0,1", "command line, key mutation.rate", "0,1 is not allowed"),
        ("organism.encoding=\udcff", "command line", "is not text in UTF-8"),
        ("organism.plugin=3", "command line, key organism.plugin", "unknown organism plugin '3'"),
        ("seed=" + "9" * 5000, "command line, key seed", "is not a whole number"),
        ("seed=" + "[" * 5000, "command line, key seed", "is not a whole number"),
        ("evolution.elites=200", "command line, key evolution.elites", "200 elites leave no room"),
    ],
)
def test_an_odd_change_is_refused(change, where, what):
    found = problem(change)
    assert found.where.startswith(where)
    assert what in found.what
    assert len(str(found)) < 600


@pytest.mark.parametrize(
    ("key", "hint"),
    [
        ("population", "'evolution.population'"),
        ("rate", "'mutation.rate'"),
        ("sead", "'seed'"),
        ("evolution.populatoin", "'population'"),
        ("mutaton.rate", "'mutation'"),
    ],
)
def test_a_key_is_refused_with_the_nearest(key, hint):
    assert problem(f"{key}=3").remedy == f"did you mean {hint}?"


@given(st.text())
@settings(derandomize=True, deadline=None, max_examples=25)
def test_any_change_is_taken_or_refused(text):
    for change in (text, f"seed={text}", f"mutation.rate={text}", f"{text}=1"):
        try:
            parsed(change)
        except ExperimentError:
            continue


@given(st.text())
@settings(derandomize=True, deadline=None, max_examples=200)
def test_any_text_is_refused_as_a_file(text):
    with pytest.raises(ExperimentError):
        parsed(text=text)


# Plugins of others


def test_an_operator_that_does_not_work_on_the_genomes_is_refused_with_those_that_do(
    install, working
):
    install("fake", working, {"organism": {"bits": "BitBody"}, "fitness": {"far": "Distance"}})
    found = problem("mutation.plugin=bit-flip")
    assert "'bit-flip' does not work on the real genomes of the organism 'spider'" in found.what
    assert "gaussian" in found.allowed.split(", ")
    assert "bit-flip" not in found.allowed.split(", ")
    found = problem(text=custom(organism="bits", fitness="far"))
    assert found.where == "x.toml, key mutation.plugin"
    assert "'gaussian' does not work on the bit genomes of the organism 'bits'" in found.what
    assert "bit-flip" in found.allowed.split(", ")
    for name in found.allowed.split(", "):
        assert parsed(f"mutation.plugin={name}", text=custom(organism="bits", fitness="far"))


def test_a_fitness_without_its_channels_is_refused_with_those_that_have_them(install, working):
    install("fake", working, {"organism": {"point": "Body"}, "fitness": {"far": "Distance"}})
    found = problem(text=custom(organism="point"))
    assert "'spider-walk' reads the channels" in found.what
    assert found.allowed == "far"
    found = problem("fitness.plugin=far")
    assert "reads the channels distance, which the organism 'spider' does not have" in found.what
    assert "spider-walk" in found.allowed


def test_another_broken_plugin_does_not_stand_in_the_way(install):
    install("fake", "raise SystemExit", {kind: {"broken": "X"} for kind in KINDS})
    assert parsed() == load_experiment("spider")
    assert "gaussian" in problem("mutation.plugin=bit-flip").allowed


@pytest.mark.parametrize(
    ("source", "reason"),
    [
        ("def genome_space(self): 1 / 0", "failed while giving its genome space: ZeroDivision"),
        ("def genome_space(self): return 3", "gave a int from genome_space()"),
        ("def model_post_init(self, _): raise SystemExit(0)", "SystemExit"),
        ("def __init__(self, **_): 1 / 0", "failed while taking its options: ZeroDivision"),
        ("needed: int", "organism.needed is required"),
    ],
)
def test_a_body_that_fails_is_told_among_the_other_problems(install, working, source, reason):
    install(
        "fake",
        f"{working}\nclass X(Body):\n    {source}\n",
        {"organism": {"x": "X"}, "fitness": {"far": "Distance"}},
    )
    text = custom(organism="x", fitness="far")
    found = problems("seed=x", "mutation.rate=7", text=text)
    assert len(found) == 3
    (one,) = (one for one in found if "organism" in one.where)
    assert one.where.startswith("x.toml, key organism")
    assert reason in one.what
    if "required" not in reason:
        assert "package fake 1.0" in one.what
        assert "fake:X" in one.where


def test_a_validators_own_words_are_told(install, working):
    source = """
from pydantic import field_validator, model_validator
from gaitsim.errors import GaitsimError

class X(Body):
    legs: int = option(4, "legs")
    arms: int = option(0, "arms")

    @field_validator("legs")
    @classmethod
    def _even(cls, legs):
        if legs == 1:
            raise GaitsimError("one leg is too few")
        assert legs % 2 == 0, "legs come in pairs"
        return legs

    @model_validator(mode="after")
    def _together(self):
        if self.legs + self.arms > 8:
            raise ValueError("at most 8 limbs")
        return self
"""
    install("fake", working + source, {"organism": {"x": "X"}, "fitness": {"far": "Distance"}})
    text = custom(organism="x", fitness="far")
    found = problem("organism.legs=3", text=text)
    assert found.what == "3 is not allowed: legs come in pairs"
    found = problem("organism.arms=8", text=text)
    assert found.what == "at most 8 limbs"
    assert found.where == "x.toml, section organism, with organism.arms of the command line"
    found = problem("organism.legs=1", text=text)
    assert found.what == "one leg is too few"
    assert "package fake 1.0" in found.where


def test_a_crossover_with_its_number_of_children_in_the_class_breeds(install, working):
    names = {"organism": "Body", "fitness": "Distance", "crossover": "Solo", "mutation": "Still"}
    install("fake", working, {kind: {"x": target} for kind, target in names.items()})
    experiment = parsed(text=custom(**dict.fromkeys(names, "x")))
    assert experiment.crossover.children == 1
    assert parse_experiment(experiment.to_toml(), "again") == experiment
    space = experiment.space()
    genomes = space.random(200, np.random.default_rng(0))
    bred = breed(experiment, space, genomes, genomes.sum(axis=1), 2)
    assert bred.shape == genomes.shape
    assert space.contains(bred)
    found = problem("crossover.children=2", text=custom(**dict.fromkeys(names, "x")))
    assert found.what == 'unknown key "children"'
    assert found.allowed == "none"


def test_a_plugin_that_is_gone_is_told(install, working):
    install("fake", working, {"organism": {"point": "Body"}, "fitness": {"far": "Distance"}})
    experiment = parsed(text=custom(organism="point", fitness="far"))
    text = experiment.to_toml().replace('"point"', '"pont"')
    found = problem(text=text)
    assert found.where == "x.toml, key organism.plugin"
    assert found.remedy == "did you mean 'point'?"
