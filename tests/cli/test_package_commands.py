"""Commands that packages add, and those that cannot be used."""

import pytest

SOURCE = '''
from typing import ClassVar
from gaitsim.actions.action import JSON, Action

def hop(height: float = 1.0) -> None:
    """Hop [once] on the spot.

    More about hops.
    """
    print(f"hopped {height:g} m")

class Jump(Action):
    """Jump over a run."""

    json_: bool = JSON

    def do(self):
        print(f"jumped {self.json_}")

number = 3
'''


@pytest.fixture
def wide(monkeypatch):
    """Print help in lines that fit the errors."""
    monkeypatch.setenv("COLUMNS", "200")
    monkeypatch.setenv("TERM", "dumb")


def lines(text):
    """Return the lines of the commands in a help text by command."""
    found = (line.strip(" │").split("  ", 1) for line in text.splitlines())
    return {one[0]: one[1].strip() for one in found if len(one) == 2}


def test_functions_and_actions_of_a_package_are_commands(install, gaitsim, wide):
    install("fake", SOURCE, {"command": {"hop": "hop", "jump": "Jump"}})
    listed = lines(gaitsim("--help").stdout)
    assert listed["hop"] == "Hop [once] on the spot."
    assert listed["jump"] == "Jump over a run."
    assert "More about hops." in gaitsim("hop", "--help").stdout
    assert gaitsim("hop", "--height", 2).stdout == "hopped 2 m\n"
    assert gaitsim("jump", "--json").stdout == "jumped True\n"
    assert "Did you mean 'jump'?" in gaitsim("jmup", code=2).stderr


@pytest.mark.parametrize(
    ("source", "target", "problem"),
    [
        ("import no_such_module", "hop", "ModuleNotFoundError: No module named 'no_such_module'"),
        ("raise SystemExit('[/bold]')", "hop", "SystemExit: [/bold]"),
        (SOURCE, "number", "is neither a function nor an action, but a int"),
    ],
)
def test_a_broken_command_is_listed_with_its_error(install, gaitsim, wide, source, target, problem):
    install("fake", source, {"command": {"hop": target}})
    listed = lines(gaitsim("--help").stdout)
    assert "command 'hop' of package fake 1.0" in listed["hop"]
    assert problem in listed["hop"]
    assert "run" in listed
    error = gaitsim("hop", code=2).stderr
    assert problem in error
    assert "fake" in error


def test_a_name_of_gaitsim_itself_is_refused(install, gaitsim, wide):
    install("fake", SOURCE, {"command": {"runs": "hop", "export": "hop"}})
    listed = lines(gaitsim("--help").stdout)
    for name in ("runs", "export"):
        problem = f"command '{name}' of package fake 1.0 cannot be used: gaitsim itself has"
        assert problem in listed[f"{name} (fake)"]
        assert problem in gaitsim(f"{name} (fake)", code=2).stderr
    assert "hopped" not in gaitsim("runs").stdout


def test_a_name_that_two_packages_register_is_refused(install, gaitsim, wide):
    install("one", SOURCE, {"command": {"hop": "hop", "gallery": "hop"}})
    install("two", SOURCE, {"command": {"hop": "hop"}})
    assert "by one 1.0" in lines(gaitsim("--help").stdout)["hop"]
    error = " ".join(gaitsim("hop", code=2).stderr.split())
    assert "the command name 'hop' is registered more than once: by two 1.0 (two:hop)" in error
    assert "registered more than once" in gaitsim("gallery", code=2).stderr
