"""Packages add commands, screens, plots and functions by entry points alone."""

import subprocess
import sys
import tomllib
from pathlib import Path

import pytest

from gaitsim.registry import entry_points
from gaitsim.registry.entry_points import own_packages

ROOT = Path(__file__).parents[2]

SOURCE = '''
from typing import ClassVar

from gaitsim.plugin import Plot
from gaitsim.plugin.commands import Action
from gaitsim.screen import Hidden


class Hop(Action):
    """Hop on the spot."""

    def do(self):
        print("hopped")


class Dots(Plot):
    """A plot of nothing."""

    title: ClassVar[str] = "Dots"
    group: ClassVar[str] = "of nothing"
    input: ClassVar[str] = "run"

    def draw(self, subject):
        from matplotlib.figure import Figure

        return Figure(figsize=(3, 2))


def greet(name):
    return f"hello {name}"


def show(screen):
    screen.app.push_screen(make())


def make():
    from gaitsim.screen import GaitScreen

    class Hello(GaitScreen):
        """A screen of a package."""

    return Hello(id="hello")


HELLO = Hidden("hello", "K", "Hello", "Show the screen of a package", show=show)
'''
ENTRIES = {
    "command": {"hop": "Hop"},
    "plot": {"dots": "Dots"},
    "python": {"greet": "greet"},
    "screen": {"hello": "HELLO"},
}
DRIVE = """
import asyncio
from pathlib import Path
from gaitsim.tui.app import GaitsimApp

async def main():
    async with GaitsimApp(Path("nowhere")).run_test() as pilot:
        await pilot.press("K")
        await pilot.pause()
        print(pilot.app.screen.id, pilot.app.screen.gaitsim.title)

asyncio.run(main())
"""


def test_a_package_adds_a_command_a_plot_and_a_function(install, gaitsim, finished, tmp_path):
    install("fake", SOURCE, ENTRIES)
    assert "Hop on the spot." in gaitsim("--help").stdout
    assert gaitsim("hop").stdout == "hopped\n"
    gaitsim("plot", "puppet", "--kind", "dots", "--out", "dots.png")
    assert (tmp_path / "dots.png").read_bytes().startswith(b"\x89PNG")
    import gaitsim as gs

    assert gs.greet("you") == "hello you"
    assert "greet" in dir(gs)


def test_a_package_adds_a_screen(install, tmp_path):
    """The keys of screens are read when their classes are defined, so in a new process."""
    folder = install("fake", SOURCE, ENTRIES)
    path = f"import sys; sys.path.insert(0, {str(folder)!r})\n"
    done = subprocess.run(
        [sys.executable, "-c", path + DRIVE],
        cwd=tmp_path,
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.stdout.split() == ["hello", "gaitsim"], done.stderr


def test_a_screen_that_cannot_be_loaded_is_reported(install, tmp_path):
    folder = install("fake", "import no_such_module", {"screen": {"hello": "HELLO"}})
    path = f"import sys; sys.path.insert(0, {str(folder)!r})\n"
    code = (
        "from gaitsim.tui.screens import base\nfrom gaitsim.tui.keys import broken\nprint(*broken)"
    )
    done = subprocess.run(
        [sys.executable, "-c", path + code], capture_output=True, text=True, check=False
    )
    assert "screen 'hello' of package fake 1.0 failed" in done.stdout, done.stderr


@pytest.mark.parametrize(
    ("words", "package"),
    [
        (("run", "hexapod"), "gaitsim-robot"),
        (("run", "dog.urdf"), "gaitsim-robot"),
        (("adapt", "puppet"), "gaitsim-adaptation"),
        (("robots", "list"), "gaitsim-robot"),
        (("plugins", "check"), "gaitsim-testing"),
        (("export", "puppet", "--format", "html"), "gaitsim-page"),
        (("run", "spider", "--set", "fitness.plugin=travel"), "gaitsim-robot"),
        (("run", "nothing"), ""),
        (("nothing",), ""),
    ],
)
def test_a_name_of_a_package_that_is_not_installed_says_how_to_install_it(
    gaitsim, finished, monkeypatch, words, package
):
    real = entry_points.entries

    def without_packages(kind):
        return {
            name: claims
            for name, claims in real(kind).items()
            if not claims[0].package.startswith("gaitsim-")
        }

    for module in [*sys.modules.values()]:
        if vars(module).get("entries") is real:
            monkeypatch.setattr(module, "entries", without_packages)
    said = gaitsim(*words, code=2).stderr
    assert ("pip install " in said) == bool(package)
    assert package in said


def test_the_catalogue_lists_what_the_packages_provide():
    found = {}
    for file in ROOT.glob("plugins/*/pyproject.toml"):
        project = tomllib.loads(file.read_text())["project"]
        groups = project.get("entry-points", {}).items()
        found[project["name"]] = {
            group.removeprefix("gaitsim."): [*names]
            for group, names in groups
            if group.startswith("gaitsim.")
        }
    assert own_packages() == found
