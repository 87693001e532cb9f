"""Fixtures for all tests: temporary plugin packages, the command line, and small runs."""

import asyncio
import gc
import importlib
import inspect
import os
import re
import shutil
import signal
import subprocess
import sys
from collections import Counter
from collections.abc import Callable, Mapping
from contextlib import suppress
from functools import cache, partial
from importlib.util import find_spec
from itertools import count
from pathlib import Path
from types import SimpleNamespace

import pytest
from hypothesis import settings
from xdist.scheduler import LoadFileScheduling

from gaitsim.registry.kernel_cache import allow_missing_cache

Install = Callable[..., Path]

settings.register_profile(
    "tests", derandomize=True, deadline=None
)  # the same examples on every machine
settings.load_profile("tests")

# With the default threshold, garbage collection takes a tenth of the time of the UI's tests.
gc.set_threshold(100_000, 50, 50)

# Without a bytecode cache, each program that a test starts would compile the whole package.
os.environ.pop("PYTHONDONTWRITEBYTECODE", None)
sys.dont_write_bytecode = False

# Files of tests need not survive a power failure, and thousands of fsync calls add up.
os.fsync = lambda descriptor: None

allow_missing_cache()  # runs call this; tests import kernels directly, but share the cache

# A shell that starts the tests in the background makes them and their children ignore SIGINT.
signal.signal(signal.SIGINT, signal.default_int_handler)

WORKING = '''
from enum import Enum
from typing import ClassVar, Literal

import numpy as np

from gaitsim.contracts import (
    BitSpace, Channel, Crossover, Fitness, Motion, Mutation, Organism, RealSpace, Search,
    Selection, Skeleton, option,
)


class Body(Organism):
    """A point that moves by the sum of its genes."""

    channels: ClassVar = {"distance": Channel((), "m", "distance moved")}

    def genome_space(self):
        return RealSpace(np.full(3, -1.0), np.full(3, 1.0), ("a", "b", "c"))

    def move(self, genomes):
        return Motion(1.0, {"distance": genomes.sum(axis=1)})

    def skeleton(self, motion, individual):
        return Skeleton(np.zeros((1, 1, 2, 3)), ("point",), 1.0)


class BitBody(Body):
    """The same body with genes of bits."""

    def genome_space(self):
        return BitSpace(("a", "b", "c"))


class Distance(Fitness):
    """The distance moved."""

    needs: ClassVar = ("distance",)

    def terms(self, motion):
        return {"distance": motion["distance"]}


class Fresh(Search):
    """Random genomes, and the best genome of the previous generation."""

    def initial(self, context):
        return {"best": np.zeros((0, context.space.genes), context.space.dtype)}

    def ask(self, state, last, context):
        kept = state["best"]
        return np.concatenate([kept, context.random(context.population - len(kept))]), state

    def tell(self, state, results, context):
        return {"best": results.genomes[np.argmax(results.scores)][None]}


class First(Selection):
    """Select the first two individuals."""

    def parents(self, scores, pairs, rng):
        return np.tile(np.array([0, 1], dtype=np.intp), (pairs, 1))


class Solo(Crossover):
    """Copy the mother as the only child; the number of children is not an option."""

    children: ClassVar[int] = 1

    def cross(self, mothers, fathers, space, rng):
        return mothers.copy()


class Still(Mutation):
    """No mutation."""

    def mutate(self, genomes, space, rng):
        return genomes.copy()
'''


PACKAGES = tuple(
    f"gaitsim_{name}"
    for name in (
        "adaptation",
        "design",
        "imitation",
        "page",
        "robot",
        "serve",
        "studies",
        "testing",
        "wire",
    )
)
ALL = all(map(find_spec, PACKAGES))
"""Whether all packages are installed; tests of the core that use one are left out otherwise."""
_USES = re.compile(rf"^(?:from|import) (?:{'|'.join(PACKAGES)})\b", re.MULTILINE)


def pytest_ignore_collect(collection_path):
    """Leave out files that import a package that is not installed."""
    if not ALL and collection_path.suffix == ".py":
        return bool(_USES.search(collection_path.read_text("utf-8"))) or None
    return None


def pytest_itemcollected(item):
    """Mark all but the first case of a sampled test as slow, and skip tests of absent packages."""
    if not ALL and item.get_closest_marker("packages"):
        item.add_marker(pytest.mark.skip(reason="a package is not installed"))
    if item.get_closest_marker("sampled") and any(item.callspec.indices.values()):
        item.add_marker("slow")


@pytest.hookimpl(tryfirst=True)
def pytest_pyfunc_call(pyfuncitem):
    """Run asynchronous tests."""
    if not inspect.iscoroutinefunction(pyfuncitem.obj):
        return None
    given = {name: pyfuncitem.funcargs[name] for name in pyfuncitem._fixtureinfo.argnames}
    asyncio.run(pyfuncitem.obj(**given))
    return True


def pytest_xdist_auto_num_workers():
    """Return one worker more than cores, as tests that wait for processes leave cores idle."""
    return (os.cpu_count() or 1) + 1


LONGEST = (
    "plugins/gaitsim-testing/tests/test_all_installed.py",
    "tests/docs/test_commands.py",
    "tests/evolution/test_fingerprints.py",
    "tests/test_package.py",
    "plugins/gaitsim-testing/tests/test_plugin_guide.py",
)
"""Files that begin first, as a long one that begins last leaves the other cores idle."""


def pytest_collection_modifyitems(config, items):
    """Let each worker begin with the longest files, then with those of the most tests."""
    if hasattr(config, "workerinput"):
        count = Counter(item.path for item in items)
        items.sort(key=lambda item: (not item.nodeid.startswith(LONGEST), -count[item.path]))


def pytest_collection_finish():
    """Let the garbage collector skip what was collected, which lives to the end."""
    gc.freeze()


def pytest_unconfigure():
    """Collect garbage once; pytest does so five times, each a second at the end of a worker."""
    gc.collect()
    gc.freeze()


class Scheduling(LoadFileScheduling):
    """A worker's unit is a file in the order of collection, or a page of documented commands."""

    def _split_scope(self, nodeid):
        return (
            nodeid
            if nodeid.startswith("tests/docs/test_commands")
            else super()._split_scope(nodeid)
        )


def pytest_xdist_make_scheduler(config, log):
    config.option.loadscopereorder = False
    return Scheduling(config, log)


COMPILE = """
import sys
import numpy as np
import gaitsim
from gaitsim.experiment import load_experiment

for preset in sys.argv[1:]:
    experiment = load_experiment(preset)
    gaitsim.evaluate(experiment, experiment.space().random(2, np.random.default_rng(0)))
"""


COMPILE_DRAWING = """
from gaitsim.contracts import Solid
from gaitsim.render.scene.camera import Camera, axes
from gaitsim.render.scene.raster import raster
from gaitsim.render.scene.solids import Surfaces

camera = Camera(np.zeros(3), *axes(-58.0, 27.0), 7.0, 100.0, np.array([20.0, 15.0]))
pose = np.array([[0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0]])
ball = Surfaces([Solid("ball", "sphere", (0.5,))])
raster(camera, ball, pose, np.array([0.0, 0.0, 1.0]), (40, 30), 2)
"""


def pytest_xdist_setupnodes():
    """Compile kernels once, before each worker would compile them for itself."""
    scripts = (
        (COMPILE + COMPILE_DRAWING, "fly", "fly-steer"),
        (COMPILE, "spider", "spider-recurrence", "hexapod-steady"),
    )
    compilers = [subprocess.Popen([sys.executable, "-c", *script]) for script in scripts]
    for compiler in compilers:
        compiler.wait()


@pytest.fixture
def tmp_path(tmp_path_factory: pytest.TempPathFactory, request: pytest.FixtureRequest) -> Path:
    """Return an empty folder with the test's name.

    pytest's own fixture reads the names of all earlier tests' folders to number the next one, which
    took a twentieth of the time of all tests.
    """
    name = re.sub(r"\W", "_", request.node.name)[:30]
    folder = tmp_path_factory.getbasetemp() / f"{name}-{next(_numbers)}"
    folder.mkdir()
    return folder


_numbers = count()


@pytest.fixture(autouse=True)
def runtime_folder(tmp_path_factory, monkeypatch):
    """Give each test its own folder of background processes, and kill these after the test."""
    folder = tmp_path_factory.getbasetemp() / f"runtime-{next(_numbers)}"
    monkeypatch.setenv("GAITSIM_RUNTIME_DIR", str(folder))
    yield folder
    if not folder.exists():
        return
    from gaitsim.storage.background import background_processes

    for process in background_processes():
        with suppress(ProcessLookupError):
            os.kill(process.pid, signal.SIGKILL)


@pytest.fixture
def install(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Install:
    """Return a function that creates a package, puts it on the path and returns its folder.

    Its arguments are the package's name, the source of the module of that name, and the entry
    points: kind -> name -> object after the colon.
    """

    def install(
        name: str,
        source: str = "",
        entries: Mapping[str, Mapping[str, str]] | None = None,
        files: Mapping[str, str | bytes] | None = None,
        version: str = "1.0",
    ) -> Path:
        folder = tmp_path / name
        metadata = folder / f"{name}-{version}.dist-info"
        metadata.mkdir(parents=True)
        points = [
            line
            for kind, names in (entries or {}).items()
            for line in (
                f"[gaitsim.{kind}]",
                *(
                    f"{key} = {name}{f':{target}' if target else ''}"
                    for key, target in names.items()
                ),
            )
        ]
        (metadata / "METADATA").write_text(
            f"Metadata-Version: 2.1\nName: {name}\nVersion: {version}\n"
        )
        (metadata / "entry_points.txt").write_text("\n".join(points))
        if source:
            (folder / f"{name}.py").write_text(source)
        for file, content in (files or {}).items():
            path = folder / file
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_bytes(content.encode() if isinstance(content, str) else content)
        monkeypatch.syspath_prepend(folder)
        importlib.invalidate_caches()
        # Removed after the test, so that the next test can import another module of this name.
        monkeypatch.setitem(sys.modules, name, None)
        del sys.modules[name]
        return folder

    return install


@pytest.fixture
def working() -> str:
    """Return the source of a module with a working plugin of each kind."""
    return WORKING


SHAPED = """
from pydantic import field_validator
from gaitsim.contracts import BodyFile, Question, folder_of
from gaitsim.errors import GaitsimError

class X(Body):
    label: str = option("plain", "a word")
    shape: str = option("ball", "ball, a file, or its content")
    size: float = option(1.0, "how large", ge=0)

    @field_validator("shape")
    @classmethod
    def _read(cls, shape, info):
        if not shape.lower().endswith(".shape"):
            return shape
        folder = folder_of(info)
        if folder is None:
            raise ValueError("no file is read here")
        try:
            return (folder / shape).read_text()
        except OSError as error:
            raise GaitsimError(
                "the shape cannot be read", where=str(folder / shape), allowed="a shape",
                remedy="another file", key="shape",
            ) from None

    def describe(self):
        if self.shape == "flat":
            raise GaitsimError("a flat shape cannot roll", remedy="a round one")
        return {"Body": {"size": f"{self.size} m", "shape": self.shape[:9]}}

    @classmethod
    def library(cls):
        return {"Shapes": {"ball": "round"}}

    def imported(self):
        return BodyFile("cube", self.shape, ("its corners are round",))

    def warnings(self):
        return ("it is heavy",) if self.size > 99 else ()

    def questions(self):
        return (Question("Is it plain?", "label", "so so"),) if self.label == "plain" else ()
"""


@pytest.fixture
def shaped(install, working) -> str:
    """Install a body that reads a file, and return the TOML of an experiment with it."""
    text = (
        PUPPET.replace('"puppet-reach"', '"far"')
        .replace('"puppet-best"', '"tournament"')
        .replace('"puppet-mean"', '"uniform"')
        .replace('"puppet-jitter"', '"gaussian"')
        .replace('"puppet"', '"cube"')
    )
    kinds = {
        "organism": {"cube": "X"},
        "fitness": {"far": "Distance"},
        "files": {"shape": "X.shape"},
    }
    install("fake", working + SHAPED, kinds)
    install(
        "kept", "", {"experiments": {"cube": ""}}, {"kept/__init__.py": "", "kept/cube.toml": text}
    )
    return text


# tests/puppets holds a third-party plugin package; being on the path is enough to install it.
PUPPETS = Path(__file__).parent / "tests" / "puppets"
PUPPET = """
name = "puppet"
seed = 1
[evolution]
population = 6
generations = 5
[organism]
plugin = "puppet"
[fitness]
plugin = "puppet-reach"
[search]
plugin = "genetic"
elites = 2
[selection]
plugin = "puppet-best"
[crossover]
plugin = "puppet-mean"
[mutation]
plugin = "puppet-jitter"
"""


@pytest.fixture
def puppets(monkeypatch):
    """Install the puppets' package, and return its module."""
    monkeypatch.syspath_prepend(str(PUPPETS))
    import gaitsim_puppets

    return gaitsim_puppets


@pytest.fixture
def puppet(puppets):
    """Return a function that creates an experiment of puppets, with overrides."""
    from gaitsim.experiment import parse_assignments, parse_experiment

    return lambda *overrides: parse_experiment(PUPPET, "puppet.toml", parse_assignments(overrides))


@pytest.fixture
def cart(install):
    """Install a cart, which can be steered, and return its experiment."""
    from cart import CART

    from gaitsim.experiment import parse_experiment

    source = (Path(__file__).parent / "tests" / "cart.py").read_text()
    entries = {"organism": {"cart": "Cart"}, "fitness": {"cart-distance": "Distance"}}
    install("carts", source, entries)
    return parse_experiment(CART, "cart.toml")


@pytest.fixture
def puppet_file(tmp_path):
    """Return the path of an experiment file of puppets."""
    path = tmp_path / "puppet.toml"
    path.write_text(PUPPET)
    return path


CLIMB = """
from typing import ClassVar
import numpy as np
from gaitsim.contracts import Fitness, RealSpace, option
from gaitsim_puppets import Puppet
class Climb(Fitness):
    weight: float = option(0.5, "of the reach", ge=0)
    needs: ClassVar = ("joint_angles", "reach")
    def terms(self, motion):
        height = np.cos(motion["joint_angles"][:, -1] - 1).sum(axis=1)
        return {"height": height, "reach": -self.weight * motion["reach"]}
class Shaped(Puppet):
    most: float = option(2.0, "greatest angle", unit="rad")
    names: str = option("abc", "a letter a joint")
    def genome_space(self):
        genes = len(self.names)
        return RealSpace(np.full(genes, -1.0), np.full(genes, self.most), tuple(self.names))
"""


@pytest.fixture
def climb(puppets, install, monkeypatch):
    """Install a second fitness for puppets and a puppet with options; return the folder."""
    folder = install(
        "climb", CLIMB, {"fitness": {"puppet-climb": "Climb"}, "organism": {"shaped": "Shaped"}}
    )
    paths = os.pathsep.join(filter(None, [str(folder), os.environ.get("PYTHONPATH")]))
    monkeypatch.setenv("PYTHONPATH", paths)
    return folder


def _program(folder, arguments, options):
    paths = os.pathsep.join(filter(None, [str(PUPPETS), os.environ.get("PYTHONPATH")]))
    return {
        "args": [sys.executable, "-m", "gaitsim", *map(str, arguments)],
        "cwd": folder,
        "env": os.environ | {"PYTHONPATH": paths},
        "stdout": subprocess.PIPE,
        "stderr": subprocess.PIPE,
        "text": True,
    } | options


@pytest.fixture
def gaitsim(tmp_path, puppets, monkeypatch, capsys):
    """Return a function that runs a command in this process and checks its exit code."""
    from gaitsim.cli import main

    monkeypatch.chdir(tmp_path)

    def run(*arguments, code=0):
        monkeypatch.setattr(sys, "argv", ["gaitsim", *map(str, arguments)])
        with pytest.raises(SystemExit) as ended:
            main()
        written = capsys.readouterr()
        assert (ended.value.code or 0) == code, written.err
        return SimpleNamespace(stdout=written.out, stderr=written.err)

    return run


@pytest.fixture
def program(tmp_path):
    """Return a function that runs a command in a new process and checks its exit code."""

    def run(*arguments, code=0, **options):
        done = subprocess.run(**_program(tmp_path, arguments, options), check=False, timeout=120)
        assert done.returncode == code, done.stderr
        assert "Traceback" not in done.stderr
        return done

    return run


@pytest.fixture
def start(tmp_path):
    """Return a function that starts a process, which is killed after the test."""
    started = []

    def begin(*arguments, **options):
        started.append(subprocess.Popen(**_program(tmp_path, arguments, options)))
        return started[-1]

    yield begin
    for process in started:
        process.kill()
        process.wait()
        for pipe in (process.stdout, process.stderr):
            if pipe is not None:
                pipe.close()


@pytest.fixture(scope="session")
def once(tmp_path_factory):
    """Return a function that creates a folder once for all tests, and copies it for each test.

    Its arguments are a name for the folder's content, the folder's path, and a function that
    creates the folder there. A copy of a run takes 2 ms, a run of puppets 20 to 80 ms.
    """
    kept = tmp_path_factory.mktemp("once")

    def once(name, path, create):
        if not (kept / name).exists():
            create()
            shutil.copytree(path, kept / name)
        else:
            shutil.copytree(kept / name, path)
        return path

    return once


@pytest.fixture
def finished(gaitsim, puppet_file, tmp_path, once):
    """Return the folder `runs/puppet` of a finished run of puppets."""
    return once("puppet", tmp_path / "runs/puppet", lambda: gaitsim("run", puppet_file))


def evolved(experiment, path, keep=lambda generation: None):
    """Evolve an experiment without workers, and return the finished run."""
    from gaitsim.evaluation import evaluate
    from gaitsim.evolution import evolve
    from gaitsim.storage.creation import create_run
    from gaitsim.storage.snapshot import RunSnapshot
    from gaitsim.storage.writer import RunWriter

    path = create_run(experiment, path)
    with RunWriter.open(path) as writer:
        for generation in evolve(experiment, partial(evaluate, experiment)):
            writer.record(generation)
            keep(generation)
    return RunSnapshot(path)


@pytest.fixture
def checkpoint_reads(monkeypatch):
    """Return a list to which each checkpoint or champion that is read adds its path."""
    from gaitsim.storage.files import safe_pickle

    paths, load = [], safe_pickle.load
    monkeypatch.setattr(safe_pickle, "load", lambda path: (paths.append(path), load(path))[1])
    return paths


@pytest.fixture(scope="session")
def spider_run(tmp_path_factory):
    """Return a finished run of three generations of ten spiders."""
    from gaitsim.experiment import load_experiment

    experiment = load_experiment(
        "spider-recurrence", {"evolution.population": 10, "evolution.generations": 3}
    )
    return evolved(experiment, tmp_path_factory.mktemp("export") / "spider")


@pytest.fixture(scope="session")
def bundled(tmp_path_factory):
    """Return a cached function that evolves a preset for one generation and returns the run."""

    from gaitsim.experiment import load_experiment

    @cache
    def run(preset):
        small = {"evolution.population": 21, "evolution.generations": 1}
        experiment = load_experiment(preset, small)
        return evolved(experiment, tmp_path_factory.mktemp("bundled") / preset)

    return run


@pytest.fixture
def puppet_run(puppet, tmp_path, monkeypatch):
    """Return a function that evolves an experiment of puppets and returns the run."""
    monkeypatch.chdir(tmp_path)
    return lambda *overrides: evolved(puppet(*overrides), Path("run"))


@pytest.fixture
def here(tmp_path, monkeypatch, puppets):
    """Change to a temporary folder; install puppets, also for other processes."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("PYTHONPATH", str(PUPPETS), prepend=os.pathsep)
    monkeypatch.setenv("XDG_CONFIG_HOME", str(tmp_path / "config"))
    return tmp_path


@pytest.fixture
def evolved_puppets(puppet, here):
    """Return a function that evolves puppets in a folder; it returns the run and its generations.

    It receives the folder, relative to the temporary one, and options of the experiment.
    """

    def record(folder, *options):
        kept = []
        return evolved(puppet(*options), here / folder, kept.append), kept

    return record


@pytest.fixture
def walk(here, puppet):
    """Return a function that creates a run of puppets evolved up to a generation."""
    from gaitsim.evaluation import evaluate
    from gaitsim.storage.creation import create_run
    from gaitsim.storage.writer import RunWriter

    def walk(name="walk", generation=3, *overrides, generations=5):
        experiment = puppet(f"evolution.generations={generations}", *overrides)
        path = create_run(experiment, Path("runs") / name)
        if generation:
            with RunWriter.open(path) as writer:
                for made in writer.evolve(partial(evaluate, writer.experiment)):
                    if made.number == generation:
                        break
        return path

    return walk
