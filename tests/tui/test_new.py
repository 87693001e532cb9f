"""The forms of a new run: fields of all options, validation while typing, and drafts."""

import asyncio
from contextlib import asynccontextmanager
from pathlib import Path

import pytest
from textual.widgets import Button, Input, OptionList

from gaitsim.experiment import load_experiment
from gaitsim.registry import KINDS, options
from gaitsim.storage.snapshot import RunSnapshot
from gaitsim.tui.widgets.form import TITLES, Field, Part


@pytest.fixture
def fill(here, drive, puppet_file):
    """Return a context that opens the forms of an experiment, by default puppets."""

    @asynccontextmanager
    async def fill(*, begin=str(puppet_file), **options):
        async with drive(**options) as driver:
            driver.app.screen.show_screen("new.New", begin)
            screen = await driver.at("New")
            await driver.until(lambda: screen.validation or "✗" in status(screen) or wrong(screen))
            yield driver, screen

    return fill


def status(screen):
    return str(screen.query_one("#status").render())


def wrong(screen):
    return screen.query_one("#status").has_class("problem")


def fields(screen):
    return {field.option.key: field for field in screen.query(Field)}


async def open_section(driver, screen, section):
    """Open a section and wait for its form; return its fields."""
    screen.sections.active = section
    form = screen.validation.forms[section]
    keys = {option.key for option in form.options}
    await driver.until(lambda: keys <= fields(screen).keys())
    return {key: field for key, field in fields(screen).items() if key in keys}


async def enter(driver, screen, field, text):
    """Type a value of an option and wait for its validation."""
    before = screen.validation
    field.query_one(Input).value = text
    await driver.until(lambda: screen.validation is not before)


async def stop_run(driver, live):
    """Stop a live run, so that its process does not outlive the test's event loop."""
    await driver.until(lambda: live.process is not None or live.state == "finished")
    live.action_stop()
    await driver.until(lambda: live.process is None)


async def choose(driver, words):
    """Choose the first preset with the words."""
    await driver.press("ctrl+g")
    await driver.at("Presets")
    await driver.type(words)
    await driver.press("enter")


class TestForms:
    @pytest.mark.slow
    async def test_every_option_of_every_part_has_a_field(self, fill):
        async with fill() as (driver, screen):
            experiment = load_experiment(screen.builder.preset.reference)
            for section in ("evolution", *KINDS):
                found = await open_section(driver, screen, section)
                model = (
                    experiment.evolution if section == "evolution" else getattr(experiment, section)
                )
                assert {key.split(".")[1] for key in found} == set(type(model).model_fields)
                for field in found.values():
                    about = str(field.query_one(".field-about").render())
                    assert options.meaning(field.option.field) in about
                    assert field.region.right <= 80

    async def test_the_body_stands_beside_questions_about_its_file(self, shaped, fill):
        Path("a.shape").write_text("<a/>")
        async with fill(begin="./a.shape") as (driver, screen):
            picture = screen.query_one("#form-picture")
            await driver.until(lambda: "front" in str(picture.render()))
            status = screen.query_one("#status").region
            assert status.right <= picture.region.x
            assert picture.region.right <= 80
            screen.assign("organism.label", "odd")
            await driver.until(lambda: not picture.display)

    @pytest.mark.slow
    async def test_the_file_of_an_option_can_be_replaced(self, shaped, fill):
        Path("a.shape").write_text("<a/>\n" * 30_000)
        Path("b.shape").write_text("<b/>\n<c/>\n")
        async with fill(begin="./a.shape") as (driver, screen):
            assert screen.command_line() == "gaitsim run ./a.shape"
            field = (await open_section(driver, screen, "organism"))["organism.shape"]
            typed = field.query_one(Input)
            assert (typed.value, typed.placeholder[:19]) == ("", "<a/> (150 kB of tex")
            await enter(driver, screen, field, "none.shape")
            await driver.until(lambda: field.has_class("-wrong"))
            about = str(field.query_one(".field-about").render())
            assert about == "✗ the shape cannot be read; allowed: a shape; another file"
            await enter(driver, screen, field, "b.shape")
            await driver.until(lambda: not field.has_class("-wrong"))
            assert screen.validation.experiment.organism.shape == "<b/>\n<c/>\n"
            assert screen.command_line().endswith("--set organism.shape=b.shape")
            assert "<c/>" not in screen.validation.toml
            await enter(driver, screen, field, "")
            assert screen.validation.experiment.organism.shape.startswith("<a/>")


class TestSearch:
    @pytest.mark.slow
    async def test_options_are_searched_by_words_in_all_sections_and_plugins(self, fill):
        async with fill() as (driver, screen):
            await driver.press("slash")
            palette = await driver.at("CommandPalette")
            await driver.type("price")
            await driver.until(lambda: palette.query_one(OptionList).option_count)
            await driver.press("enter")
            await driver.until(
                lambda: driver.screen is screen and "fitness.price" in fields(screen)
            )
            box = fields(screen)["fitness.price"].query_one(Input)
            await driver.until(lambda: driver.app.focused is box)
            assert screen.sections.active == "fitness"
            await driver.press("ctrl+f")  # an input would take the key elsewhere
            palette = await driver.at("CommandPalette")
            await driver.type("tournament size")
            await driver.until(lambda: palette.query_one(OptionList).option_count)
            await driver.press("enter")
            await driver.until(lambda: screen.validation.forms["selection"].plugin == "tournament")
            await driver.until(lambda: "selection.size" in fields(screen))
            box = fields(screen)["selection.size"].query_one(Input)
            await driver.until(lambda: driver.app.focused is box)


class TestDrafts:
    @pytest.mark.slow
    async def test_changes_become_a_draft_and_quitting_asks_about_it(self, fill):
        async with fill() as (driver, screen):
            field = (await open_section(driver, screen, "evolution"))["evolution.population"]
            await enter(driver, screen, field, "12")
            screen.query_one("#seed", Input).value = "-"
            await driver.until(lambda: len(screen.builder.changes) == 2)
            reference = screen.builder.preset.reference
            await driver.press("escape")
            await driver.at("Home")
            await driver.until(lambda: "Kept as a draft: 2 changes" in driver.notifications())
            driver.app.screen.show_screen(
                "new.New", "spider"
            )  # another preset leaves the draft alone
            await driver.until(lambda: getattr(driver.screen, "validation", None))
            assert not driver.screen.builder.changes
            await driver.press("escape")
            await driver.at("Home")
            driver.app.screen.show_screen("new.New")
            await driver.until(lambda: getattr(driver.screen, "validation", None))
            again = driver.screen
            assert again.builder.preset.reference == reference
            assert again.builder.changes == {"evolution.population": "12", "seed": "-"}
            assert again.query_one("#seed", Input).value == "-"
            assert "Restored your draft: 2 changes" in driver.notifications()
            await driver.press("ctrl+q")
            await driver.at("Confirm")
            await driver.press("n")
            await driver.at("New")
            await driver.press("ctrl+z")
            await driver.at("Confirm")
            await driver.press("y")
            await driver.until(lambda: not again.builder.changes)
            await driver.press("escape")
            await driver.at("Home")
            await driver.press("q")
            await driver.until(lambda: not driver.app.is_running)


class TestValidation:
    @pytest.mark.slow
    async def test_a_problem_is_shown_below_its_option_on_the_tab_and_in_the_status(self, fill):
        async with fill() as (driver, screen):
            field = (await open_section(driver, screen, "fitness"))["fitness.price"]
            await enter(driver, screen, field, "-1")
            assert "✗ a number ≥ 0" in str(field.query_one(".field-about").render())
            tab = screen.query_one("Tab#fitness")
            assert str(tab.label) == f"✗ {TITLES['fitness']}"
            assert "✗ invalid fitness.price: -1 (" in status(screen)
            await enter(driver, screen, field, "0.5")
            assert not field.has_class("-wrong")
            assert str(tab.label) == TITLES["fitness"]
            assert "Ready to run" in status(screen)


class TestLoading:
    @pytest.mark.slow
    @pytest.mark.parametrize(
        ("begin", "what"),
        [
            ("./bad [b].toml", "not valid TOML"),
        ],
    )
    async def test_an_invalid_experiment_is_reported_and_a_preset_can_be_loaded(
        self, fill, begin, what
    ):
        Path("bad [b].toml").write_text("[[[")
        async with fill(begin=begin) as (driver, screen):
            assert what in status(screen)
            button = screen.query_one("#preset", Button)
            assert begin in str(button.label)
            await driver.until(lambda: button.size.width > len(str(button.label)))
            await choose(driver, "millipede random")
            await driver.until(lambda: screen.validation is not None)
            assert screen.builder.preset.reference == "millipede-random"
            button = screen.query_one("#preset", Button)
            await driver.until(lambda: button.region.width >= len("millipede-random ▾"))

    @pytest.mark.slow
    async def test_loading_a_preset_asks_before_discarding_changes(self, fill):
        async with fill() as (driver, screen):
            field = (await open_section(driver, screen, "evolution"))["evolution.population"]
            await enter(driver, screen, field, "12")
            await choose(driver, "fly")
            await driver.at("Confirm")
            assert driver.text(".dialog-about") == "1 change will be discarded."
            await driver.press("n")
            await driver.until(lambda: driver.screen is screen)
            await driver.press("ctrl+z")
            await driver.at("Confirm")
            assert "Undo all changes?" in driver.text(".dialog-title")
            await driver.press("n")
            await driver.until(lambda: driver.screen is screen)
            assert screen.builder.changes
            await choose(driver, "fly")
            await driver.at("Confirm")
            await driver.press("y")
            await driver.until(lambda: screen.validation.forms["organism"].plugin == "fly")
            assert not screen.builder.changes

    @pytest.mark.slow
    async def test_a_file_can_be_loaded(self, fill):
        async with fill() as (driver, screen):
            Path("mine.toml").write_text(load_experiment("millipede", {"seed": 77}).to_toml())
            await driver.press("ctrl+l")
            await driver.at("ChooseFile")
            await driver.type("mi")
            await driver.until(lambda: driver.screen.query_one(OptionList).option_count == 1)
            await driver.press("tab", "enter")
            await driver.until(lambda: screen.query_one("#seed", Input).value == "77")
            assert screen.command_line() == "gaitsim run ./mine.toml"


class TestStartingAndSaving:
    @pytest.mark.slow
    async def test_run_creates_the_same_run_as_the_command(self, fill):
        async with fill() as (driver, screen):
            field = (await open_section(driver, screen, "evolution"))["evolution.generations"]
            await enter(driver, screen, field, "2")
            overrides = screen.builder.overrides
            reference = screen.builder.preset.reference
            await driver.press("ctrl+r")
            live = await driver.at("Live")
            path = Path("runs/puppet")
            assert (
                RunSnapshot(path).experiment_text == load_experiment(reference, overrides).to_toml()
            )
            await driver.until(lambda: RunSnapshot(path).generation == 2)
            await driver.until(lambda: live.process is None)  # else leaving would ask first
            await driver.press("escape")
            await driver.at("Home")

    @pytest.mark.slow
    async def test_run_pressed_during_loading_starts_after_it(self, here, drive, puppet_file):
        async with drive() as driver:
            driver.app.screen.show_screen("new.New", str(puppet_file))
            await driver.at("New")
            await driver.press("ctrl+r")
            live = await driver.at("Live")
            assert live.run == Path("runs/puppet")
            await stop_run(driver, live)
            driver.app.screen.show_screen("new.New", "./nowhere.toml")
            screen = await driver.at("New")
            await driver.press("ctrl+r")
            await driver.until(lambda: "cannot read" in status(screen))
            assert driver.screen is screen

    @pytest.mark.slow
    async def test_run_focuses_the_first_invalid_option(self, fill):
        async with fill() as (driver, screen):
            field = (await open_section(driver, screen, "fitness"))["fitness.price"]
            await enter(driver, screen, field, "x")
            await open_section(driver, screen, "evolution")
            await driver.press("ctrl+r")
            await driver.until(lambda: driver.app.focused is field.query_one(Input))
            assert not Path("runs").exists()

    @pytest.mark.slow
    async def test_save_writes_the_displayed_file(self, fill):
        async with fill(size=(160, 48)) as (driver, screen):
            field = (await open_section(driver, screen, "evolution"))["evolution.population"]
            await enter(driver, screen, field, "12")
            shown = screen.validation.toml
            assert "population = 12" in str(screen.query_one("#beside Static").render())
            await driver.press("ctrl+s")
            ask = await driver.at("Ask")
            ask.query_one(Input).value = "mine"
            await driver.press("enter")
            await driver.until(lambda: Path("mine.toml").exists())
            assert Path("mine.toml").read_text() == shown
            assert load_experiment("mine.toml") == screen.validation.experiment
            await driver.until(lambda: "gaitsim run mine.toml" in driver.notifications())

    @pytest.mark.slow
    async def test_a_file_is_replaced_only_after_confirmation(self, fill):
        async with fill() as (driver, screen):
            Path("puppet.toml").write_text("mine")
            for answer, kept in (("n", True), ("y", False)):
                await driver.press("ctrl+s")
                await driver.at("Ask")
                await driver.press("enter")
                await driver.at("Confirm")
                await driver.press(answer)
                await driver.at("New")
                assert not kept or Path("puppet.toml").read_text() == "mine"
            await driver.until(lambda: Path("puppet.toml").read_text() == screen.validation.toml)

    async def test_an_option_chosen_from_a_closed_form_is_ignored(self, fill):
        async with fill() as (driver, screen):
            await driver.press("escape")
            await driver.at("Home")
            screen.go_to("evolution.population")
            assert driver.screen is not screen


async def test_what_is_typed_while_a_form_is_built_is_kept(fill, monkeypatch):
    built, mount_all = asyncio.Event(), Part.mount_all

    async def slow(part, widgets):
        await mount_all(part, widgets)
        await built.wait()

    async with fill() as (driver, screen):
        monkeypatch.setattr(Part, "mount_all", slow)
        await open_section(driver, screen, "search")
        screen.query_one("#seed").focus()
        await driver.press("7")
        assert "seed" in screen.builder.changes
        built.set()
