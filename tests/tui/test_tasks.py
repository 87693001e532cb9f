"""What is made in the background: as the command line makes it, with progress, stopped, failed."""

import asyncio
import os
import sys
from pathlib import Path

import pytest

from gaitsim.tui.screens.export_dialog import PRODUCTS
from gaitsim.tui.screens.tasks import TaskList
from gaitsim.tui.tasks import Task, Tasks, clean, part_of

pytestmark = pytest.mark.skipif(os.name == "nt", reason="needs a pseudo-terminal")


class TestProgress:
    @pytest.mark.parametrize(
        ("line", "part"),
        [
            ("gait.mp4 ━━━━╸ 150/300 pictures, left 0:00:12", 0.5),
            ("1,200/2,400 epochs", 0.5),
            ("3 / 12 cells", 0.25),
            ("42% done", 0.42),
            ("400%", 1.0),
            ("0/0", None),
            ("Preparing spider …", None),
        ],
    )
    def test_a_line_says_how_far(self, line, part):
        assert part_of(line) == part

    def test_what_steers_a_terminal_is_dropped(self):
        text = "\x1b[2K\x1b[1;31mred\x1b[0m\x1b]0;title\x07 and\x1b]8;;x\x1b\\ link\x00\x9b\r\n"
        assert clean(text) == "red and link\r\n"

    def test_progress_is_not_kept_as_what_was_said(self):
        task = Task(("video", "x"))
        task.take_progress("Warning: [b]odd[/b]\n1/10\r\x1b[2K5/10\r")
        assert (task.part, task.progress) == (0.5, "5/10")
        assert task.errors == ["Warning: [b]odd[/b]"]


@pytest.mark.parametrize(
    ("line", "path"),
    [
        ("a: b.csv: 30 frames", "a: b.csv"),
        ("a: b.csv", "a: b.csv"),
        ("gone.csv: 30 frames", None),
        ("folder: 3 files", None),
        ("• constant", None),
        ("", None),
        ("a" * 5000, None),
    ],
)
def test_the_file_that_was_made(here, line, path):
    Path("a: b.csv").touch()
    Path("folder").mkdir()
    assert Task(("export", "x"), output=[line]).file == (path and Path(path))


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
            while task.running or tasks._running:
                await asyncio.sleep(0.01)
        return task

    return asyncio.run(go()), seen


class TestTask:
    def test_one_that_comes_to_its_end(self, walk):
        task, seen = run("export", str(walk()), "--format", "csv")
        assert (task.state, seen[0][0], seen[-1][0]) == ("done", "running", "done")
        assert Path(task.result.partition(": ")[0]).is_file()
        assert not task.errors

    def test_one_that_fails_says_why(self, here):
        task, _ = run("export", "nowhere [b]")
        assert task.state == "failed"
        assert "there is no run 'nowhere [b]'" in task.message

    def test_its_errors_go_to_a_terminal_so_that_progress_is_drawn(self, here, monkeypatch):
        # A program in gaitsim's place that draws as it does.
        Path("gaitsim.py").write_text(
            "import sys\n"
            "assert sys.stderr.isatty() and not sys.stdout.isatty()\n"
            "for n in range(1, 11):\n"
            "    print(f'\\r\\x1b[2K{n}/10 pictures', end='', file=sys.stderr, flush=True)\n"
            "print('film.mp4: fine')\n"
        )
        monkeypatch.setenv("PYTHONPATH", str(here))
        task, seen = run("video", "x")
        assert (task.state, task.part, task.result) == ("done", 1.0, "film.mp4: fine")
        assert task.errors == []
        assert (("running", 1.0) in seen) or (("done", 1.0) in seen)

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
        assert (task.state, task.result) == ("stopped", "mopped up")

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
        for product in PRODUCTS:
            shown = gaitsim(product.verb, "--help").stdout
            for name in product.more:
                if name.startswith("--"):
                    assert name in shown
        assert path.exists()

    def test_a_gait_file_is_made_and_its_path_told(self, walk, drive):
        path = walk("two words")

        async def test(driver):
            assert "app.tasks" not in driver.offered()
            await driver.press("e")
            screen = await driver.at("Making")
            await driver.press("down")
            line = str(screen.query_one("#making-command").render())
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
