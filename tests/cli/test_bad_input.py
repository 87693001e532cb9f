"""Any mistake of a user ends with one clear message on standard error and exit code 2."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

from gaitsim import cli
from gaitsim.registry.loading import read_preset

SPIDER = read_preset("spider")


@pytest.fixture
def gaitsim(monkeypatch, capsys, tmp_path):
    """Return a function that runs a command in an empty folder."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("COLUMNS", "80")

    def run(*arguments):
        monkeypatch.setattr(sys, "argv", ["gaitsim", *map(str, arguments)])
        with pytest.raises(SystemExit) as raised:
            cli.main()
        captured = capsys.readouterr()
        return raised.value.code or 0, captured.out, captured.err

    return run


@pytest.fixture
def error_of(gaitsim):
    """Return a function that runs an invalid command and returns the message."""

    def run(*arguments):
        code, out, message = gaitsim(*arguments)
        assert (code, out) == (2, ""), message
        assert "Traceback" not in message
        assert "Error" in message
        return message

    return run


def shell(*arguments, path=None, **settings):
    environment = {**os.environ, "COLUMNS": "80", **settings.pop("env", {})}
    if path:
        environment["PYTHONPATH"] = str(path)
    return subprocess.run(
        [sys.executable, "-m", "gaitsim", *arguments],
        capture_output=True,
        text=True,
        encoding="utf-8",
        env=environment,
        check=False,
        **settings,
    )


@pytest.mark.parametrize("command", ["run", "experiments show"])
def test_an_unknown_experiment_is_reported_with_a_suggestion(error_of, command):
    message = error_of(*command.split(), "spidr")
    assert message.startswith("Error: unknown experiment 'spidr'\n")
    assert "  allowed: " in message
    assert "  try:     did you mean 'spider'?" in message
    Path("spidr").write_text(SPIDER)
    assert "for the file of that name, use ./spidr" in error_of(*command.split(), "spidr")


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["bogus"], "No such command 'bogus'"),
        (["run"], "no experiment is given"),
        (["run", "spider", "--nope"], "No such option: --nope"),
        (["plugins", "show", "spidr"], "did you mean 'spider'?"),
        (["run", "\x1b[31mred.toml"], "\\x1b[31mred.toml"),
        (["run", "\udcff.toml"], "\\udcff.toml"),
    ],
)
def test_an_invalid_command_line_is_rejected(error_of, arguments, message):
    assert message in error_of(*arguments)


@pytest.mark.parametrize(
    ("arguments", "what", "allowed"),
    [
        ("run spider --generations abc", "invalid --generations: 'abc'", "a whole number"),
        ("run spider --workers 0", "invalid --workers: '0'", "a whole number ≥ 1 and ≤ 1,024"),
        ("export R --centre x", "invalid --centre: 'x'", "a number ≥ -36,000 and ≤ 36,000"),
        ("video R --view left", "invalid --view: 'left'", "iso, side, top, orbit"),
    ],
)
def test_an_invalid_value_is_reported_with_the_allowed_ones(error_of, arguments, what, allowed):
    option = arguments.split()[-2]
    assert error_of(*arguments.split()).splitlines() == [
        f"Error: {what}",
        f"  where:   {option}",
        f"  allowed: {allowed}",
    ]


def test_the_output_of_show_can_be_run(gaitsim):
    code, text, message = gaitsim("experiments", "show", "spider")
    assert (code, message) == (0, "")
    Path("mine.toml").write_text(text)
    assert gaitsim("experiments", "show", "mine.toml") == (0, text, "")


def test_damaged_entry_points_are_a_warning(gaitsim, install):
    install("fake", files={"fake-1.0.dist-info/entry_points.txt": b"[gaitsim.organism]\n\xe9=x\n"})
    code, out, message = gaitsim("plugins", "list")
    assert code == 0
    assert "spider-walk" in out
    assert "entry points of fake in" in message


def test_a_broken_preset_is_listed_as_broken(gaitsim, install):
    points = "[gaitsim.experiments]\nhop = fake\nskip = nowhere\n"
    files = {
        "fake/__init__.py": "raise SystemExit",
        "fake/hop.toml": "a = " + "[" * 5000,
        "fake-1.0.dist-info/entry_points.txt": points,
    }
    install("fake", files=files)
    code, out, message = gaitsim("experiments", "list")
    assert (code, message) == (0, "")
    lines = {line.split()[0]: line for line in out.splitlines()}
    assert "broken: tables or lists are nested too deeply" in lines["hop"]
    assert "broken: " in lines["skip"]
    assert "a spider" in lines["spider"]


# In a shell


@pytest.mark.sampled
@pytest.mark.skipif(sys.platform == "win32", reason="needs a shell with pipes")
@pytest.mark.parametrize("command", ["experiments list", "experiments show spider", "plugins list"])
def test_a_closed_pipe_is_not_an_error(tmp_path, command):
    line = f"{sys.executable} -m gaitsim {command} | head -n 1"
    done = subprocess.run(
        line, shell=True, capture_output=True, text=True, cwd=tmp_path, check=False
    )
    assert done.stdout.count("\n") == 1
    assert done.stderr == ""
    closed = f"{sys.executable} -m gaitsim {command} | true"
    done = subprocess.run(closed, shell=True, capture_output=True, cwd=tmp_path, check=False)
    assert done.stderr == b""


@pytest.mark.sampled
@pytest.mark.skipif(not Path("/dev/full").exists(), reason="needs /dev/full")
@pytest.mark.parametrize("command", ["experiments list", "experiments show spider"])
def test_a_full_disk_is_reported(tmp_path, command):
    with Path("/dev/full").open("w") as full:
        done = subprocess.run(
            [sys.executable, "-m", "gaitsim", *command.split()],
            stdout=full,
            stderr=subprocess.PIPE,
            text=True,
            cwd=tmp_path,
            check=False,
        )
    assert done.returncode == 2
    assert done.stderr.count("\n") == 1
    assert "No space left on device" in done.stderr


@pytest.mark.slow
def test_colours_are_used_only_in_a_terminal_that_supports_them(tmp_path):
    def message(**env):
        return shell("run", "spidr", cwd=tmp_path, env=env).stderr

    assert "\x1b[31m" in message(FORCE_COLOR="1", TERM="xterm")
    assert "\x1b[" not in message(TERM="xterm")
    assert "\x1b[3" not in message(FORCE_COLOR="1", NO_COLOR="1", TERM="xterm")
