"""Experiments in a form that can be sent to workers, which need the same packages."""

import gc
import socket
import sys
from collections import defaultdict
from collections.abc import Callable, Iterable, Mapping
from functools import lru_cache
from pathlib import Path
from tempfile import NamedTemporaryFile
from typing import IO

import numpy as np

from gaitsim.errors import GaitsimError
from gaitsim.evaluation.scoring import constrain, evaluate_here
from gaitsim.evaluation.worlds import draw_worlds, in_world
from gaitsim.experiment import Experiment, parse_experiment
from gaitsim.registry import plugin_errors
from gaitsim.registry.python_plugins import pickled, register_pickled

Versions = dict[str, str]
"""Versions by package; '' for a package that is not installed."""

State = tuple[str, tuple[tuple[str, str], ...], bytes | str]
"""An experiment's TOML, its packages with their versions, and its pickled Python functions.

The functions are bytes, or the path of a file with the bytes.
"""

LEAST_MEMORY = 700_000_000  # bytes of address space; the spider was seen to need 450 to 700 MB
LARGE = 2**18
"""Size in bytes from which processes of this machine read functions from a file.

Otherwise, every chunk of a population would send the data that a function uses: with 20 MB, two
workers took longer than this process for 40 individuals of 20 ms each.
"""


def required_versions(experiments: Iterable[Experiment]) -> Versions:
    """Return the local versions of gaitsim, NumPy, Numba, and the package of each plugin."""
    names = {"gaitsim", "numpy", "numba"}
    for experiment in experiments:
        names |= {experiment.entries[kind].package for kind in experiment.kinds}
    return {name: version for name, version in version_finder(names)().items() if version}


def version_finder(names: Iterable[str]) -> Callable[[], Versions]:
    """Return a function that finds the versions of packages, even in a process without gaitsim.

    The function is pickled by value, because it does not belong to a module.
    """
    packages = sorted(names)

    def find() -> Versions:
        from importlib import metadata

        found = {}
        for name in packages:
            try:
                found[name] = metadata.version(name)
            except metadata.PackageNotFoundError:
                found[name] = ""
        return found

    return find


def check_versions(here: Mapping[str, str], there: Mapping[str, Mapping[str, str]]) -> None:
    """Check that workers have the local versions of packages."""
    # Workers by package and differing version.
    differing: dict[tuple[str, str], list[str]] = defaultdict(list)
    for worker, versions in sorted(there.items()):
        for name, version in here.items():
            if versions.get(name, "") != version:
                differing[name, versions.get(name, "")].append(worker)
    if not differing:
        return
    problems = [
        f"{name} {f'is {version}' if version else 'is not installed'} on "
        f"{_describe_workers(workers)}, but {here[name]} here"
        for (name, version), workers in sorted(differing.items())
    ]
    required = " ".join(f"{name}=={here[name]}" for name in sorted({name for name, _ in differing}))
    raise GaitsimError(
        "; ".join(problems),
        allowed="the same versions everywhere; otherwise, results may not be identical bit for bit",
        remedy=f"on the workers: pip install {required}",
    )


def _describe_workers(workers: list[str]) -> str:
    if len(workers) == 1:
        return f"the {workers[0]}"
    return f"{len(workers)} processes such as the {workers[0]}"


class SerializedExperiment:
    """An experiment that is pickled as TOML, with the Python functions that it names.

    Each worker process parses it once.

    Args:
        experiment: the experiment.
        remote: whether workers may run on other machines, without access to this one's files.
    """

    def __init__(self, experiment: Experiment, *, remote: bool = True) -> None:
        self._experiment: Experiment | None = experiment
        self._state: State | None = None
        self._remote = remote
        self._file: IO[bytes] | None = None  # deleted together with this object

    def __getstate__(self) -> "State":
        if self._state is None:
            experiment = self.experiment
            versions = tuple(required_versions([experiment]).items())
            code = pickled(experiment.outside) if experiment.outside else b""
            functions: bytes | str = code
            if len(code) > LARGE and not self._remote:
                self._file = NamedTemporaryFile(prefix="gaitsim-")  # noqa: SIM115 - outlives the call
                self._file.write(code)
                self._file.flush()
                functions = self._file.name
            self._state = experiment.to_toml(), versions, functions
        return self._state

    def check(self) -> None:
        """Check that workers can receive the Python functions of the experiment.

        Raises:
            GaitsimError: a function cannot be pickled.
        """
        self.__getstate__()

    def __setstate__(self, state: "State") -> None:
        self._experiment, self._state = None, state

    @property
    def experiment(self) -> Experiment:
        """The experiment, ready to evaluate; in its original process, the same object."""
        return self._experiment or _parse(*self.__getstate__())


@lru_cache(maxsize=4)
def _parse(toml: str, packages: tuple[tuple[str, str], ...], functions: bytes | str) -> Experiment:
    # This worker may have joined after the packages of all workers were checked.
    required = dict(packages)
    check_versions(required, {f"worker on {socket.gethostname()}": version_finder(required)()})
    if functions:
        register_pickled(
            functions if isinstance(functions, bytes) else Path(functions).read_bytes()
        )
    experiment = parse_experiment(toml, "the experiment")
    prepare(experiment)
    return experiment


def _check_memory() -> None:
    """Check that the process may use enough memory to compile kernels.

    With less, LLVM ends the process without a message, or waits forever.
    """
    if sys.platform == "win32":
        return
    import resource

    allowed, _ = resource.getrlimit(resource.RLIMIT_AS)
    if 0 <= allowed < LEAST_MEMORY:
        raise GaitsimError(
            f"this process may use only {allowed / 1e6:,.0f} MB of memory",
            where="the limit set by 'ulimit -v'",
            allowed=f"at least {LEAST_MEMORY / 1e6:,.0f} MB; robots need more",
            remedy="ulimit -v unlimited",
        )


def prepare(experiment: Experiment, individuals: int = 1) -> None:
    """Evaluate random genomes in one world, so that this process compiles or loads its kernels.

    A body that is a user's code is not called: its calls may be slow, and users count them.
    """
    _check_memory()
    if experiment.body_outside:
        return
    with plugin_errors(experiment.entries["organism"], "drawing genomes"):
        space = experiment.organism.genome_space()
        genomes = space.random(individuals, np.random.default_rng(0))
    worlds = draw_worlds(experiment, 1) if experiment.worlds.count else ()
    if worlds:
        experiment = in_world(experiment, worlds[0])
    # Compiling creates many objects that live on; 10% of the time would go to the collector.
    collecting = gc.isenabled()
    gc.disable()
    try:
        constrain(experiment, evaluate_here(experiment, genomes))
    finally:
        if collecting:
            gc.enable()
