"""The packages that workers need: those that a run's bits depend on."""

from collections import defaultdict
from collections.abc import Callable, Iterable, Mapping
from importlib import metadata

from gaitsim.errors import GaitsimError
from gaitsim.experiment import Experiment
from gaitsim.registry import KINDS

Versions = dict[str, str]
"""By a package's name, '' where it is not installed."""


def needed(experiments: Iterable[Experiment]) -> Versions:
    """gaitsim, what it computes with, and the package of each plugin, as they are here."""
    names = {"gaitsim", "numpy", "numba"}
    for experiment in experiments:
        names |= {experiment.entries[kind].package for kind in KINDS}
    return {name: version for name, version in installed_among(sorted(names)).items() if version}


def installed_among(names: Iterable[str]) -> Versions:
    """The versions of packages in this process's environment."""
    return {name: _version(name) for name in names}


def _version(name: str) -> str:
    try:
        return metadata.version(name)
    except metadata.PackageNotFoundError:
        return ""


def asking(names: Iterable[str]) -> Callable[[], Versions]:
    """A function that finds versions where it is called, even where gaitsim is not installed.

    It is pickled whole, as no module has it.
    """
    wanted = sorted(names)

    def ask() -> Versions:
        from importlib import metadata

        found = {}
        for name in wanted:
            try:
                found[name] = metadata.version(name)
            except metadata.PackageNotFoundError:
                found[name] = ""
        return found

    return ask


def compare(here: Mapping[str, str], there: Mapping[str, Mapping[str, str]]) -> None:
    """Hold workers to the packages of here.

    Args:
        here: version by package.
        there: the same by worker.

    Raises:
        GaitsimError: a worker lacks one, or has it in another version.
    """
    differing: dict[tuple[str, str], list[str]] = defaultdict(list)
    for worker, versions in sorted(there.items()):
        for name, version in here.items():
            if versions.get(name, "") != version:
                differing[name, versions.get(name, "")].append(worker)
    if not differing:
        return
    told = [
        f"{name} {f'is {version}' if version else 'is not installed'} on {_those(workers)}, "
        f"but {here[name]} here"
        for (name, version), workers in sorted(differing.items())
    ]
    wanted = " ".join(f"{name}=={here[name]}" for name in sorted({name for name, _ in differing}))
    raise GaitsimError(
        "; ".join(told),
        allowed="the same versions everywhere, as the same bits depend on them",
        remedy=f"on the workers: pip install {wanted}",
    )


def _those(workers: list[str]) -> str:
    if len(workers) == 1:
        return f"the {workers[0]}"
    return f"{len(workers)} processes such as the {workers[0]}"
