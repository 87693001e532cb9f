"""The Python blocks of the documentation run as printed, page by page."""

import re
from collections.abc import Iterator
from dataclasses import dataclass
from importlib.util import find_spec
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
PAGES = [
    ROOT / "README.md",
    *sorted(
        (*ROOT.glob("docs/*.md"), *ROOT.glob("plugins/*/docs/*.md")), key=lambda page: page.name
    ),
]
NOT_RUN = "<!-- not run -->"
"""A comment before a block of Python that cannot run by itself, such as a part of a file."""

NUMBER = re.compile(r"-?\d+(\.\d+)?")


@dataclass(frozen=True)
class Block:
    """A Python block: its code, its first line on the page, and its expected output."""

    code: str
    line: int
    prints: str


def blocks(text: str) -> Iterator[Block]:
    """Yield the Python blocks of a page that the test runs."""
    fence = re.compile(r"^```(\w*)\n(.*?)^```$", re.DOTALL | re.MULTILINE)
    found = list(fence.finditer(text))
    for number, one in enumerate(found):
        before = text[: one.start()].rstrip()
        if one[1] != "python" or before.endswith(NOT_RUN):
            continue
        after = found[number + 1] if number + 1 < len(found) else None
        between = text[one.end() : after.start()].strip() if after else ""
        prints = after[2] if after and after[1] == "text" and between == "prints" else ""
        yield Block(one[2], text[: one.start()].count("\n") + 2, prints)


@pytest.fixture(scope="module")
def runs(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a folder with a run of the spider, which the pages assume."""
    import gaitsim as gs

    folder = tmp_path_factory.mktemp("docs")
    for _ in gs.evolve("spider", generations=4, population=40, out=folder / "runs" / "spider"):
        pass
    return folder


@pytest.mark.slow
@pytest.mark.parametrize(
    "page", [page for page in PAGES if any(blocks(page.read_text()))], ids=lambda page: page.name
)
def test_the_python_of_a_page_runs(
    page: Path, runs: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(runs)
    names: dict[str, object] = {"__name__": page.stem}
    for block in blocks(page.read_text()):
        if "pandas" in block.code and not find_spec("pandas"):
            continue
        # Line numbers in errors are those of the page.
        code = compile("\n" * (block.line - 1) + block.code, str(page), "exec")
        capsys.readouterr()
        exec(code, names)
        printed = capsys.readouterr().out
        if block.prints:
            # Last digits may differ on other processors.
            assert NUMBER.sub("#", printed) == NUMBER.sub("#", block.prints)


def test_blocks_are_found() -> None:
    page = (
        "```python\na\n```\n\nprints\n\n```text\n1\n```\n\n"
        f"{NOT_RUN}\n```python\nb\n```\n\n```sh\nc\n```\n\n```python\nd\n```\n"
    )
    assert list(blocks(page)) == [Block("a\n", 2, "1\n"), Block("d\n", 21, "")]


@pytest.mark.packages
def test_the_tests_of_the_security_promises_exist() -> None:
    named = re.findall(
        r"`((?:plugins/[\w-]+/)?tests/\S+?\.py)`", (ROOT / "SECURITY.md").read_text()
    )
    assert len(named) > 10
    assert [one for one in named if not (ROOT / one).is_file()] == []
