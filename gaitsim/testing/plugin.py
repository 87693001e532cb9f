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
    from gaitsim.registry import Entry

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
        from gaitsim.errors import GaitsimError
        from gaitsim.testing.packages import KINDS, select_plugins

        self.options = json.loads(config.getoption("gaitsim_options"))
        self._open = ExitStack()
        self._unusable: set[Entry] = set()
        self._printed: set[Entry] = set()
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
        config.args += [
            str(_CHECKS / f"test_{name}.py") for name, of in KINDS.items() if kinds & {*of}
        ]

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

    def pytest_runtest_setup(self, item: pytest.Item) -> None:
        """Skip what cannot be checked, as an earlier check of the plugin failed or timed out."""
        if _entry(item) in self._unusable:
            pytest.skip("an earlier check of the plugin failed")

    @pytest.hookimpl(wrapper=True)
    def pytest_runtest_makereport(
        self, item: pytest.Item, call: pytest.CallInfo[None]
    ) -> Generator[None, Any, Any]:
        """Attach what was found to the report, and shorten the message of a broken rule."""
        report = yield
        if (entry := _entry(item)) is None:
            return report
        from gaitsim.errors import GaitsimError
        from gaitsim.testing.finding import explain, taken

        properties = item.user_properties
        if call.when == "setup":
            properties += [(part, getattr(entry, part)) for part in ("kind", "name", "package")]
        properties += [("advice", text) for text in taken]
        taken.clear()
        if report.capstdout and entry not in self._printed:
            self._printed.add(entry)
            what = f"prints {report.capstdout[:200]!r}"
            allowed = "no standard output, because it is reserved for results, such as JSON"
            fix = "use the module logging, or print(…, file=sys.stderr)"
            properties.append(("advice", str(GaitsimError(what, allowed=allowed, remedy=fix))))
        if report.failed and call.excinfo is not None:
            error = call.excinfo.value
            timeout = isinstance(error, pytest.fail.Exception)
            text = explain(entry, error)
            if timeout:
                fix = "look for an endless loop in this step, or increase --seconds"
                text = str(GaitsimError(f"the time limit is exceeded: {error}", remedy=fix))
            name = item.name.partition("[")[0].removeprefix("test_").replace("_", " ")
            properties.append(("broken", f"{name}: {text}"))
            if isinstance(error, GaitsimError):
                report.longrepr = text
            if timeout or call.when == "setup":
                self._unusable.add(entry)
        report.user_properties = list(properties)
        return report


def _entry(item: pytest.Item) -> "Entry | None":
    """Return the plugin that a test checks; None for a test of another package."""
    found = getattr(item, "callspec", None) if item.path.parent == _CHECKS else None
    return found and found.params.get("entry")  # type: ignore[no-any-return]
