"""The commands in the documentation work as printed, page by page and in each page's order."""

from collections.abc import Callable
from pathlib import Path
from types import SimpleNamespace

import pytest
from printed import Step, examples, parse, steps
from reader import FOUND, HELP, PAGES, does_all


def test_steps_are_found() -> None:
    page = (
        "`gaitsim tui`, `gaitsim play RUN`, `gaitsim run\n  a`\n```sh\npip x  # y\n\n"
        "gaitsim b \\\n  'c d'\n```\n```console\n$ gaitsim e\nout\n```\n```\nno\n```\n"
        '| `gaitsim note f` |\n```toml title="g.toml"\nh\n```\n'
    )
    lines = ["gaitsim run a", "pip x  # y", "gaitsim b 'c d'", "gaitsim e", "gaitsim note f"]
    assert list(steps(page)) == [*map(Step, lines), Step("h\n", "g.toml")]
    assert list(examples("[bold]Examples\n\n    gaitsim h\n    a | gaitsim -\n")) == [
        Step("gaitsim h"),
        Step("a | gaitsim -"),
    ]
    assert all(sum(len(FOUND.get(path, ())) for path in paths) > 90 for paths in (PAGES, HELP))


@pytest.mark.packages
@pytest.mark.parametrize("path", FOUND, ids=lambda path: Path(path).name)
def test_the_commands_of_a_page_parse(path: Path | str) -> None:
    for step in FOUND[path]:
        if not step.file:
            parse(step.text)


@pytest.mark.slow
@pytest.mark.parametrize(
    "path", [path for path in FOUND if path in PAGES], ids=lambda path: Path(path).name
)
def test_the_commands_of_a_page_run(
    path: Path, runs: Callable[[str], Path], tmp_path: Path, gaitsim: Callable[..., SimpleNamespace]
) -> None:
    does_all(path, tmp_path, runs, gaitsim)


@pytest.mark.slow
@pytest.mark.parametrize(
    "path", [path for path in FOUND if path in HELP], ids=lambda path: Path(path).name
)
def test_the_examples_of_a_command_run(
    path: str, runs: Callable[[str], Path], tmp_path: Path, gaitsim: Callable[..., SimpleNamespace]
) -> None:
    does_all(path, tmp_path, runs, gaitsim)
