"""A reader of the documentation, who runs the commands of a page or a `--help` in order.

The reader of a page begins in a folder without runs; the reader of a `--help` has the runs that
its examples name.
"""

import re
import shlex
import shutil
import subprocess
from collections.abc import Callable
from importlib.util import find_spec
from pathlib import Path
from types import SimpleNamespace

from printed import Step, examples, helps, steps
from terminals import begin_and_end, shell

from gaitsim.registry import EXPERIMENTS, entries
from gaitsim.storage.manage import trash_run

ROOT = Path(__file__).parents[2]
PAGES = [
    ROOT / "README.md",
    *sorted(
        (*ROOT.glob("docs/*.md"), *ROOT.glob("plugins/*/docs/*.md")), key=lambda page: page.name
    ),
]
HELP = dict(helps())
FOUND: dict[Path | str, list[Step]] = {path: list(steps(path.read_text())) for path in PAGES}
FOUND |= {words: list(examples(text)) for words, text in HELP.items()}
# The guide of plugins is run in an environment of its own: test_plugin_guide.py.
GUIDE = ROOT / "docs" / "plugins.md"
FOUND = {path: found for path, found in FOUND.items() if found and path != GUIDE}

NOT_RUN = {
    r"gaitsim verify .*(--sign |s/mine|/adaptations/|--atlas )": "needs a key or files",
    r"^(?!(\w+=\w+ )?gaitsim \w)": "another program: sets something up, or has a test of its own",
    r"tcp://host:8786": "needs a cluster",
    r"champions/generation-0000": "a file of a run with all its individuals",
    r"attach .* > ": "ends with the run; without a file it is begun",
    r" --port ": "needs a robot; tests/wire has virtual ones",
    r"robots identify|my_hexapod": "needs recordings of a robot; tests/wire has some",
    r"queue night": "needs runs that wait; tests/cli/test_background.py moves some",
    r" --root \.\./": "needs the folder of a robot's meshes",
    r"plugins check( --json.*)?$": "takes a minute; tests of gaitsim-testing check all plugins",
    r"--pairs --physics": "takes half a minute; pages have each of the two options alone",
    r"--from my_gait": "needs a gait of a robot; tests of gaitsim-robot have some",
    r"study millipede-operators": "takes minutes; benchmarks/study.py runs it",
}
"""Commands that are only parsed, and why."""

ONCE = r"gaitsim (compare|imitate|members|plot|steer|video)\b"
"""Commands that are run only on the first page that has them, as no later command needs them."""

ENDLESS = {
    r"^gaitsim runs --watch": ("run", ""),
    r"^gaitsim tui": ("gaitsim", "\x11"),
    r"^gaitsim steer$|^gaitsim steer fly": ("hover", "\x11"),
    r"^gaitsim steer ": ("faster", "\x11"),
    r"^gaitsim serve": ("http://", ""),
    r"^gaitsim robots emulate": ("Ctrl-C ends it", ""),
    r"^gaitsim attach": ("generation", ""),
    r"^gaitsim adapt.*--interactive": ("Enter to quit", "\n"),
}
"""Commands that do not end by themselves: what they show, and the key that ends them, or Ctrl-C."""

EXTRAS = {
    "--engine bullet": "pybullet",
    "--format tensorboard": "tensorboardX",
    "--dask": "distributed",
    ".parquet": "pyarrow",
    "gaitsim serve": "textual_serve",
}
"""Modules that some options need."""

SHORT = {"organism.duration": 3.0}
"""Options of robots, whose rigid-body physics is slow."""

LONG = {
    "spider": {"population": 4},
    "spider-genetic": {"population": 4},
    "fly": {"population": 6, "set": {"organism.duration": 1.0}},
    "fly-genetic": {"population": 6, "set": {"organism.duration": 1.0}},
    "spider-front": {"population": 8},
    "spider-atlas": {"population": 20, "generations": 300},
    "walker-four": {"population": 4, "generations": 2, "set": SHORT},
    "walker-worlds": {"population": 4, "generations": 2, "set": SHORT},
}
"""Presets that evolve long, since pages name late generations or need an archive with members, and
presets that take long for each individual."""

ONE_WORLD = {"worlds.cases": [], "worlds.number": 1}
"""Options of robots that evolve in several worlds."""

SHORTER = {
    "gaitsim resume fly-genetic --generations 1000": "gaitsim resume fly-genetic --generations 205",
    "gaitsim resume fly --set organism.duration=30 --generations 450": (
        "gaitsim resume fly --set organism.duration=30 --generations 405"
    ),
    "gaitsim run walker --dask local --workers 4": "gaitsim run walker --dask local --workers 2",
    "gaitsim run my_robot.urdf --generations 30": "gaitsim run my_robot.urdf --generations 3",
    "gaitsim design hexapod --dimensions femur,tibia,hips.width --sample 60": (
        "gaitsim design hexapod --dimensions femur,tibia,hips.width --sample 12"
    ),
    "gaitsim run hexapod --generations 10 --population 24 --set organism.duration=4": (
        "gaitsim run hexapod --generations 2 --population 4 --set organism.duration=4"
    ),
}
"""Commands with many generations or designs, none of which a later command names."""

LESS = {
    "run": {"--population": "10", "--generations": "2"},
    "atlas": {"--population": "20", "--generations": "2"},
    "video": {"--size": "320x180", "--fps": "1", "--speed": "1"},
    "play": {"--at": "0"},
    "compare": {"--repeats": "2", "--evaluations": "400"},
    "design": {"--levels": "3", "--replicates": "2", "--original": "1", "--polish": "1"},
    "imitate": {"--epochs": "20"},
    "adapt": {"--trials": "2"},
}
"""Options for less work, by command."""


OWN = {
    "my-spider.toml": "gaitsim experiments show spider > my-spider.toml",
    "my-gait.csv": "gaitsim export spider --out my-gait.csv",
}
"""Files of a reader that `--help` names, and how they were made."""


def command_of(step: Step) -> str:
    """Return the command of a step without its comment."""
    return step.text.partition("  # ")[0].rstrip()


FIRST = {command_of(step): path for path in reversed(FOUND) for step in FOUND[path]}
"""The first page or `--help` with each command."""


def does_all(
    path: Path | str,
    folder: Path,
    runs: Callable[[str], Path],
    gaitsim: Callable[..., SimpleNamespace],
) -> None:
    """Do in a folder what a page or a `--help` says, and fail with all commands that fail."""
    quadruped = ROOT / "plugins" / "gaitsim-robot" / "gaitsim_robot" / "models" / "quadruped.xml"
    shutil.copy(quadruped, folder / "my_robot.urdf")  # the root element tells the format
    if path in HELP:
        its_examples_exist(FOUND[path], folder, runs, gaitsim)
    failed = []
    for step in FOUND[path]:
        if re.match(ONCE, step.text) and FIRST[command_of(step)] != path:
            continue
        try:
            reader_does(step, folder, runs, gaitsim)
        except AssertionError as error:
            failed.append(f"{step.text}\n{error}")
    assert not failed, "\n".join(failed)


def its_examples_exist(
    found: list[Step],
    folder: Path,
    runs: Callable[[str], Path],
    gaitsim: Callable[..., SimpleNamespace],
) -> None:
    """Make the runs and files that the examples of a `--help` name, as its reader has them."""
    named = set(re.findall(r"[\w-]+", " ".join(step.text for step in found)))
    for preset in sorted(named & {"spider", *entries(EXPERIMENTS)}):
        shutil.copytree(runs(preset), folder / "runs" / preset)
    for copied in named & {"spider-2", "spider-3"}:
        shutil.copytree(runs("spider"), folder / "runs" / copied)
    if "experiments/spring" in " ".join(step.text for step in found):
        shutil.copytree(runs("spider"), folder / "experiments" / "spring" / "spider")
    for restored in re.findall(r"trash restore ([\w-]+)", "\n".join(step.text for step in found)):
        if not (folder / "runs" / restored).exists():
            shutil.copytree(runs("spider"), folder / "runs" / restored)
        trash_run(folder / "runs" / restored)
    for file, line in OWN.items():
        if file in " ".join(step.text for step in found):
            reader_does(Step(line), folder, runs, gaitsim)
    studies = [
        step for step in FOUND[ROOT / "plugins/gaitsim-studies/docs/studies.md"] if step.file
    ]
    reader_does(studies[0]._replace(file="my-study.toml"), folder, runs, gaitsim)


def reader_does(
    step: Step, folder: Path, runs: Callable[[str], Path], gaitsim: Callable[..., SimpleNamespace]
) -> None:
    """Do in a folder what a page says."""
    line, file = step
    if file:
        less = re.sub(r"(repeats|generations\"?) = \d+", r"\1 = 2", line)
        less = less.replace("from = 50, to = 200,", "from = 10, to = 60,")  # of the population
        (folder / file).write_text(less)
        return
    if any(re.search(one, line) for one in NOT_RUN):
        return
    if not all(find_spec(needed) for flag, needed in EXTRAS.items() if flag in line):
        return
    line = command_of(step)
    line = SHORTER.get(line, line)
    for beginning, (shows, key) in ENDLESS.items():
        if re.match(beginning, line):
            begin_and_end(line, folder, shows, key)
            return
    preset = re.fullmatch(r"gaitsim run (\w[\w-]*)", line)
    if preset and not (folder / "runs" / preset[1]).exists():
        shutil.copytree(runs(preset[1]), folder / "runs" / preset[1])
    elif re.match(r"gaitsim [^|&]*$", line) and "2>" not in line:
        command, _, out = line.partition(" > ")
        printed = gaitsim(*quick(shlex.split(command)[1:])).stdout
        if out:
            (folder / out).write_text(printed)
    else:
        line = re.sub(r"(gaitsim video \S+)", r"\1 --size 320x180 --fps 1", line)
        done = subprocess.run(**shell(line, folder), capture_output=True, text=True, check=False)
        assert done.returncode == 0, f"{line}: {done.stderr}"


def robot_options(preset: str) -> dict[str, object]:
    """Return the options with which a robot takes little time."""
    return SHORT | (ONE_WORLD if preset.endswith("-steady") else {})


def is_robot(reference: str) -> bool:
    """Return whether a run's reference is a file of a robot, or a preset with a robot."""
    presets = entries(EXPERIMENTS).get(reference, [])
    return reference.endswith(".urdf") or any("robot" in one.target for one in presets)


def quick(arguments: list[str]) -> list[str]:
    """The same command with less work, but as many generations as it names."""
    less = LESS.get(arguments[0], {})
    if "--worlds" in arguments:
        less = {"--worlds": "4"}
    elif {"--report", "--detach"} & set(arguments):
        less = {}  # other options are refused; what runs in the background is stopped
    elif arguments[0] == "run" and "atlas" in arguments[1]:
        less = {**less, "--population": "20"}  # two genomes for each emitter
    elif arguments[0] in ("run", "atlas", "design") and is_robot(arguments[1]):
        if arguments[0] == "run":
            less = {"--population": "4", "--generations": "2", "--workers": "1"}
        given = " ".join(arguments)
        longer = {"organism.duration": 6.0} if "organism.drive" in given else {}
        for option, value in (robot_options(arguments[1]) | longer).items():
            if option not in given:
                arguments = [*arguments, "--set", f"{option}={value}"]
    if {"--delete", "--delete-matching", "--tag", "empty"} & {*arguments}:
        return [*arguments, "--yes"]
    for option, value in less.items():
        if option == "--population" and "millipede" in arguments[1]:
            continue
        if option not in arguments:
            arguments = [*arguments, option, value]
        elif option != "--generations":
            arguments[arguments.index(option) + 1] = value
    return arguments
