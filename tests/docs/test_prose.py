"""Texts contain none of the constructions listed in prose.toml."""

import re
import tomllib
from collections.abc import Iterator
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
HABITS = tomllib.loads(Path(__file__).with_name("prose.toml").read_text(encoding="utf-8"))
FOLDERS = ("docs", "gaitsim", "plugins", "docs_build", "benchmarks", "viewer_build", "tests")
SUFFIXES = {".css", ".html", ".ino", ".js", ".md", ".mjs", ".py", ".tcss", ".toml", ".txt"}
SKIPPED = {"three.min.js", "dictionary-1.txt", "prose.toml", "test_prose.py", "run-format-1"}
"""A library, the bytes of a code's compression, this check, and a run from an older version."""

_BREAK = re.compile(
    r"[ \t]*(?<!\")\"?[ \t]*\n[ \t]*(?:(?:#|//|\*|>)[ \t]+|f?\"(?!\"))?(?=\w)|[ \t]+"
)
"""The end of a line within prose, a comment or a text of several literals; not of a paragraph."""


def files() -> Iterator[Path]:
    yield from ROOT.glob("*.md")
    for folder in FOLDERS:
        for path in sorted((ROOT / folder).rglob("*")):
            skipped = {"node_modules", "__pycache__", *SKIPPED} & {*path.parts}
            if path.suffix in SUFFIXES and not skipped:
                yield path


def unwrapped(text: str) -> str:
    """A text with each paragraph on one line."""
    return _BREAK.sub(" ", text)


@pytest.fixture(scope="module")
def texts() -> dict[Path, str]:
    return {path.relative_to(ROOT): unwrapped(path.read_text("utf-8")) for path in files()}


def found(texts: dict[Path, str], pattern: str) -> list[str]:
    """Return the matches of a pattern, with the words around them."""
    expression = re.compile(pattern, re.IGNORECASE)
    return [
        f"{path}: …{text[max(match.start() - 40, 0) : match.end() + 40]}…"
        for path, text in texts.items()
        for match in expression.finditer(text)
    ]


@pytest.mark.slow  # 3 s in all
@pytest.mark.parametrize("name", HABITS)
def test_no_text_has_the_habit(texts: dict[Path, str], name: str) -> None:
    habit = HABITS[name]
    matches = found(texts, habit["pattern"])
    assert not matches, "\n".join([f"'{name}'; write: {habit['instead']}", *matches])


def test_a_sentence_over_several_lines_is_found() -> None:
    text = '# It is\n#   told here.\nf(\n    "it is "\n    "told once"\n)\nIt is\ntold.\n'
    assert len(found({Path(): unwrapped(text)}, r"\bis told\b")) == 3
