"""Check plugins with pytest in other processes, which may hang or crash."""

import os
import signal
import subprocess
import sys
from collections.abc import Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from importlib.util import find_spec
from itertools import groupby
from pathlib import Path
from tempfile import TemporaryDirectory
from xml.etree import ElementTree

from gaitsim.plugin import Entry, GaitsimError
from gaitsim_testing.packages import PluginSelection

SECONDS = 120.0  # time limit of a check; compiling kernels takes 20 s, more on a busy machine
_START = 60.0  # time in which pytest starts and ends, s
_DAY = 86_400
_OK, _FAILED = 0, 1  # exit codes of pytest after all tests


@dataclass
class Checked:
    """The findings of the checks of a plugin.

    Attributes:
        entry: entry of the plugin, with its package.
        broken: messages about broken rules.
        advice: messages about possible improvements.
        rate: individuals per second; 0 if it was not measured.
    """

    entry: Entry
    broken: list[str] = field(default_factory=list)
    advice: list[str] = field(default_factory=list)
    rate: float = 0.0


def check_plugins(found: PluginSelection, *, seconds: float = SECONDS) -> Iterator[Checked]:
    """Check plugins, those of each kind together; yield the results as soon as they are ready.

    If the process of a kind ends early or hangs, each plugin of the kind is checked alone.

    Args:
        found: plugins to check.
        seconds: time limit of each check of a plugin, s.

    Raises:
        GaitsimError: pytest is not installed, or the time limit is invalid.
    """
    if not all(map(find_spec, ("pytest", "pytest_timeout"))):
        raise GaitsimError(
            "the check of plugins needs pytest and pytest-timeout, which are not installed",
            remedy="pip install 'gaitsim-testing'",
        )
    if not 0 < seconds <= _DAY:
        allowed = f"above 0 s and at most {_DAY:,} s"
        raise GaitsimError(f"invalid time limit: {seconds:g} s", allowed=allowed)
    for _, group in groupby(found.entries, lambda entry: entry.kind):
        yield from _check([*group], found.path, seconds)


def _check(entries: Sequence[Entry], path: Sequence[str], seconds: float) -> Iterator[Checked]:
    checked = [Checked(entry) for entry in entries]
    end = run_pytest(checked, path, seconds)
    if not end:
        yield from checked
    elif len(entries) > 1:
        for entry in entries:
            yield from _check([entry], path, seconds)
    else:
        allowed = "a check that finishes within the time limit"
        fix = "remove code that ends the process, and endless loops, from the plugin"
        checked[0].broken.append(str(GaitsimError(end, allowed=allowed, remedy=fix)))
        yield checked[0]


def run_pytest(checked: Sequence[Checked], path: Sequence[str], seconds: float) -> str:
    """Check plugins in one process, and add what it finds; return how it ended if it was early."""
    variables = {
        "PYTHONPATH": os.pathsep.join([*path, *filter(None, sys.path)]),
        "PYTHONHASHSEED": "1",
        "PYTEST_DISABLE_PLUGIN_AUTOLOAD": "1",
        "PYTEST_ADDOPTS": "",
    }
    with TemporaryDirectory(prefix="gaitsim-") as temporary:
        folder = Path(temporary)
        (folder / "pytest.ini").write_text("[pytest]\njunit_family = xunit1\n", encoding="utf-8")
        (output := folder / "output").touch()
        command = [sys.executable, "-P", "-m", "pytest", "--verbose", "--tb=no", "--no-header"]
        for plugin in ("gaitsim_testing.plugin", "pytest_timeout"):
            command += ["-p", plugin]
        command += [f"--confcutdir={Path(__file__).parent}"]  # not that of a source tree
        command += ["-p", "no:cacheprovider", "-c", "pytest.ini", "--basetemp=tmp"]
        command.append(f"--confcutdir={Path(__file__).parent}")
        command += ["--junit-xml=found.xml", f"--timeout={seconds}", "--timeout-method=signal"]
        command += [f"--gaitsim={one.entry.kind}:{one.entry.name}" for one in checked]
        with output.open("wb") as stream:
            process = subprocess.Popen(
                command,
                cwd=folder,
                env=os.environ | variables,
                stdin=subprocess.DEVNULL,
                stdout=stream,
                stderr=subprocess.STDOUT,
                start_new_session=True,  # Ctrl-C must not reach it
            )
            try:
                code: int | None = process.wait(_START + seconds * len(checked))
            except subprocess.TimeoutExpired:
                code = None
            finally:
                with suppress(ProcessLookupError):  # also processes that a plugin has started
                    os.killpg(process.pid, signal.SIGKILL)
                process.wait()
        if code not in (_OK, _FAILED):
            return _describe_end(code, output.read_text("utf-8", "replace"))
        _read(folder / "found.xml", checked)
    return ""


def _describe_end(code: int | None, output: str) -> str:
    """Describe how the process ended, with the check that it was in."""
    lines = output.rstrip("\n").split("\n")
    internal = [line for line in lines if line.startswith(("INTERNALERROR> ", "ERROR: "))]
    last = (internal or lines)[-1]
    place = f" in {last.rpartition('::')[2].partition('[')[0]}" if "::" in last else f": {last}"
    if code is None:
        return f"the time limit is exceeded{place}"
    how = f"killed by signal {-code}" if code < 0 else f"exit code {code}"
    return f"the process ended early, {how}{place}"


def _read(file: Path, checked: Sequence[Checked]) -> None:
    """Add the findings in a report of pytest, which `gaitsim_testing.plugin` wrote into it."""
    by_name: dict[tuple[str, ...], Checked] = {
        (one.entry.kind, one.entry.name, one.entry.package): one for one in checked
    }
    for case in ElementTree.parse(file).iter("testcase"):
        found = [(one.get("name"), one.get("value", "")) for one in case.iter("property")]
        values = dict(found)
        key = tuple(values.get(part, "") for part in ("kind", "name", "package"))
        if one := by_name.get(key):
            one.broken += [text for name, text in found if name == "broken"]
            one.advice += [text for name, text in found if name == "advice"]
            one.rate = float(values.get("rate", one.rate))
