"""A broken package is named in one message, run folders stay intact, and other packages work."""

import json
import os
from pathlib import Path

import pytest

# A third-party package of puppets to break; each of its plugins is called "odd".
ODD = """
import os
import sys
from typing import ClassVar
import numpy as np
from gaitsim.contracts import Motion, RealSpace
from gaitsim_puppets import Best, Jitter, Mean, Puppet, Reach
calls = []
class Body(Puppet):
    pass
class Faulty(Reach):
    pass
class Chooser(Best):
    pass
class Crosser(Mean):
    pass
class Mutator(Jitter):
    pass
"""
CLASSES = {
    "organism": "Body",
    "fitness": "Faulty",
    "selection": "Chooser",
    "crossover": "Crosser",
    "mutation": "Mutator",
}


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


BEFORE = {
    "an import that fails": ("organism", "", "import no_such_thing", "No module named"),
    "a syntax error": ("fitness", "", "def (", "SyntaxError"),
    "an exit": ("mutation", "", "import sys; sys.exit(0)", "SystemExit: 0"),
    "another class": ("selection", "", "", "not a subclass of Selection"),
}


@pytest.mark.parametrize("name", BEFORE)
def test_a_plugin_that_cannot_be_loaded_leaves_no_run(gaitsim, puppet_file, odd, name):
    kind, body, head, says = BEFORE[name]
    folder = odd(kind, body, head)
    if name == "another class":
        points = folder / "odd_package-1.0.dist-info/entry_points.txt"
        points.write_text(points.read_text().replace("Chooser", "Mutator"))
    done = gaitsim(*odd_run(puppet_file, kind), code=2)
    assert "odd_package 1.0" in done.stderr
    assert says in done.stderr
    assert done.stdout == ""
    assert not Path("run").exists()


DURING = {
    "another shape": (
        "organism",
        "def move(self, genomes):\n    return Motion(4.0, {'joint_angles': genomes[:1, None],"
        " 'reach': genomes[:1, 0]})",
        "the shape",
    ),
    "no motion": (
        "organism",
        "def move(self, genomes):\n    return 3",
        "returned a int as its motion",
    ),
    "an exit": ("organism", "def move(self, genomes):\n    raise SystemExit(0)", "SystemExit"),
    "changed genomes": (
        "organism",
        "def move(self, genomes):\n    genomes += 1\n    return super().move(genomes)",
        "modifies the genomes",
    ),
    "terms for one": ("fitness", "def terms(self, motion):\n    return {'a': 1.0}", "the shape ()"),
    "parents that are none": (
        "selection",
        "def parents(self, scores, pairs, rng):\n    return np.full((pairs, 2), 99, np.intp)",
        "parents 99 to 99",
    ),
    "children too few": (
        "crossover",
        "def cross(self, mothers, fathers, space, rng):\n    return mothers[:1]",
        "returned shape (1, 3)",
    ),
    "NaN among the genes": (
        "mutation",
        "def mutate(self, genomes, space, rng):\n    return genomes * np.nan",
        "not finite",
    ),
}


@pytest.mark.parametrize("name", DURING)
def test_a_broken_contract_ends_the_run_which_can_be_resumed(gaitsim, puppet_file, odd, name):
    kind, body, says = DURING[name]
    folder = odd(kind, body)
    done = gaitsim(*odd_run(puppet_file, kind), code=2)
    assert f"{kind} 'odd' of package odd_package 1.0" in done.stderr
    assert says in done.stderr
    assert "continue with: gaitsim resume run" in done.stderr
    assert "Traceback" not in done.stderr
    install_working_release(folder)
    assert gaitsim("resume", "run", "--json").stdout.count('"generation"') >= 4
    assert fingerprint(gaitsim, "run") == fingerprint(gaitsim, sound(gaitsim, puppet_file, kind))


def install_working_release(folder):
    """Replace the package by a working one with the same version."""
    (folder / "odd_package.py").write_text(ODD + "\n# repaired\n")
    forget()


def forget():
    import importlib
    import sys

    importlib.invalidate_caches()
    sys.modules.pop("odd_package", None)


def sound(gaitsim, puppet_file, kind):
    gaitsim(*odd_run(puppet_file, kind)[:-1], "sound", "--json")
    return "sound"


def fingerprint(gaitsim, run):
    return gaitsim("show", run, "--fingerprint").stdout.split()[0]


LATE = """
def {method}(self, *arguments):
    calls.append(1)
    if len(calls) > {after}:
        raise ValueError("no strength left")
    return super().{method}(*arguments)
"""
METHODS = {
    "organism": "move",
    "fitness": "terms",
    "selection": "parents",
    "crossover": "cross",
    "mutation": "mutate",
}


@pytest.mark.parametrize("kind", METHODS)
def test_an_exception_loses_only_the_current_generation(gaitsim, puppet_file, odd, kind):
    folder = odd(kind, LATE.format(method=METHODS[kind], after=4 if kind in CALLED_FIRST else 2))
    done = gaitsim(*odd_run(puppet_file, kind), "--json", code=2)
    assert f"{kind} 'odd' of package odd_package 1.0 failed while" in done.stderr
    assert "ValueError: no strength left" in done.stderr
    assert "continue with: gaitsim resume run" in done.stderr
    made = [json.loads(line) for line in done.stdout.splitlines()]
    assert made[-1]["generation"] >= 2
    install_working_release(folder)
    shown = gaitsim("show", "run", "--json").stdout
    assert json.loads(shown)["generation"] == made[-1]["generation"]
    gaitsim("resume", "run", "--json")
    assert fingerprint(gaitsim, "run") == fingerprint(gaitsim, sound(gaitsim, puppet_file, kind))


CALLED_FIRST = ("organism", "fitness")  # called once to prepare


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


@pytest.mark.slow
def test_a_plugin_that_closes_the_descriptor_of_standard_output_is_named(program, puppet_file, odd):
    odd("organism", head="import os\nos.close(1)")
    done = program(*odd_run(puppet_file, "organism"), "--json", code=2)
    assert "organism 'odd' of package odd_package 1.0 closed file descriptor 1" in done.stderr
    assert done.stdout == ""


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
        ('    suffix: ClassVar[str] = ".odd"', "", "suffix must be a string"),
        ('title: ClassVar[str] = "Odd"', "title: ClassVar[int] = 3", "title must be a string"),
        (
            "    def write",
            '    input: ClassVar[str] = "all"\n    def write',
            "input must be 'run' or",
        ),
        ("    def write", "    help: int = 3\n    def write", "cannot be named 'help'"),
        (
            "    def write",
            "    x: int = option(3, 'x', flag='--out')\n    def write",
            "cannot be named '--out'",
        ),
        (
            "    def write",
            "    x: int = option(3, 'x', flag='x')\n    def write",
            "the flag 'x' must",
        ),
        ('return Exported("nothing")', "raise ValueError('no file')", "exporting: ValueError"),
        ('return Exported("nothing")', "raise SystemExit(0)", "exporting: SystemExit"),
        ('return Exported("nothing")', "return 3", "returned a int while exporting"),
        (
            "    def write",
            "    def file_name(self, subject): return 3\n    def write",
            "a int while",
        ),
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
