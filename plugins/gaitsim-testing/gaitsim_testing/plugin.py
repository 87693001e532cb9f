"""The pytest plugin: `pytest --gaitsim NAME` also checks plugins against their contracts.

Nothing else of gaitsim is imported until plugins are checked.
"""

import json
import sys
from collections.abc import Generator
from contextlib import ExitStack
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pytest

if TYPE_CHECKING:
    from gaitsim.plugin import Entry

_NAME = "gaitsim"
_CHECKS = Path(__file__).parent / "checks"


def pytest_addoption(parser: pytest.Parser) -> None:
    """Declare the options that name the plugins to check."""
    group = parser.getgroup(_NAME, "gaitsim: the contracts of plugins")
    what = "plugins to check: the name of a plugin or package, or the folder of a package"
    group.addoption("--gaitsim", action="append", default=[], metavar="NAME", help=what)
    group.addoption("--gaitsim-options", default="{}", metavar="JSON", help="options of plugins")
    parser.addini(_NAME, f"{what}; folders are relative to this file", "args", default=[])


def pytest_configure(config: pytest.Config) -> None:
    """Add the checks to the tests if any plugins are to be checked."""
    folder = config.inipath.parent if config.inipath else Path()
    named = config.getoption("gaitsim") or [
        folder / name if name.startswith(".") else name for name in config.getini(_NAME)
    ]
    if named and not config.getoption("collectonly"):
        config.pluginmanager.register(Checks(config, named), "gaitsim-checks")


class Checks:
    """The checks in one session of pytest.

    Args:
        config: configuration of the session.
        named: references to the plugins.
    """

    def __init__(self, config: pytest.Config, named: "list[str | Path]") -> None:
        from gaitsim.plugin import GaitsimError
        from gaitsim_testing.packages import MODULES, select_plugins

        self.options: dict[str, Any] = json.loads(config.getoption("gaitsim_options"))
        self._open = ExitStack()
        self._unusable: set[Entry] = set()
        self._reported: set[tuple[Entry, str]] = set()
        self._advised: set[tuple[Entry, str]] = set()
        self.entries: list[Entry] = []
        try:
            for reference in named:
                found = self._open.enter_context(select_plugins(reference))
                sys.path[:0] = [one for one in found.path if one not in sys.path]
                self.entries += found.entries
        except GaitsimError as error:
            self._open.close()
            raise pytest.UsageError(str(error)) from None
        kinds = {entry.kind for entry in self.entries}
        self._files = [
            str(_CHECKS / f"test_{name}.py") for name, of in MODULES.items() if kinds & {*of}
        ]
        config.args += self._files

    def pytest_unconfigure(self) -> None:
        """Remove the temporary metadata of packages that are not installed."""
        self._open.close()

    @pytest.hookimpl(tryfirst=True)
    def pytest_generate_tests(self, metafunc: pytest.Metafunc) -> None:
        """Repeat each check for every plugin of its kind."""
        if "entry" in metafunc.fixturenames:
            entries = [entry for entry in self.entries if entry.kind in metafunc.module.KINDS]
            names = [f"{entry.kind}-{entry.name}" for entry in entries]
            metafunc.parametrize("entry", entries, ids=names, scope="session")

    @pytest.hookimpl(trylast=True)
    def pytest_collection_modifyitems(self, items: list[pytest.Item]) -> None:
        """Check one plugin after the other, each by the modules in order."""
        others = [item for item in items if _entry(item) is None]
        checks = [item for item in items if _entry(item) is not None]
        places = {entry: place for place, entry in enumerate(self.entries)}
        files = {file: place for place, file in enumerate(self._files)}

        def key(item: Any) -> tuple[int, ...]:
            line = item.function.__code__.co_firstlineno
            return places[item.callspec.params["entry"]], files[str(item.path)], line

        items[:] = others + sorted(checks, key=key)

    def pytest_runtest_setup(self, item: pytest.Item) -> None:
        """Skip what cannot be checked, and more cases of a rule that is known to be broken."""
        entry = _entry(item)
        if entry in self._unusable or (entry, _rule(item)) in self._reported:
            pytest.skip("an earlier check of the plugin failed")

    def has_failed(self, entry: "Entry") -> bool:
        """Return whether a check of a plugin has failed."""
        return any(entry == reported for reported, _ in self._reported)

    @pytest.hookimpl(wrapper=True)
    def pytest_runtest_makereport(
        self, item: pytest.Item, call: pytest.CallInfo[None]
    ) -> Generator[None, Any, Any]:
        """Attach what was found to the report, and shorten the message of a broken rule."""
        report = yield
        if (entry := _entry(item)) is None:
            return report
        from gaitsim.plugin import GaitsimError
        from gaitsim_testing.finding import explain, note_output, taken

        if report.capstdout and (entry, "output") not in self._advised:
            self._advised.add((entry, "output"))
            note_output(report.capstdout)
        properties = item.user_properties
        if call.when == "setup":
            properties += [(part, getattr(entry, part)) for part in ("kind", "name", "package")]
        for text in taken:
            if (entry, text) not in self._advised:
                self._advised.add((entry, text))
                properties.append(("advice", text))
        taken.clear()
        if report.failed and call.excinfo is not None:
            error = call.excinfo.value
            text = explain(entry, error)
            if timeout := isinstance(error, pytest.fail.Exception):
                fix = "look for an endless loop in this step, or increase --seconds"
                text = str(GaitsimError(f"the time limit is exceeded: {error}", remedy=fix))
            if isinstance(error, GaitsimError):
                report.longrepr = text
            rule = _rule(item) if call.when != "teardown" else "randomness"
            if (entry, rule) not in self._reported:
                properties.append(("broken", f"{rule}: {text}"))
            self._reported.add((entry, rule))
            if timeout or call.when == "setup" or rule in ("declarations", "options"):
                self._unusable.add(entry)
        report.user_properties = list(properties)
        return report


def _entry(item: pytest.Item) -> "Entry | None":
    """Return the plugin that a test checks; None for a test of another package."""
    found = getattr(item, "callspec", None) if item.path.parent == _CHECKS else None
    return found and found.params.get("entry")


def _rule(item: pytest.Item) -> str:
    """Return the name of the rule that a test checks."""
    return item.name.partition("[")[0].removeprefix("test_").replace("_", " ")
