"""What is made in the background: as the command line makes it, with progress, stopped, failed."""

import asyncio
import json
import os
import sys
from pathlib import Path

import pytest

from gaitsim.errors import ExperimentError, GaitsimError
from gaitsim.tui.screens.export_dialog import PRODUCTS
from gaitsim.tui.screens.tasks import TaskList
from gaitsim.tui.tasks import Task, Tasks

pytestmark = pytest.mark.skipif(os.name == "nt", reason="SIGINT stops a task")


class TestRecords:
    def task(self, *lines):
        task = Task(("video", "x"))
        for line in lines:
            task.take_record(line)
        return task

    @pytest.mark.parametrize(
        ("done", "total", "part"), [(150, 300, 0.5), (0, 7, 0.0), (9, 3, 1.0), (0, 0, None)]
    )
    def test_progress(self, done, total, part):
        line = json.dumps({"kind": "progress", "what": "a.mp4", "done": done, "total": total})
        task = self.task(line)
        assert (task.progress, task.part, task.notices) == ("a.mp4", part, [])

    def test_progress_towards_an_unknown_total(self):
        line = '{"kind": "progress", "what": "walker", "done": 0, "total": null}'
        assert self.task(line).part is None

    def test_files_are_collected_whatever_their_names(self):
        lines = [json.dumps({"kind": "result", "files": [name]}) for name in ("a: b.csv", "c d")]
        assert self.task(*lines).files == [Path("a: b.csv"), Path("c d")]

    def test_an_error_arrives_in_its_parts(self):
        problem = GaitsimError("unknown key", where="x.toml", key="mutation.rat", allowed="rate")
        task = self.task(json.dumps({"kind": "error", **ExperimentError([problem]).to_dict()}))
        assert isinstance(task.error, ExperimentError)
        assert task.error.problems[0].key == "mutation.rat"
        assert "unknown key" in task.message

    def test_notices_and_what_libraries_print_are_kept(self):
        task = self.task('{"kind": "notice", "text": "one\\ntwo"}', "Warning: [b]odd[/b]\x1b[2K")
        assert task.notices == ["one", "two", "Warning: [b]odd[/b]\\x1b[2K"]

    @pytest.mark.parametrize(
        "line",
        [
            *("7", "[]", "{", '{"kind": 1}', '{"kind": "progress"}'),
            *('{"kind": "error", "what": "half"}', '{"kind": "result", "files": [3]}'),
        ],
    )
    def test_a_line_that_is_no_record_is_shown_as_it_is(self, line):
        assert self.task(line).notices == [line]


def run(*arguments, during=None):
    """Run a command as a task; the task, and how it stood each time it changed."""
    seen = []

    async def go():
        tasks = Tasks(lambda task: seen.append((task.state, task.part)))
        task = tasks.begin(arguments)
        if during is not None:
            async with asyncio.timeout(60):
                await during(tasks, task)
        async with asyncio.timeout(60):
            await tasks.wait()
        return task

    return asyncio.run(go()), seen


class TestTask:
    def test_one_that_comes_to_its_end(self, walk):
        task, seen = run("export", str(walk()), "--format", "csv")
        assert (task.state, seen[0][0], seen[-1][0]) == ("done", "running", "done")
        [file] = task.files
        assert file.is_file()
        assert not task.notices

    def test_one_that_fails_says_why(self, here):
        task, _ = run("export", "nowhere [b]")
        assert task.state == "failed"
        assert "nowhere [b]" in task.error.what
        assert "gaitsim runs" in task.error.remedy

    def test_it_reports_its_progress_as_records(self, here, monkeypatch):
        # A program in gaitsim's place that reports as it does.
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
        assert (task.state, task.part, task.output) == ("done", 1.0, ["film.mp4: fine"])
        assert task.notices == []
        assert {("running", n / 10) for n in range(1, 10)} <= {*seen}

    def test_a_line_without_an_end_is_dropped_and_the_rest_read(self, here, monkeypatch):
        Path("gaitsim.py").write_text("print('x' * 3_000_000); print('end')")
        monkeypatch.setenv("PYTHONPATH", str(here))
        task, _ = run("video", "x")
        assert (task.state, task.output[-1]) == ("done", "end")

    def test_stopped_like_by_ctrl_c(self, here, monkeypatch):
        Path("gaitsim.py").write_text(
            "import time\n"
            "print('begun', flush=True)\n"
            "try:\n"
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

    def test_one_that_does_not_stop_is_ended(self, here, monkeypatch):
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

    def test_python_that_is_gone(self, here, monkeypatch):
        monkeypatch.setattr(sys, "executable", "/nowhere/python")
        task, _ = run("runs")
        assert task.state == "failed"
        assert "cannot start it" in task.message


class TestMaking:
    def test_each_product_is_a_command_that_there_is(self, walk, gaitsim):
        path = walk()
        for verb, *more in PRODUCTS.values():
            shown = gaitsim(verb, "--help").stdout
            for name in more:
                if name.startswith("--"):
                    assert name in shown
        assert path.exists()

    def test_a_gait_file_is_made_and_its_path_told(self, walk, drive):
        path = walk("two words")

        async def test(driver):
            assert "app.tasks" not in driver.offered()
            await driver.press("e")
            screen = await driver.at("ExportDialog")
            await driver.press("down")
            line = str(screen.query_one("#export-command").render())
            assert line == "$ gaitsim export 'runs/two words' --format csv"
            await driver.press("enter")
            await driver.at("Home")
            await driver.until(lambda: list((path / "exports").glob("*.csv")))
            await driver.until(lambda: driver.app.tasks.all[0].state == "done")
            assert "Done" in driver.told()
            await driver.press("t")
            await driver.at("TaskList")
            assert "runs/two words/exports/gait" in driver.text("#task-text")
            await driver.press("p")
            assert Path(driver.app.clipboard).is_file()
            await driver.press("y")
            assert driver.app.clipboard == line[2:]
            assert "tasks.stop" not in driver.offered()
            await driver.press("c")
            assert driver.screen.query_one("#tasks").row_count == 0
            assert "tasks.clear" not in driver.offered()

        drive(test)

    def test_what_makes_no_file_has_no_path_to_copy(self, here, drive, monkeypatch):
        Path("gaitsim.py").write_text("print('Terms:'); print('• constant')")
        monkeypatch.setenv("PYTHONPATH", str(here))

        async def test(driver):
            driver.app.begin_task(["analyse", "x"])
            driver.app.action_tasks()
            await driver.at("TaskList")
            await driver.until(lambda: driver.app.tasks.all[0].state == "done")
            await driver.until(lambda: "Done gaitsim analyse x" in driver.told(), 10)
            assert "• constant" in driver.text("#task-text")
            assert "tasks.copy" not in driver.offered()

        drive(test)

    def test_long_lines_and_commands_are_shown_whole(self, here, drive, monkeypatch):
        Path("gaitsim.py").write_text("print('word ' * 40 + 'end' + '/path' * 40)")
        monkeypatch.setenv("PYTHONPATH", str(here))

        async def test(driver):
            driver.app.begin_task(["export", "runs/" + "long-name-" * 12])
            driver.app.action_tasks()
            await driver.at("TaskList")
            await driver.until(lambda: driver.app.tasks.all[0].state == "done")
            await driver.pilot.pause()
            shown = driver.screen.query_one("#task-text")
            assert shown.region.right <= 80
            lines = [shown.render_line(row).text.rstrip() for row in range(shown.size.height)]
            assert "long-name-" * 12 in "".join(lines)
            assert "/path" * 40 in "".join(lines)

        drive(test)

    def test_what_fails_is_told_and_its_message_kept(self, here, drive):
        async def test(driver):
            driver.app.begin_task(["export", "no [b]where"])
            driver.app.action_tasks()
            await driver.at("TaskList")
            await driver.until(lambda: not driver.app.tasks.all[0].running)
            await driver.pilot.pause()
            assert "there is no run 'no [b]where'" in driver.text("#task-text")
            assert "there is no run 'no [b]where'" in driver.told()

        drive(test)

    def test_quitting_asks_and_stops_what_is_made(self, here, drive, monkeypatch):
        Path("gaitsim.py").write_text("import time; print('begun', flush=True); time.sleep(60)")
        monkeypatch.setenv("PYTHONPATH", str(here))

        async def test(driver):
            driver.app.begin_task(["video", "x"])
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
            driver.app.begin_task(["video", "y"])
            other = driver.app.tasks.all[1]
            await driver.until(lambda: other.output)
            await driver.press("q")
            await driver.at("Confirm")
            await driver.press("y")
            await driver.until(lambda: not driver.app.is_running)
            assert (other.state, other.ended is not None) == ("stopped", True)

        drive(test)
