"""The plugin guide works as it stands: its files are written, its commands run, in its order."""

import re
from inspect import cleandoc
from pathlib import Path
from textwrap import dedent

import pytest
from environment import Environment

from gaitsim_testing.checking import check_plugins
from gaitsim_testing.packages import select_plugins

GUIDE = Path(__file__).parents[3] / "docs" / "plugins.md"
# A path in backticks at the end of a line, before a block, is the file that the block is.
BLOCK = re.compile(
    r"(?:`(?P<file>[\w./-]+)`:\n\n(?:<!-- not run -->\n)?)?"
    r"^```(?P<language>\w+)\n(?P<text>.*?)^```$",
    re.DOTALL | re.MULTILINE,
)


def steps():
    """Files to write and commands to run: what it is, and the text."""
    for block in BLOCK.finditer(GUIDE.read_text(encoding="utf-8")):
        if block["language"] == "sh":
            yield "", block["text"]
        elif block["file"]:
            yield block["file"], block["text"]


@pytest.mark.slow
def test_the_steps_of_the_guide_make_a_working_body(tmp_path):
    environment = Environment(tmp_path / "venv")
    folder = tmp_path / "work"
    folder.mkdir()
    printed = {}
    for file, text in steps():
        if file:
            assert (folder / file).is_file(), "the guide edits what 'plugins new' wrote"
            (folder / file).write_text(text, encoding="utf-8")
        else:
            for command in text.splitlines():
                printed[command] = environment.run(command, folder).stdout
    assert sum(bool(file) for file, _ in steps()) == 3
    assert printed["gaitsim plugins check ./hopper"].count("✓") == 3
    assert re.search(r"[2-9]\d passed in", printed["pytest -q hopper"])
    assert "power at which energy is stored" in printed["gaitsim plugins show hopper"]
    assert "40 generations are done" in printed["gaitsim run hopper"]
    assert (folder / "runs/moon/experiment.toml").is_file()


def test_the_finding_in_the_guide_is_that_of_the_check(install):
    """Its example of a finding is one."""
    (text,) = [text for file, text in steps() if file.endswith("__init__.py")]
    spoilt = text.replace("x = hops", "x = genomes.mean() + hops")
    assert spoilt != text
    install("gaitsim_hopper", spoilt, {"organism": {"hopper": "HopperBody"}})
    (broken,) = check("organism:hopper").broken
    shown = " ".join(GUIDE.read_text(encoding="utf-8").split())
    assert " ".join(broken.split()) in shown


@pytest.mark.slow
def test_the_search_in_the_docstring_conforms(install):
    from gaitsim.contracts import Search

    (text,) = re.findall(r"```python\n(.*?)```", cleandoc(Search.__doc__), re.DOTALL)
    install("gaitsim_sobol", dedent(text), {"search": {"example": "SobolSearch"}})
    assert check("search:example").broken == []


def check(name):
    with select_plugins(name) as found:
        (checked,) = check_plugins(found)
    return checked
