"""The content of an experiment's TOML, with or without its plugins."""

import pytest

from gaitsim.errors import GaitsimError
from gaitsim.experiment import load_experiment, read_outline
from gaitsim.registry import KINDS

BARE = "seed = 7\n" + "".join(f'[{kind}]\nplugin = "my-{kind}"\n' for kind in KINDS)


def test_a_plugin_need_not_be_installed():
    outline = read_outline(BARE, "mine")
    assert outline.plugins["organism"] == "my-organism"
    assert (outline.seed, outline.evolution.generations, outline.islands.number) == (7, 300, 1)


def test_the_outline_has_the_values_of_the_experiment():
    experiment = load_experiment("spider")
    outline = read_outline(experiment.to_toml(), "spider")
    assert (outline.name, outline.description) == (experiment.name, experiment.description)
    assert outline.evolution == experiment.evolution
    assert outline.plugins == {kind: entry.name for kind, entry in experiment.entries.items()}
    assert outline.options()["evolution.population"] == experiment.evolution.population


def test_options_for_the_length_of_a_search_do_not_affect_the_individuals():
    longer = BARE + "[evolution]\ngenerations = 9\npopulation = 8\n[islands]\nnumber = 1\n"
    assert read_outline(longer, "mine").search_options()["evolution"] == {"population": 8}
    assert "islands" not in read_outline(longer, "mine").search_options()


def test_options_of_drawn_worlds_have_no_effect_without_any():
    cases = BARE + "[worlds]\ncases = [{}]\nnumber = 0\nredraw = 2\n"
    outline, drawn = (read_outline(one, "mine") for one in (cases, cases.replace("0", "3")))
    assert outline.search_options()["worlds"] == {"cases": [{}], "number": 0}
    assert "worlds.redraw" not in outline.options()
    assert drawn.search_options()["worlds"]["redraw"] == drawn.options()["worlds.redraw"] == 2


@pytest.mark.parametrize(
    ("text", "key"),
    [
        ("seed = 1", "organism.plugin"),
        (BARE.replace('"my-fitness"', "3"), "fitness.plugin"),
        (BARE.replace("7", '"seven"'), "seed"),
        (BARE + "[evolution]\npopulation = 1\n", "evolution.population"),
        (BARE + "[islands]\nnumbr = 1\n", "islands.numbr"),
        ("evolution = 3\n" + BARE, "evolution"),
    ],
)
def test_invalid_keys_are_named(text, key):
    with pytest.raises(GaitsimError) as error:
        read_outline(text, "mine")
    assert error.value.key == key


@pytest.mark.parametrize(
    ("more", "what"),
    [
        ("seed = inf", "seed is missing or invalid"),
        ("name = [1]", "name is missing or invalid"),
        (f"many = [{'1,' * 30_000}]", "too many values"),
        ("""'a'."b" . """ * 11 + "a = 1", "nested too deeply"),
    ],
)
def test_a_hostile_file_is_refused(more, what):
    with pytest.raises(GaitsimError, match=what):
        read_outline(f"{more}\n" + BARE.replace("seed = 7\n", ""), "mine")


def test_dots_in_texts_and_comments_are_no_keys():
    dots = "1." * 100
    text = f"description = \"it's {dots}\" # {dots[:38]}\n'{dots}' = '{dots}'\n" + BARE
    assert dots in read_outline(text, "mine").description
