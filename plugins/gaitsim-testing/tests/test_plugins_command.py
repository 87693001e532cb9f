"""`gaitsim plugins new` and `gaitsim plugins check` on the command line."""

from pathlib import Path

import pytest


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        (["Two Legs"], "'two-legs'"),
        (["spider"], "the name 'spider' is taken"),
        (["hopper", "--kind", "organsim"], "did you mean 'organism'?"),
        (["there"], "there already exists"),
    ],
)
def test_invalid_input_writes_nothing(gaitsim, arguments, says):
    Path("there").mkdir()
    done = gaitsim("plugins", "new", *arguments, code=2)
    assert done.stderr.startswith("Error: ")
    assert says in done.stderr
    assert [path.name for path in Path().iterdir()] == ["there"]


BROKEN = """
class X(Body):
    legs: int = option(4, "")
    def move(self, genomes):
        return Motion(1.0, {"distance": genomes.T})
"""


@pytest.mark.slow
def test_findings_end_with_exit_code_1(gaitsim, install, working):
    install("fake", working + BROKEN, {"organism": {"x": "X", "y": "Body"}})
    done = gaitsim("plugins", "check", "fake", code=1)
    assert done.stdout.splitlines()[0].startswith("✗ organism x  fake 1.0")
    for part in ("error: declarations: the option legs has no description", "allowed:", "try:"):
        assert part in done.stdout
    assert "✓ organism y" in done.stdout
    assert "Traceback" not in done.stderr


FOLDERS = {
    "no pyproject": ({}, "cannot read"),
    "no plugins": ({"pyproject.toml": "[project]\nname = 'x'\n"}, "does not register any plugins"),
    "an unknown kind": (
        {"pyproject.toml": "[project.entry-points.'gaitsim.organsim']\nx = 'x:X'\n"},
        "did you mean 'organism'?",
    ),
}


@pytest.mark.parametrize(("files", "says"), FOLDERS.values(), ids=FOLDERS.keys())
def test_a_folder_without_a_package_is_rejected(gaitsim, files, says):
    Path("there").mkdir()
    for name, text in files.items():
        Path("there", name).write_text(text)
    done = gaitsim("plugins", "check", "./there", code=2)
    assert done.stderr.startswith("Error: ")
    assert says in done.stderr


@pytest.mark.parametrize("reference", ["a" * 5000, "", "\x1b[31m"])
def test_an_invalid_name_is_rejected(gaitsim, reference):
    done = gaitsim("plugins", "check", reference, code=2)
    assert done.stderr.startswith("Error: ")
    assert "\x1b" not in done.stderr


@pytest.mark.parametrize("seconds", ["0", "nan", "1e9"])
def test_an_invalid_time_limit_is_rejected(gaitsim, seconds):
    done = gaitsim("plugins", "check", "rank", "--seconds", seconds, code=2)
    assert "invalid time limit: " in done.stderr


def test_the_next_commands_suit_the_kind(gaitsim):
    said = gaitsim("plugins", "new", "gaitsim-calm", "--kind", "mutation").stdout
    assert "gaitsim run spider-genetic --set mutation.plugin=calm" in said
    assert "gaitsim-calm/src/gaitsim_calm/__init__.py" in said
