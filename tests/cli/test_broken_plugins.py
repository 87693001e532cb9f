"""A broken package is named in one message, run folders stay intact, and other packages work."""

import importlib
import json
import os
import sys
from pathlib import Path

import pytest

# A third-party package of puppets to break; each of its plugins is called "odd".
ODD = """
import os
import sys
from gaitsim_puppets import Jitter, Puppet
calls = []
class Body(Puppet):
    pass
class Mutator(Jitter):
    pass
"""
CLASSES = {"organism": "Body", "mutation": "Mutator"}


@pytest.fixture
def odd(puppets, install, monkeypatch):
    """Return a function that installs the package with one class replaced."""

    def make(kind="organism", body="", head=""):
        name = CLASSES[kind]
        lines = "\n    ".join(body.strip("\n").splitlines()) or "pass"
        source = ODD.replace(f"class {name}(", f"class Sound{name}(")
        base = ODD.partition(f"class {name}(")[2].partition(")")[0]
        source = f"{head}\n{source}class {name}({base}):\n    {lines}\n"
        points = {key: {"odd": target} for key, target in CLASSES.items()}
        folder = install("odd_package", source, points)
        monkeypatch.setenv("PYTHONPATH", str(folder), prepend=os.pathsep)
        return folder

    return make


def odd_run(puppet_file, *kinds):
    chosen = [part for kind in kinds for part in ("--set", f"{kind}.plugin=odd")]
    return ["run", puppet_file, *chosen, "--out", "run"]


def test_a_plugin_that_cannot_be_loaded_leaves_no_run(gaitsim, puppet_file, odd):
    odd(head="import no_such_thing")
    done = gaitsim(*odd_run(puppet_file, "organism"), code=2)
    assert "odd_package 1.0" in done.stderr
    assert done.stdout == ""
    assert not Path("run").exists()


LATE = """
def {method}(self, *arguments):
    calls.append(1)
    if len(calls) > {after}:
        raise ValueError("no strength left")
    return super().{method}(*arguments)
"""
METHODS = {"organism": "move", "mutation": "mutate"}


@pytest.mark.parametrize("kind", METHODS)
def test_an_exception_loses_only_the_current_generation(gaitsim, puppet_file, odd, kind):
    folder = odd(kind, LATE.format(method=METHODS[kind], after=4 if kind == "organism" else 2))
    done = gaitsim(*odd_run(puppet_file, kind), "--json", code=2)
    assert f"{kind} 'odd' of package odd_package 1.0 failed while" in done.stderr
    assert "ValueError: no strength left" in done.stderr
    assert "continue with: gaitsim resume run" in done.stderr
    made = [json.loads(line) for line in done.stdout.splitlines()]
    assert made[-1]["generation"] >= 2
    (folder / "odd_package.py").write_text(ODD + "\n# repaired\n")  # with the same version
    importlib.invalidate_caches()
    del sys.modules["odd_package"]
    shown = gaitsim("show", "run", "--json").stdout
    assert json.loads(shown)["generation"] == made[-1]["generation"]
    gaitsim("resume", "run", "--json")
    gaitsim(*odd_run(puppet_file, kind)[:-1], "sound", "--json")
    one, other = (gaitsim("show", run, "--fingerprint").stdout for run in ("run", "sound"))
    assert one == other


PRINTING = """
def move(self, genomes):
    import ctypes, os
    print("print")
    sys.__stdout__.write("__stdout__\\n")
    os.write(1, b"descriptor\\n")
    os.system("echo child process")
    libc = ctypes.CDLL(None)
    libc.puts(b"compiled code")
    libc.fflush(None)
    return super().move(genomes)
"""


@pytest.mark.sampled
@pytest.mark.skipif(os.name != "posix", reason="ctypes.CDLL(None)")
@pytest.mark.parametrize(("workers", "json_lines"), [(1, True), (2, False)])
def test_output_of_plugins_goes_to_standard_error(program, puppet_file, odd, workers, json_lines):
    odd("organism", PRINTING, "print('imported')")
    json_option = ["--json"] if json_lines else []
    done = program(*odd_run(puppet_file, "organism"), *json_option, "--workers", workers)
    lines = done.stdout.splitlines()
    if json_lines:
        assert [json.loads(line)["generation"] for line in lines][:5] == [1, 2, 3, 4, 5]
    else:
        assert lines[0] == "run run"
    printed = {"imported", "print", "__stdout__", "descriptor", "child process", "compiled code"}
    assert printed <= {*done.stderr.splitlines()}
    assert not printed & {*lines}


def test_a_plugin_may_close_standard_output(program, puppet_file, odd):
    odd("organism", head="import sys\nprint('unfinished', end='')\nsys.stdout.close()")
    done = program(*odd_run(puppet_file, "organism"), "--json")
    assert len([json.loads(line) for line in done.stdout.splitlines()]) >= 5


PRODUCTS = """
from typing import ClassVar
from gaitsim.contracts import Exported, Exporter, Plot, option

class Odd(Exporter):
    "Odd."
    title: ClassVar[str] = "Odd"
    group: ClassVar[str] = "Odd things"
    suffix: ClassVar[str] = ".odd"

    def write(self, subject, path):
        return Exported("nothing")

class Crooked(Plot):
    "Crooked."
    title: ClassVar[str] = "Crooked"
    group: ClassVar[str] = "Odd things"

    def draw(self, subject):
        raise ValueError("no line")
"""


@pytest.mark.parametrize(
    ("right", "wrong", "says"),
    [
        (
            '    group: ClassVar[str] = "Odd',
            '    other: ClassVar[str] = "',
            "group must be a string",
        ),
        (
            "    def write",
            "    x: int = option(3, 'x', flag='x')\n    def write",
            "the flag 'x' must",
        ),
        ('return Exported("nothing")', "return 3", "returned a int while exporting"),
    ],
)
def test_a_broken_format_is_named_and_the_others_work(
    gaitsim, finished, install, right, wrong, says
):
    assert right in PRODUCTS
    install("odd_package", PRODUCTS.replace(right, wrong, 1), {"exporter": {"odd": "Odd"}})
    said = gaitsim("export", "puppet", "--format", "odd", code=2).stderr
    assert "exporter 'odd' of package odd_package 1.0" in said
    assert says in said
    assert "Traceback" not in said
    gaitsim("export", "--help")
    gaitsim("export", "puppet", "--out", "gait.csv")


@pytest.mark.sampled
@pytest.mark.parametrize(
    ("draw", "says"),
    [
        ('raise ValueError("no line")', "failed while drawing: ValueError: no line"),
        ("return 3", "returned a int while drawing"),
    ],
)
def test_a_broken_plot_is_named_after_the_other_plots(
    gaitsim, finished, install, tmp_path, draw, says
):
    source = PRODUCTS.replace('raise ValueError("no line")', draw)
    install("odd_package", source, {"plot": {"crooked": "Crooked"}})
    for kind in ("crooked", "all"):
        said = gaitsim("plot", "puppet", "--kind", kind, code=2).stderr
        assert "plot 'crooked' of package odd_package 1.0" in said
        assert says in said
    exports = tmp_path / "runs/puppet/exports"
    assert {path.stem for path in exports.glob("*.png")} >= {"fitness", "path-generation-5"}


def test_an_option_of_a_package_does_not_replace_one_of_the_same_name(gaitsim, finished, install):
    source = PRODUCTS.replace(
        "    def write", "    keyframe_ms: str = option('a', 'word')\n    def write"
    ).replace('group: ClassVar[str] = "Odd', 'group: ClassVar[str] = "A')
    install("odd_package", source, {"exporter": {"odd": "Odd"}})
    arguments = ("--format", "ros2", "--keyframe-ms")
    gaitsim("export", "puppet", *arguments, 20)
    assert (
        "invalid --keyframe-ms: 'b'" in gaitsim("export", "puppet", *arguments, "b", code=2).stderr
    )
