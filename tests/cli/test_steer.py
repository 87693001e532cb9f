"""`gaitsim steer`: what it steers, and its errors."""

import numpy as np
import pytest
from cart import CART

from gaitsim.api import evolve, load
from gaitsim.sharing.challenge import code_of
from gaitsim.storage.creation import champion_of
from gaitsim.storage.files.checkpoint import write_champion


@pytest.fixture
def terminal(monkeypatch):
    """Let gaitsim run as in a terminal."""
    monkeypatch.setenv("TEXTUAL_DRIVER", "textual.drivers.headless_driver:HeadlessDriver")


def test_steering_needs_a_terminal(gaitsim):
    assert "needs a terminal" in gaitsim("steer", code=2).stderr


def test_a_body_without_commands_is_rejected_with_alternatives(gaitsim, terminal):
    said = gaitsim("steer", "millipede", code=2).stderr
    assert "'millipede' cannot be steered" in said
    assert "a body with steering commands" in said


@pytest.fixture
def opened(monkeypatch, terminal):
    """Return the list of the screens with which `gaitsim steer` opened the terminal UI."""
    screens = []
    monkeypatch.setattr("gaitsim.cli.tui.run_app", lambda app: screens.append(app._first()))
    return screens


def test_presets_files_runs_champions_and_codes_are_steered(gaitsim, cart, opened, tmp_path):
    (tmp_path / "cart.toml").write_text(CART)
    for _ in evolve(cart, out="runs/cart"):
        pass
    run = load("cart")
    write_champion(tmp_path / "champion.pickle", champion_of(run.snapshot, 1))
    (tmp_path / "code.txt").write_text(code_of(run.champion))
    first, last = (run.replay(number).genome for number in (1, None))
    for reference, genome in {
        "cart.toml": np.array([0.3]),
        "cart": last,
        "runs/cart": last,
        "cart@1": first,
        "champion.pickle": first,
        "code.txt": last,
    }.items():
        gaitsim("steer", reference, "--set", "organism.duration=9")
        drive = opened.pop()._load()
        assert np.array_equal(drive._controllers["gait"], genome), reference
        assert drive.experiment.organism.duration == 9
    gaitsim("steer", "cart.toml", "--controller", "gait=cart@1", "--record", "mine")
    screen = opened.pop()
    assert np.array_equal(screen._load()._controllers["gait"], first)
    assert screen.command_line() == "gaitsim steer cart.toml --controller gait=cart@1"
    assert screen._record.name == "mine"


@pytest.mark.slow
def test_gaits_of_the_spider_are_steered_in_physics(gaitsim, opened, spider_run):
    said = gaitsim("steer", "spider", "--set", "organism.friction=0.6").stderr
    assert "spider's gait, played by spider-physics" in said
    drive = opened.pop()._load()
    assert drive.notice in said.replace("\n", " ")
    assert drive.experiment.organism.friction == 0.6
    assert drive.experiment.organism.reflexes.keys() == {"heading"}
    drive.give("faster")
    assert drive.notice == ""
    error = gaitsim("steer", str(spider_run.path), code=2).stderr  # an orbit of a recurrence
    assert "cannot be played as a rhythm" in error


def test_the_default_is_the_fly(gaitsim, opened):
    gaitsim("steer")
    screen = opened.pop()
    assert screen.command_line() == "gaitsim steer"
    assert screen._load().holds
