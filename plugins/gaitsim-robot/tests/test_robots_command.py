"""`gaitsim robots`."""

import json
from pathlib import Path

import pytest

from gaitsim.experiment import load_experiment


@pytest.fixture
def file(tmp_path):
    path = tmp_path / "a.shape"
    path.write_text("<a/>\n<b/>\n")
    return path


def test_a_file_that_can_be_used_is_described(shaped, gaitsim, tmp_path, file):
    said = gaitsim(
        "robots", "check", "a.shape", "--model-out", "whole.shape", "--picture", "a.png"
    ).stdout
    for part in ("a.shape: cube", "1.0 m", "its corners are round", "gaitsim run whole.shape"):
        assert part in said
    assert (tmp_path / "whole.shape").read_text() == file.read_text()
    assert (tmp_path / "a.png").read_bytes().startswith(b"\x89PNG")
    found = json.loads(gaitsim("robots", "check", file, "--json").stdout)
    assert found["usable"]
    assert found["facts"]["Body"]["size"] == "1.0 m"
    assert found["repairs"] == ["its corners are round"]


def test_an_unusable_file_exits_with_1_and_the_reason(shaped, gaitsim, file):
    file.write_text("flat")
    done = gaitsim("robots", "check", "a.shape", code=1)
    assert "a.shape cannot be used: a flat shape cannot roll" in done.stderr
    assert "a round one" in done.stderr
    found = json.loads(gaitsim("robots", "check", "a.shape", "--json", code=1).stdout)
    assert (found["usable"], found["problem"]["what"]) == (False, "a flat shape cannot roll")
    file.write_text("-" * 1_100_000)
    assert "too long" in gaitsim("robots", "check", "a.shape", code=1).stderr


def test_options_can_be_set(shaped, gaitsim, file):
    check = "robots", "check", "a.shape"
    done = gaitsim(*check, "--set", "organism.size=100", "--set", "organism.label=odd")
    assert "100.0 m" in done.stdout
    assert "Warnings\n  it is heavy" in done.stdout
    assert "gaitsim run a.shape --set organism.size=100 --set organism.label=odd" in done.stdout
    found = json.loads(gaitsim(*check, "--set", "organism.size=100", "--json").stdout)
    assert found["warnings"] == ["it is heavy"]
    assert json.loads(gaitsim(*check, "--json").stdout)["warnings"] == []


def test_guesses_are_questions_that_options_answer(shaped, gaitsim, file):
    check = "robots", "check", "a.shape"
    said = gaitsim(*check).stdout
    assert "Unsure" in said
    assert "  Is it plain?  --set 'organism.label=so so'\n" in said
    (question,) = json.loads(gaitsim(*check, "--json").stdout)["questions"]
    assert question == {"text": "Is it plain?", "option": "organism.label", "value": "so so"}
    answer = "--set", f"{question['option']}={question['value']}"
    assert "Unsure" not in gaitsim(*check, *answer).stdout
    assert json.loads(gaitsim(*check, *answer, "--json").stdout)["questions"] == []


def test_the_answers_are_saved_as_an_experiment(shaped, gaitsim, file):
    save = "robots", "check", "a.shape", "--set", "organism.size=2", "--save"
    assert gaitsim(*save, "b.toml").stdout.endswith("b.toml\n\nEvolve a gait: gaitsim run b.toml\n")
    file.unlink()
    found = load_experiment("b.toml")
    assert (found.name, found.organism.size) == ("a", 2)
    assert found.organism.shape.startswith("<a/>")


@pytest.mark.parametrize(
    ("name", "said"),
    [
        ("a.toml", "a.toml already exists"),
        ("a.txt", "a.txt does not have the extension of an experiment file"),
        ("no/a.toml", "no folder no"),
    ],
)
def test_an_experiment_is_only_saved_to_a_new_file(shaped, gaitsim, file, name, said):
    Path("a.toml").write_text("")
    assert said in gaitsim("robots", "check", "a.shape", "--save", name, code=2).stderr
    assert Path("a.toml").read_text() == ""


@pytest.mark.parametrize(
    ("pair", "said"),
    [
        ("organism.size=-1", "invalid organism.size: -1"),
        ("organism.sise=1", "did you mean 'size'?"),
        ("size=1", 'unknown key "size"'),
        ("organism.shape=ball", "organism.shape cannot be set, as the command checks a.shape"),
        ("organism.plugin=spider", "organism.plugin cannot be set"),
        ("nonsense", "is not KEY=VALUE"),
    ],
)
def test_invalid_settings_are_reported_as_by_run(shaped, gaitsim, file, pair, said):
    assert said in gaitsim("robots", "check", "a.shape", "--set", pair, code=2).stderr


def test_a_run_prints_the_warnings_of_its_body(shaped, gaitsim, file):
    brief = "run", "a.shape", "--generations", 1
    assert "Warning: it is heavy" in gaitsim(*brief, "--set", "organism.size=100").stderr
    assert "Warning: it is heavy" in gaitsim("show", "a").stderr
    assert "Warning" not in gaitsim(*brief).stderr


def test_invalid_options_exit_with_2(shaped, gaitsim, file):
    assert "file not found" in gaitsim("robots", "check", "none.shape", code=2).stderr
    assert ".png" in gaitsim("robots", "check", "a.shape", "--picture", "a.gif", code=2).stderr
    Path("a.sdf").write_text("<sdf/>")
    for command in (("robots", "check"), ("run",)):
        said = gaitsim(*command, "a.sdf", code=2).stderr
        assert "shape" in said
        assert "sdf2mjcf" in said
    done = gaitsim("robots", "check", "a.shape", "--root", "nowhere", code=2)
    assert "folder not found: nowhere" in done.stderr


def test_installed_robots_and_servos_are_listed(shaped, gaitsim):
    said = gaitsim("robots", "list").stdout
    assert "ball" in said
    assert ".shape" in said
    lines = map(json.loads, gaitsim("robots", "list", "--json").stdout.splitlines())
    (found,) = (one for one in lines if one["body"] == "cube")
    assert (found["formats"], found["Shapes"]) == (["shape"], {"ball": "round"})
    assert "ball" in gaitsim("plugins", "show", "cube").stdout
