"""All problems of invalid files are reported at once, with their places."""

import pytest

from gaitsim.errors import ExperimentError, GaitsimError
from gaitsim.experiment import load_experiment, with_overrides
from gaitsim.registry.loading import read_preset

SPIDER = read_preset("spider-genetic")


def changed(old, new):
    assert old in SPIDER
    return SPIDER.replace(old, new)


@pytest.mark.parametrize(
    ("text", "where", "what"),
    [
        (changed("[mutation]", "[[mutation]]"), "key mutation", "is a list of sections"),
        (changed("= 200", "= 200.0"), "key evolution.population", ": 200.0 ("),
        (changed("= 200", "= 2020-01-02"), "key evolution.population", ": 2020-01-02 ("),
        (changed('"sine"', "2020-01-02"), "key organism.encoding", ": 2020-01-02 ("),
        (changed('"sine"', "3"), "key organism.encoding", "invalid organism.encoding: 3 ("),
        (changed("0.25", "inf"), "key evolution.delta_fitness", "inf is not finite ("),
        (changed("seed = 0", "seed = -1"), "key seed", "invalid seed: -1"),
        (changed("seed = 0", "schema = 2"), "key schema", "belongs to a newer version of gaitsim"),
        (changed("seed = 0", "schema = 0"), "key schema", "there is no schema 0"),
        ('experiments = ["spider"]', "key experiments", "the file is a study"),
        (changed("seed = 0", "sead = 0"), "key sead", 'unknown key "sead"'),
        (changed("seed = 0", "'' = 0"), "key ", 'unknown key ""'),
        (changed("elites = 2", "elites = 200"), "key evolution.population", "200 elites leave"),
        (
            changed("generations = 1000", "max_evaluations = 199"),
            "key evolution.max_evaluations",
            "199 evaluations are not enough",
        ),
        (changed("rate = 0.08", "rate = -0.1"), "key mutation.rate", ": -0.1 ("),
        (changed("rate = 0.08", "rat = 0.1"), "key mutation.rat", 'unknown key "rat"'),
        (
            changed('plugin = "spider-walk"', "plugin = 3"),
            "key fitness.plugin",
            "3 is not the name of a plugin",
        ),
        (
            changed('plugin = "spider-walk"', 'plugin = "spider-wlak"'),
            "key fitness.plugin",
            "unknown fitness plugin 'spider-wlak'",
        ),
        (SPIDER + "\0", "line", "not valid TOML"),
        (f"a = {'[' * 5000}", "", "nested too deeply"),
        (f"{'a.' * 5000}a = 1", "", "nested too deeply"),
        (changed("= 200", f"= {'[' * 21}{']' * 21}"), "key evolution", "nested too deeply"),
    ],
)
def test_a_wrong_file_is_refused_at_its_place(problem, text, where, what):
    found = problem(text=text)
    assert found.where.startswith(f"x.toml, {where}" if where else "x.toml")
    assert what in found.what


def test_a_section_that_is_a_value_is_refused(problems):
    text = "evolution = 3\norganism = 'spider'\n[fitness]" + SPIDER.partition("[fitness]")[2]
    found = {one.where: one for one in problems(text=text)}
    assert found["x.toml, key evolution"].what == "evolution is 3, not a section"
    assert found["x.toml, key organism"].what == 'organism is "spider", not a section'
    assert "[organism]" in found["x.toml, key organism"].allowed


def test_all_problems_are_reported_at_once(parsed, problems):
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


@pytest.mark.parametrize("name", ["[bold]", "ü 2", "名前", "x" * 200])
def test_a_name_that_a_folder_can_have_is_taken(parsed, name):
    assert parsed(f"name='{name}'").name == name
    assert with_overrides(parsed(f"name='{name}'"), {}).name == name


@pytest.mark.parametrize(
    "name",
    [
        "",
        "a/b",
        "..",
        ".hidden",
        "a\\\\b",
        "x" * 201,
        "a\\n",
        "a\\u0000",
        "a\\u2028b",
    ],
)
def test_a_name_that_no_folder_can_have_is_refused(problem, name):
    found = problem(text=changed('name = "spider-genetic"', f'name = "{name}"'))
    assert found.where == "x.toml, key name"
    assert "invalid name: " in found.what


def test_a_description_is_one_line(parsed, problem):
    assert "has more than one line" in problem('description="a\\nb"').what
    assert "at most 1,000" in problem(f'description="{"a" * 1001}"').allowed
    assert parsed("description=[red]a\tb".replace("\t", " ")).description == "[red]a b"


@pytest.fixture
def here(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    return tmp_path


def test_a_file_is_found_by_its_path(here):
    (here / "mine.toml").write_text(SPIDER)
    (here / "mine").write_text(SPIDER)
    for reference in ("mine.toml", "./mine", str(here / "mine")):
        assert load_experiment(reference) == load_experiment("spider-genetic")


def test_a_byte_order_mark_and_foreign_line_ends_do_no_harm(here):
    (here / "mine.toml").write_bytes(b"\xef\xbb\xbf" + SPIDER.replace("\n", "\r\n").encode())
    assert load_experiment("mine.toml") == load_experiment("spider-genetic")


@pytest.mark.parametrize(
    ("content", "what"),
    [
        (b"name = '\xe9'", "not a text file in UTF-8"),
        pytest.param(b"#" * 2_000_001, "too large", id="large"),
        (b"", "5 problems"),
    ],
)
def test_a_file_that_is_not_text_is_an_error(here, content, what):
    (here / "x.toml").write_bytes(content)
    with pytest.raises(GaitsimError, match=what):
        load_experiment("x.toml")


@pytest.mark.parametrize(
    ("reference", "what"),
    [
        ("no.toml", "file not found"),
        ("folder.toml", "Is a directory"),
        (f"{'x' * 300}.toml", "name too long"),
        ("nul\0.toml", "null (byte|character)"),
        ("/dev/zero", "not a regular file"),
    ],
)
def test_a_file_that_cannot_be_read_is_reported(here, reference, what):
    (here / "folder.toml").mkdir()
    (here / "file.toml").write_text(SPIDER)
    with pytest.raises(GaitsimError, match=what):
        load_experiment(reference)


def test_an_unknown_preset_is_refused_with_the_nearest_and_the_file_of_that_name(here):
    with pytest.raises(GaitsimError) as raised:
        load_experiment("spidr")
    assert raised.value.remedy == "did you mean 'spider'?"
    (here / "spidr.toml").write_text(SPIDER)
    with pytest.raises(GaitsimError) as raised:
        load_experiment("spidr")
    assert raised.value.remedy.endswith("for the file of that name, use ./spidr.toml")
    assert raised.value.remedy.startswith("did you mean 'spider'?")
    (here / "mine").write_text(SPIDER)
    with pytest.raises(GaitsimError) as raised:
        load_experiment("mine")
    assert raised.value.remedy == "for the file of that name, use ./mine"
