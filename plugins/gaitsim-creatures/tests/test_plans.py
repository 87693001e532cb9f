"""Plans of bodies, tables of modules, and the mistakes in them."""

from pathlib import Path

import pytest

from gaitsim import GaitsimError
from gaitsim_creatures.modules import TABLES, load_modules, modules_text
from gaitsim_creatures.organism import Creature
from gaitsim_creatures.plans import grow_plan, parse_plan, plan_text, published

REVOLVE = Path(__file__).parents[1] / "gaitsim_creatures" / "tables" / "revolve2.toml"


@pytest.mark.parametrize(
    ("name", "parts"), [("gecko", (6, 6)), ("spider", (8, 8)), ("snake", (7, 8))]
)
def test_published_bodies_have_the_published_parts(name: str, parts: tuple[int, int]) -> None:
    """The numbers of bricks and hinges of revolve2's gecko, spider and snake."""
    for table in TABLES:
        body = Creature(body=name, modules=table)
        assert len(body.joint_names()) == parts[1]
        assert (body._plan.modules[0, 1:, 0] == 1).sum() == parts[0]


def test_masses_are_those_of_the_table() -> None:
    """MuJoCo's mass of the gecko is the sum of its parts."""
    body, table = Creature(body="gecko"), load_modules("revolve2")
    hinges = table.hinge.base_mass + table.hinge.arm_mass
    expected = table.core.mass + 6 * table.brick.mass + 6 * hinges
    assert body.simulation.model.body_mass.sum() == pytest.approx(expected, rel=1e-9)
    assert body.simulation.anatomy.mass == pytest.approx(expected, rel=1e-9)


def test_a_plan_grows_into_the_body_that_it_describes() -> None:
    """A plan, and the plan of its body, are the same."""
    for plan in published().values():
        modules = parse_plan(plan)
        bodies = grow_plan(modules, load_modules("revolve2").shapes)
        assert parse_plan(plan_text(bodies.modules[0, : bodies.counts[0]])) == modules
    assert parse_plan("lf brick, l hinge -90°") == parse_plan("L hinge 270, LF brick")


@pytest.mark.parametrize(
    ("plan", "said"),
    [
        ("L hinge, L brick", "taken twice"),
        ("LF brick", "no module 'L'"),
        ("L wheel", "'wheel' is not a module"),
        ("X hinge", "'X' is not a face"),
        ("L hinge 30", "multiple of 45°"),
        ("L", "is not a module"),
        (" , ", "not 0"),
        ("L brick, LL brick, LLL brick, LLLL brick", "no room for the module 'LLL'"),
        ("U brick", "no room for the module 'U'"),
    ],
)
def test_mistakes_in_plans_get_one_message(plan: str, said: str) -> None:
    """The message names the mistake and the published bodies."""
    with pytest.raises(GaitsimError) as found:
        Creature(body=plan)
    assert said in f"{found.value.what}"
    assert "gecko" in str(found.value.allowed)


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ("mass = 0.25", "mass = -0.25", "core.mass"),
        ("mass = 0.25\n", "", "core.mass"),
        ("reach = 60.0", "reach = 0.0", "hinge.reach"),
        ("size = [0.089, 0.089, 0.0603]", "size = [0.089, inf, 0.0603]", "core.size"),
        ('"front", "left", "right", "back"', '"front", "inside"', "core.faces"),
        ("[servo]", "[motor]", "servo"),
        ("[core]", "[core", "TOML"),
    ],
)
def test_mistakes_in_tables_get_one_message(tmp_path: Path, old: str, new: str, said: str) -> None:
    """A table with missing or impossible values is refused, and says which."""
    table = tmp_path / "table.toml"
    table.write_text(REVOLVE.read_text().replace(old, new))
    with pytest.raises(GaitsimError, match=said):
        modules_text("table.toml", tmp_path)


def test_tables_are_read_from_files_only_where_files_may_be_read(tmp_path: Path) -> None:
    """An experiment stores the text of a table, not its path."""
    (tmp_path / "own.toml").write_text(REVOLVE.read_text().replace("0.25", "0.5"))
    text = modules_text("own.toml", tmp_path)
    assert modules_text(text, None) == text
    assert load_modules(text).core.mass == 0.5
    with pytest.raises(GaitsimError, match="no bundled table"):
        modules_text("own.toml", None)
    with pytest.raises(GaitsimError, match="cannot be read"):
        modules_text("missing.toml", tmp_path)
