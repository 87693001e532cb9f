"""Tasks in the background: records, progress, stopping, failures, and the export dialog."""

import asyncio
import json
import os
import shlex
import sys
from contextlib import nullcontext
from itertools import chain
from pathlib import Path

import pytest

from gaitsim.contracts import Channel
from gaitsim.errors import ExperimentError, GaitsimError
from gaitsim.tui import products
from gaitsim.tui.opener import open_file, open_or_copy
from gaitsim.tui.products import unavailable_products
from gaitsim.tui.screens.base import RunChoice
from gaitsim.tui.screens.tasks import TaskList
from gaitsim.tui.tasks import Task, Tasks
from gaitsim.tui.widgets.form import Field


def every_form():
    """Return all products of the export dialog, in its order."""
    return [*chain(*products.forms().values())]


pytestmark = pytest.mark.skipif(os.name == "nt", reason="SIGINT stops a task")


class TestRecords:
    def task(self, *lines):
        task = Task(("video", "x"))
        for line in lines:
            task.add_record(line)
        return task

    def test_files_with_unusual_names_are_collected(self):
        lines = [json.dumps({"kind": "result", "files": [name]}) for name in ("a: b.csv", "c d")]
        assert self.task(*lines).files == [Path("a: b.csv"), Path("c d")]

    def test_an_error_keeps_its_parts(self):
        problem = GaitsimError("unknown key", where="x.toml", key="mutation.rat", allowed="rate")
        task = self.task(json.dumps({"kind": "error", **ExperimentError([problem]).to_dict()}))
        assert isinstance(task.error, ExperimentError)
        assert task.error.problems[0].key == "mutation.rat"
        assert "unknown key" in task.message

    def test_notices_and_output_of_libraries_are_kept(self):
        task = self.task('{"kind": "notice", "text": "one\\ntwo"}', "Warning: [b]odd[/b]\x1b[2K")
        assert task.notices == ["one", "two", "Warning: [b]odd[/b]\\x1b[2K"]

    @pytest.mark.parametrize(
        "line",
        [
            *("7", "[]", "{", '{"kind": 1}', '{"kind": "progress"}'),
            *('{"kind": "error", "what": "half"}', '{"kind": "result", "files": [3]}'),
        ],
    )
    def test_a_line_that_is_not_a_record_is_a_notice(self, line):
        assert self.task(line).notices == [line]


def run(*arguments, during=None):
    """Run a command as a task; return the task and its state after each change."""
    seen = []

    async def go():
        tasks = Tasks(lambda task: seen.append((task.state, task.share)))
        task = tasks.start(arguments)
        if during is not None:
            async with asyncio.timeout(60):
                await during(tasks, task)
        async with asyncio.timeout(60):
            await tasks.wait()
        return task

    return asyncio.run(go()), seen


class TestTask:
    def test_a_task_that_succeeds(self, walk):
        task, seen = run("export", str(walk()), "--format", "csv")
        assert (task.state, seen[0][0], seen[-1][0]) == ("done", "running", "done")
        [file] = task.files
        assert file.is_file()
        assert not task.notices

    def test_a_failed_task_has_a_message(self, here):
        task, _ = run("export", "nowhere [b]")
        assert task.state == "failed"
        assert "nowhere [b]" in task.error.what
        assert "gaitsim runs" in task.error.remedy

    def test_progress_records_are_read(self, here, monkeypatch):
        # A program in place of gaitsim, with the same records.
        Path("gaitsim.py").write_text(
            "import json, os, sys\n"
            "assert os.environ['GAITSIM_PROGRESS'] == 'json' and not sys.stderr.isatty()\n"
            "for n in range(1, 11):\n"
            "    line = {'kind': 'progress', 'what': 'pictures', 'done': n, 'total': 10}\n"
            "    print(json.dumps(line), file=sys.stderr, flush=True)\n"
            "print('film.mp4: fine')\n"
        )
        monkeypatch.setenv("PYTHONPATH", str(here))
        task, seen = run("video", "x")
        assert (task.state, task.share, task.output) == ("done", 1.0, ["film.mp4: fine"])
        assert task.notices == []
        assert {("running", n / 10) for n in range(1, 10)} <= {*seen}

    def test_an_overlong_line_is_dropped_and_the_rest_read(self, here, monkeypatch):
        Path("gaitsim.py").write_text("print('x' * 3_000_000); print('end')")
        monkeypatch.setenv("PYTHONPATH", str(here))
        task, _ = run("video", "x")
        assert (task.state, task.output[-1]) == ("done", "end")

    def test_stopping_sends_sigint(self, here, monkeypatch):
        Path("gaitsim.py").write_text(
            "import time\n"
            "try:\n"
            "    print('begun', flush=True)\n"
            "    time.sleep(60)\n"
            "except KeyboardInterrupt:\n"
            "    print('mopped up', flush=True)\n"
            "    raise SystemExit(130)\n"
        )
        monkeypatch.setenv("PYTHONPATH", str(here))

        async def during(tasks, task):
            while not task.output:
                await asyncio.sleep(0.01)
            tasks.stop(task)

        task, _ = run("video", "x", during=during)
        assert (task.state, task.output[-1]) == ("stopped", "mopped up")

    def test_a_task_that_ignores_sigint_is_killed(self, here, monkeypatch):
        Path("gaitsim.py").write_text(
            "import signal, time\n"
            "signal.signal(signal.SIGINT, signal.SIG_IGN)\n"
            "print('begun', flush=True)\n"
            "time.sleep(60)\n"
        )
        monkeypatch.setenv("PYTHONPATH", str(here))
        monkeypatch.setattr("gaitsim.tui.tasks.GRACE", 0.1)

        async def during(tasks, task):
            while not task.output:
                await asyncio.sleep(0.01)
            await tasks.stop_all()

        assert run("video", "x", during=during)[0].state == "stopped"


class TestOpener:
    @pytest.mark.parametrize(
        ("name", "code", "opened"),
        [
            *(("a b.png", 0, True), ("a.png", 4, False)),
            *(("a.desktop", 0, False), ("gone.png", None, False)),
        ],
    )
    def test_data_and_pictures_are_opened_with_the_systems_program(
        self, name, code, opened, here, monkeypatch
    ):
        program = here / "xdg-open"
        program.write_text(f'#!/bin/sh\nprintf %s "$1" > {here}/got\nexit {code}\n')
        program.chmod(0o755)
        monkeypatch.setenv("PATH", str(here), prepend=os.pathsep)
        monkeypatch.setenv("DISPLAY", ":9")
        monkeypatch.setattr(sys, "platform", "linux")
        if code is not None:
            Path(name).touch()
        assert asyncio.run(open_file(Path(name))) is opened
        assert not opened or Path("got").read_text() == str(here / name)

    def test_without_a_display_nothing_is_started(self, here, monkeypatch):
        monkeypatch.delenv("DISPLAY", raising=False)
        monkeypatch.delenv("WAYLAND_DISPLAY", raising=False)
        monkeypatch.setattr(sys, "platform", "linux")
        Path("a.png").touch()
        assert not asyncio.run(open_file(Path("a.png")))


def highlight(dialog, words):
    """Highlight the product whose command ends with words."""
    menu, forms = dialog.query_one("#products"), every_form()
    at = next(n for n, one in enumerate(forms) if " ".join(one.command).endswith(words))
    menu.highlighted = menu.get_option_index(str(at))


class TestExports:
    @pytest.mark.packages
    def test_options_become_arguments_and_invalid_ones_are_rejected(self):
        run, forms = (
            Path("runs/a b"),
            {form.title: form for form in every_form()},
        )
        for title, texts, words in (
            ("Video", {"damage": "L2 lost, R1 femur stuck 20", "world": "friction 0.4"},
             "video 'runs/a b' '--damage=L2 lost' '--damage=R1 femur stuck 20' "
             "'--world=friction 0.4'"),
            ("Servo keyframes", {"clip": "true", "min": "-30", "generation": " 3 "},
             "export 'runs/a b' --format servo --clip --min -30 --generation 3"),
            ("Feetech positions", {"calibration_template": "feetech.toml"},
             "export 'runs/a b' --format feetech "
             "--calibration-template 'runs/a b/exports/feetech.toml'"),
            ("Video", {"intro": "false", "generations": "1,50", "size": "none"},
             "video 'runs/a b' --no-intro --generations 1,50"),
            ("Channel of the motion", {"components": "x, L1 coxa", "window": "2:5"},
             "plot 'runs/a b' --kind channel --component=x '--component=L1 coxa' --window 2:5"),
            ("Archive map", {"axes": " duty factor,yaw"},
             "plot 'runs/a b' --kind archive --axes 'duty factor' yaw"),
            ("Analysis", {"figure": "gait.pdf", "generation": "4"},
             "analyse 'runs/a b' --figure 'runs/a b/exports/gait.pdf' --generation 4"),
            ("Imitation network", {"run": "best gait.mat", "epochs": "9"},
             "imitate 'best gait.mat' --epochs 9"),
            ("Run differences", {"runs": "c 'runs/d e'", "by": "seconds"},
             "differences 'runs/a b' c 'runs/d e' --by seconds"),
        ):  # fmt: skip
            arguments, problems = forms[title].read(run, texts)
            assert not problems
            assert shlex.join(arguments) == words
        for title, name, text in (
            *(("Video", "generation", text) for text in ("0", "x", "1.5")),
            ("Video", "view", "below"), ("Archive map", "axes", "yaw"),
            ("Imitation network", "epochs", "-1"),
            ("Run differences", "runs", ""),
        ):  # fmt: skip
            arguments, problems = forms[title].read(run, {name: text})
            assert arguments == ()
            assert problems.keys() == {name}

    @pytest.mark.packages
    @pytest.mark.parametrize("angles", [True, False])
    def test_unsupported_products_are_found_by_the_checks_of_the_commands(
        self, angles, walk, puppets, gaitsim, monkeypatch
    ):
        run = walk()
        if not angles:
            monkeypatch.setattr(puppets.Reach, "needs", ("reach",))
            monkeypatch.setattr(puppets.Puppet, "channels", {"reach": Channel((), "m", "")})
        found = unavailable_products(run, every_form())
        for product in found:
            arguments = product.read(run, {})[0]
            assert found[product].what in gaitsim(*arguments, code=2).stderr
        verbs = {product.command[0] for product in found}
        assert verbs == {"plot", "export", *(() if angles else ("imitate",))}  # no archive

    @pytest.mark.slow
    async def test_the_form_runs_its_command_and_opens_the_file(self, walk, drive, monkeypatch):
        path = walk("two words")
        monkeypatch.setattr("gaitsim.tui.opener.opener", lambda: ())
        async with drive() as driver:
            assert "app.tasks" not in driver.offered()
            driver.screen.ask_export(RunChoice(path, 2))
            dialog = await driver.at("ExportDialog")
            await driver.until(lambda: dialog.query(Field))
            highlight(dialog, "--format csv")
            await driver.until(lambda: "csv" in driver.text("#export-command"))
            line = driver.text("#export-command")
            assert line == "$ gaitsim export 'runs/two words' --format csv --generation 2"
            await driver.press("tab", "x")
            await driver.until(lambda: not driver.text("#export-command"))
            assert dialog.query_one("#make").disabled
            await driver.press("ctrl+u", "2", "enter")
            await driver.at("Home")
            await driver.until(lambda: list((path / "exports").glob("*.csv")))
            await driver.until(lambda: driver.app.tasks.all[0].state == "done")
            assert "Done" in driver.notifications()
            await driver.press("t")
            await driver.at("TaskList")
            [file] = (path / "exports").glob("*.csv")
            assert str(file.absolute()) in driver.text("#task-text")
            await driver.press("p")
            assert driver.app.clipboard == str(file.absolute())
            await driver.press("y")
            assert driver.app.clipboard == line[2:]
            assert "tasks.stop" not in driver.offered()
            await driver.press("enter")
            await driver.until(lambda: "No program to open the file" in driver.notifications())
            assert driver.app.clipboard == str(file.absolute())
            with monkeypatch.context() as browser:
                sent = []
                browser.setattr(type(driver.app), "is_web", True)
                browser.setattr(driver.app, "deliver_binary", lambda path, **_: sent.append(path))
                await driver.press("enter")
                await driver.until(lambda: sent)
                assert sent[0].absolute() == file.absolute()
            await driver.press("c")
            assert driver.screen.query_one("#tasks").row_count == 0
            assert not driver.offered() & {"tasks.clear", "tasks.again", "files.open"}

    @pytest.mark.slow
    async def test_a_real_robot_takes_the_terminal_and_is_remembered(
        self, walk, drive, monkeypatch
    ):
        path, started = walk(), []
        monkeypatch.setattr(
            "gaitsim.tui.screens.export_dialog.unavailable_products", lambda run, forms: {}
        )
        monkeypatch.setattr("subprocess.run", lambda words, check: started.append(words[3:]))
        monkeypatch.setattr("builtins.input", lambda text: "")
        line = f"gaitsim drive {path} --port port --calibration r.toml"
        async with drive() as driver:

            async def start(*typed):
                await driver.press("W")
                dialog = await driver.at("ExportDialog")
                await driver.until(lambda: dialog.query(Field))
                assert dialog.query_one("#products").option_count == 3
                for text in typed:
                    await driver.press("tab")
                    await driver.type(text)
                await driver.until(lambda: line in driver.text("#export-command"))
                await driver.press("enter")
                await driver.at("Home")

            await start("port", "r.toml")
            await driver.until(lambda: "needs a terminal, not a brow" in driver.notifications())
            monkeypatch.setattr(driver.app, "suspend", nullcontext)
            await start("", "")
            await driver.until(lambda: started)
        assert [shlex.join(words) for words in started] == [line.removeprefix("gaitsim ")]

    async def test_a_page_is_opened_once_it_is_written(self, here, drive, monkeypatch):
        monkeypatch.setattr("gaitsim.tui.opener.opener", lambda: ())
        page = here / "page.html"
        page.write_text("<p>")
        async with drive() as driver:
            task = Task(("export",), state="done", files=[page], opens=True)
            driver.app._task_changed(task)
            await driver.until(lambda: "No program to open the file" in driver.notifications())
            monkeypatch.setattr("gaitsim.tui.opener.opener", lambda: ("true",))
            await open_or_copy(driver.app, page)  # a page that came with a run
            await driver.until(lambda: "may contain untrusted scripts" in driver.notifications())
            assert "Opened" not in driver.notifications()
            assert driver.app.clipboard == str(page.absolute())
            shown = []
            monkeypatch.setattr(type(driver.app), "is_web", True)
            driver.app._driver.show_page = shown.append
            driver.app._task_changed(task)
            await driver.until(lambda: shown == [page])

    async def test_the_files_of_a_run_are_listed_without_links(self, walk, drive):
        path = walk()
        file = path / "exports" / "gait.csv"
        file.write_text("time_s")
        (path / "exports" / "linked.csv").symlink_to("/etc/passwd")
        async with drive() as driver:
            driver.screen.ask_export(RunChoice(path))
            await driver.at("ExportDialog")
            await driver.pilot.click("#show-files")
            screen = await driver.at("Files")
            await driver.until(lambda: driver.text("#file-path") == str(file.absolute()))
            assert screen.query_one("#files").row_count == 1
            file.unlink()
            await driver.press("enter")
            await driver.until(lambda: "file not found" in driver.notifications())
            await driver.press("e")
            await driver.at("ExportDialog")
            await driver.press("escape")
            await driver.at("Files")
            assert "files.open" not in driver.offered()

    async def test_a_task_can_be_repeated(self, here, drive, monkeypatch):
        Path("gaitsim.py").write_text("raise SystemExit('no [b]luck')")
        monkeypatch.setenv("PYTHONPATH", str(here))
        async with drive() as driver:
            driver.app.start_task(["analyse", "x"])
            driver.app.action_tasks()
            await driver.at("TaskList")
            await driver.until(lambda: driver.app.tasks.all[0].state == "failed")
            await driver.until(lambda: "no [b]luck" in driver.text("#task-text"))
            await driver.until(lambda: "tasks.again" in driver.offered())
            await driver.press("r")
            await driver.until(lambda: len(driver.app.tasks.all) == 2)
            await driver.until(lambda: driver.app.tasks.all[1].state == "failed")
            assert driver.app.tasks.all[1].arguments == ("analyse", "x")

    async def test_quitting_asks_and_stops_running_tasks(self, here, drive, monkeypatch):
        Path("gaitsim.py").write_text("import time; print('begun', flush=True); time.sleep(60)")
        monkeypatch.setenv("PYTHONPATH", str(here))
        async with drive() as driver:
            driver.app.start_task(["video", "x"])
            task = driver.app.tasks.all[0]
            await driver.until(lambda: task.output)
            await driver.press("q")
            await driver.at("Confirm")
            await driver.press("n")
            await driver.at("Home")
            assert task.running
            await driver.press("t")
            await driver.at("TaskList")
            assert isinstance(driver.screen, TaskList)
            await driver.press("x")
            await driver.until(lambda: task.state == "stopped" and task.ended)
            driver.app.start_task(["video", "y"])
            other = driver.app.tasks.all[1]
            await driver.until(lambda: other.output)
            await driver.press("q")
            await driver.at("Confirm")
            await driver.press("y")
            await driver.until(lambda: not driver.app.is_running)
            assert (other.state, other.ended is not None) == ("stopped", True)
