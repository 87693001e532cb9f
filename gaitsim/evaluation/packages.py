"""The packages that workers need: those that determine the bits of a run's results."""

from collections import defaultdict
from collections.abc import Callable, Iterable, Mapping

from gaitsim.errors import GaitsimError
from gaitsim.experiment import Experiment

Versions = dict[str, str]
"""Versions by package; '' for a package that is not installed."""


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
    """Check that workers have the local versions of packages.

    Args:
        here: local versions by package.
        there: versions of each worker by package, by the name of the worker.
    """
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
