"""Snapshots of the app's screens, with a fixed clock and fixed runs."""

import math
from itertools import chain
from pathlib import Path

import pytest
from waiting import app_until

from gaitsim import registry
from gaitsim.errors import GaitsimError, RunError
from gaitsim.registry import KINDS
from gaitsim.storage.growing import RunsWatcher
from gaitsim.storage.overview import Overview
from gaitsim.tui import products
from gaitsim.tui.app import GaitsimApp
from gaitsim.tui.screens import run_preview
from gaitsim.tui.screens.export_dialog import ExportDialog
from gaitsim.tui.screens.help import Help
from gaitsim.tui.screens.new import New
from gaitsim.tui.screens.plugins import Plugins
from gaitsim.tui.screens.tasks import TaskList
from gaitsim.tui.tasks import Task


def every_form():
    """Return all products of the export dialog, in its order."""
    return [*chain(*products.forms().values())]


NOW = 2e9
SMALL, LARGE = (80, 24), (160, 48)
NAMES = ("spider", "spider-walk", "genetic", "tournament", "uniform", "gaussian")
SPIDER = dict(zip(KINDS, NAMES, strict=True))
RUNS = [
    Overview(
        Path("runs/spider"),
        "running",
        SPIDER,
        description="a spider that walks straight and fast",
        generation=412,
        generations=1000,
        best=2.4979,
        stage=2,
        seconds=95.0,
        changed=NOW - 1,
        curve=tuple(3 - 3 * math.exp(-at / 80) for at in range(412)),
    ),
    Overview(
        Path("runs/a [bold]name 長い名前 and more than there is room for"),
        "stopped",
        SPIDER,
        generation=7,
        generations=100_000,
        best=-12.5,
        changed=NOW - 7200,
        curve=(math.nan, -20.0, -19.0, -15.0, -12.5),
    ),
    Overview(
        Path("runs/millipede"),
        "finished",
        {**SPIDER, "organism": "millipede", "fitness": "millipede-travel"},
        generation=80,
        generations=80,
        best=10.0,
        changed=NOW - 86400 * 3,
        curve=(10.0,) * 80,
    ),
    Overview(
        Path("runs/broken"),
        "damaged",
        {},
        changed=NOW - 30,
        problem=RunError("experiment.toml is [red]not valid TOML", where="runs/broken"),
    ),
]


@pytest.fixture
def look(here, monkeypatch, snap_compare):
    """Return a function that compares a screen with its snapshot."""

    def look(size, before, runs=RUNS, theme=None):
        monkeypatch.setattr(RunsWatcher, "poll", lambda watch, progress=None: runs)
        monkeypatch.setattr(run_preview, "REST", 3600)  # these runs cannot be read
        app = GaitsimApp(Path("runs"), clock=lambda: NOW, theme=theme)

        async def show(pilot):
            await app_until(pilot, lambda: app.screen.runs is not None)
            await app_until(pilot, lambda: not runs or app.screen.query("#runs"))
            await before(pilot)
            await pilot.pause()

        return snap_compare(app, terminal_size=size, run_before=show)

    return look


@pytest.fixture
def only_puppets(monkeypatch):
    """Install only puppets, so that snapshots do not depend on other packages."""
    entries = registry.entries

    def ours(kind):
        found = entries(kind)
        return {
            name: [one for one in claims if "puppets" in one.package]
            for name, claims in found.items()
            if any("puppets" in one.package for one in claims)
        }

    monkeypatch.setattr(registry, "entries", ours)
    monkeypatch.setattr("gaitsim.tui.screens.plugins.entries", ours)


async def nothing(pilot):
    pass


@pytest.mark.packages
def test_home(look):
    assert look(LARGE, nothing)


@pytest.mark.packages
def test_new(look, only_puppets, puppet_file):
    async def go(pilot):
        screen = New("./puppet.toml")
        await pilot.app.push_screen(screen)
        await app_until(pilot, lambda: screen.validation is not None)
        screen.sections.active = "fitness"
        await app_until(pilot, lambda: screen.query("#part-fitness Field"))
        box = screen.query_one("#part-fitness Input")
        before = screen.validation
        box.value = "-1"
        await app_until(pilot, lambda: screen.validation is not before)

    assert look(LARGE, go)


@pytest.mark.packages
def test_plugins(look, only_puppets):
    async def go(pilot):
        screen = Plugins()
        await pilot.app.push_screen(screen)
        await app_until(pilot, lambda: screen.catalogue is not None)
        await pilot.press("down", "down")

    assert look(SMALL, go)


@pytest.mark.slow
def test_export(look, monkeypatch):
    missing = {
        every_form()[1]: GaitsimError("there are no [b]joints", allowed="a body with joints")
    }
    monkeypatch.setattr(
        "gaitsim.tui.screens.export_dialog.unavailable_products", lambda run, forms: missing
    )

    async def go(pilot):
        dialog = ExportDialog(RUNS[0].path, 12)
        await pilot.app.push_screen(dialog)
        await app_until(pilot, lambda: dialog.query("Field"))
        channel = next(place for place, one in enumerate(every_form()) if "channel" in one.plugin)
        await pilot.press(*["down"] * channel)
        await app_until(pilot, lambda: len(dialog.query("Field")) > 4)

    assert look(SMALL, go)


@pytest.mark.packages
def test_help(look):
    async def go(pilot):
        await pilot.app.push_screen(Help(pilot.app.screen))

    assert look(SMALL, go)


def test_tasks(look):
    async def go(pilot):
        pilot.app.tasks.all = [
            Task(("export", "runs/spider"), 0.0, "done", output=["a.mat: 300 frames"], ended=2.0),
            Task(("video", "runs/spider"), 0.0, "stopped", "9/300", 0.03, ended=71.0),
            Task(
                ("imitate", "no [b]where"),
                0.0,
                "failed",
                error=GaitsimError("there is no run", allowed="spider"),
                ended=1.0,
            ),
        ]
        await pilot.app.push_screen(TaskList())

    assert look(SMALL, go)
