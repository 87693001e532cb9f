"""The choice of a preset by picture, and of a file by its content."""

import os
from pathlib import Path

import pytest
from textual.widgets import OptionList

from gaitsim.experiment import load_experiment
from gaitsim.tui.screens.files import describe_file, list_folder
from gaitsim.tui.screens.presets import Card, draw_body

SIZES = [(80, 24), (160, 48)]


@pytest.fixture(autouse=True)
def quick_pictures(monkeypatch):
    """Draw all bodies alike; other tests draw the real ones."""
    monkeypatch.setattr("gaitsim.tui.screens.presets._picture", lambda name: "⣿⣿⣿")


async def shown(driver):
    await driver.press("n")
    screen = await driver.at("Presets")
    await driver.until(lambda: screen._card is not None)
    return screen


@pytest.mark.sampled
@pytest.mark.parametrize("size", SIZES)
async def test_a_preset_is_filtered_chosen_and_opened(here, drive, size):
    async with drive(size=size) as driver:
        screen = await shown(driver)
        assert screen._card.preset.name == "spider"
        await driver.type("fly hover")
        found = [card.preset.name for card in screen._cards]
        assert "fly-hover" in found
        assert "spider" not in found
        await driver.press("down")
        chosen = screen._card.preset.name
        assert chosen == found[1]
        await driver.press("enter")
        new = await driver.at("New")
        await driver.until(lambda: new.builder is not None)
        assert new.builder.preset.reference == chosen


async def test_the_preset_with_exactly_the_typed_name_is_chosen(here, drive):
    async with drive() as driver:
        driver.app.drafts |= {"spider-atlas": None}
        screen = await shown(driver)
        assert screen._card.preset.name == "spider-atlas"
        await driver.type("spider")
        await driver.until(lambda: screen._card.preset.name == "spider")


async def test_a_draft_is_marked_and_chosen_first(here, drive):
    async with drive() as driver:
        driver.app.drafts |= {"fly": None, "./mine.toml": None}
        screen = await shown(driver)
        assert screen._card.preset.name == "./mine.toml"
        assert screen._card.preset.description == "unsaved changes"
        names = [one.preset.name for one in screen.query(Card) if "draft" in str(one.render())]
        assert sorted(names) == ["./mine.toml", "fly"]


@pytest.mark.slow
@pytest.mark.parametrize("name", ["spider", "millipede", "fly", "walker", "quadruped"])
def test_every_body_has_a_picture(name):
    picture = draw_body(load_experiment(name))
    rows = picture.split("\n")
    assert len(rows) <= 10
    assert all(len(row) <= 34 for row in rows)
    assert sum("\u2800" < char <= "\u28ff" for char in picture) > 10


URDF = b'<?xml version="1.0"?>\n<robot name="a"><joint name="x"/><joint name="y"></joint></robot>'


@pytest.fixture
def folder(tmp_path):
    """A folder with robots, an experiment, and files that must not disturb."""
    files = {
        "dog.urdf": URDF,
        "cat.xml": b"<mujoco><worldbody><joint/></worldbody></mujoco>",
        "page.xml": b"<html></html>",
        "mine.toml": b'[organism]\nplugin = "spider"',
        "other.toml": b"[tool]\nx = 1",
        "noise.urdf": bytes(range(256)) * 100,
        ".hidden.urdf": URDF,
        "readme.txt": b"text",
    }
    for name, content in files.items():
        (tmp_path / name).write_bytes(content)
    (tmp_path / "meshes").mkdir()
    (tmp_path / ".git").mkdir()
    (tmp_path / "broken.urdf").symlink_to("nowhere")
    os.mkfifo(tmp_path / "pipe.urdf")
    return tmp_path


@pytest.mark.packages
def test_a_folder_lists_folders_then_files_by_name(folder):
    names = [one.name for one in list_folder(folder)]
    assert names == [
        "meshes", "cat.xml", "dog.urdf", "mine.toml", "noise.urdf", "other.toml", "page.xml"
    ]  # fmt: skip
    assert [one.name for one in list_folder(folder, "DO")] == ["dog.urdf"]
    assert [one.name for one in list_folder(folder, ".")] == [".git", ".hidden.urdf"]
    assert list_folder(folder / "nowhere") == []


def test_files_are_described_by_their_content(folder):
    assert describe_file(folder / "dog.urdf") == "robot (URDF), 2 joints"
    assert describe_file(folder / "cat.xml") == "robot (MJCF), 1 joint"
    assert describe_file(folder / "mine.toml") == "experiment"
    for name in ("page.xml", "other.toml", "noise.urdf", "pipe.urdf"):
        assert describe_file(folder / name) == ""
    assert describe_file(folder / "broken.urdf") == "cannot be read"


@pytest.mark.slow
async def test_a_file_is_found_by_completion_and_returned(here, drive, folder):
    async with drive() as driver:
        await driver.press("n", "ctrl+l")
        screen = await driver.at("ChooseFile")
        menu = screen.query_one(OptionList)
        screen.query_one("#path").value = f"{folder}/mes"
        await driver.until(lambda: menu.option_count == 1)
        await driver.press("tab")
        await driver.until(lambda: screen.query_one("#path").value == f"{folder}/meshes/")
        screen.query_one("#path").value = f"{folder}/"
        await driver.until(lambda: menu.option_count == 7)
        await driver.until(lambda: "2 joints" in str(menu.get_option_at_index(2).prompt))
        screen.query_one("#path").value = f"{folder}/nothing"
        await driver.until(lambda: not menu.option_count)
        await driver.press("enter")
        assert "file not found" in driver.text("#file-problem")
        screen.query_one("#path").value = f"./{folder}/meshes/"
        await driver.until(lambda: screen.query_one("#path").value == f"{folder}/meshes/")
        await driver.press("enter")
        assert "neither a robot nor an experiment in" in driver.text("#file-problem")
        screen.query_one("#path").value = f"{folder}/mi"
        await driver.until(lambda: menu.option_count == 1)
        await driver.press("enter")
        new = await driver.at("New")
        assert Path(new._experiment) == folder / "mine.toml"
