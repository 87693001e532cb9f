"""The wheel and the sdist: their content, and the wheel in a clean environment."""

import hashlib
import os
import subprocess
import sys
import tarfile
import venv
import zipfile
from collections.abc import Iterator
from email import message_from_string
from importlib.metadata import Distribution, distribution
from pathlib import Path

import pytest
import yaml
from packaging.requirements import Requirement

pytestmark = pytest.mark.slow

ROOT = Path(__file__).parents[1]
PACKAGES = [ROOT / "gaitsim", *sorted((ROOT / "plugins").glob("gaitsim_*"))]
MEGABYTE = 1_000_000


@pytest.fixture(scope="module")
def built(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a folder with the wheel and the sdist."""
    return build(ROOT, tmp_path_factory.mktemp("dist"))


@pytest.fixture(scope="module")
def wheel(built: Path) -> Path:
    (path,) = built.glob("*.whl")
    return path


@pytest.fixture(scope="module")
def sdist(built: Path) -> Path:
    (path,) = built.glob("*.tar.gz")
    return path


def build(sources: Path, folder: Path) -> Path:
    command = [sys.executable, "-m", "hatchling", "build", "-d", str(folder)]
    subprocess.run(command, cwd=sources, check=True, capture_output=True)
    return folder


def content(wheel: Path) -> dict[str, str]:
    """Return the checksums of a wheel's files."""
    with zipfile.ZipFile(wheel) as archive:
        return {name: hashlib.sha256(archive.read(name)).hexdigest() for name in archive.namelist()}


def metadata(wheel: Path):
    with zipfile.ZipFile(wheel) as archive:
        (name,) = (name for name in archive.namelist() if name.endswith(".dist-info/METADATA"))
        return message_from_string(archive.read(name).decode())


def test_the_wheel_contains_only_the_packages(wheel: Path) -> None:
    found = {name for name in content(wheel) if ".dist-info/" not in name}
    files = {
        path.relative_to(package.parent).as_posix()
        for package in PACKAGES
        for path in package.rglob("*")
        if path.is_file() and "__pycache__" not in path.parts
    }
    assert found == files
    assert {f"{package.name}/py.typed" for package in PACKAGES} <= found
    assert wheel.stat().st_size < 3 * MEGABYTE


def test_the_wheel_contains_all_licences(wheel: Path) -> None:
    licences = {ROOT / "LICENSE"}
    licences |= {
        path for package in PACKAGES for path in package.rglob("*") if "LICENSE" in path.name
    }
    found = {name.partition("/licenses/")[2] for name in content(wheel) if "/licenses/" in name}
    assert found == {path.relative_to(ROOT).as_posix() for path in licences}


def test_all_files_have_the_same_version(wheel: Path) -> None:
    version = metadata(wheel)["Version"]
    citation = yaml.safe_load((ROOT / "CITATION.cff").read_text())
    assert citation["version"] == version
    assert wheel.name == f"gaitsim-{version}-py3-none-any.whl"


def test_the_sdist_contains_only_the_sources(sdist: Path) -> None:
    with tarfile.open(sdist) as archive:
        names = {name.partition("/")[2] for name in archive.getnames()}
    assert {
        "CHANGELOG.md",
        "CITATION.cff",
        "LICENSE",
        "PKG-INFO",
        "README.md",
        "SECURITY.md",
        "docs/index.md",
        "hatch_build.py",
        "pyproject.toml",
        "tests/test_package.py",
    } <= names
    parts = {part for name in names for part in name.split("/")}
    assert not parts & {"__pycache__", "node_modules", ".git", ".venv", "site", "dist"}
    assert sdist.stat().st_size < 8 * MEGABYTE


def test_the_sdist_builds_the_same_wheel(sdist: Path, wheel: Path, tmp_path: Path) -> None:
    with tarfile.open(sdist) as archive:
        archive.extractall(tmp_path, filter="data")
    (sources,) = tmp_path.iterdir()
    (again,) = build(sources, tmp_path / "dist").glob("*.whl")
    assert content(again) == content(wheel)


def required(distribution_name: str, extras: frozenset[str], seen: set[str]) -> Iterator[str]:
    """Yield a distribution and its direct and indirect requirements."""
    if distribution_name in seen:
        return
    seen.add(distribution_name)
    yield distribution_name
    for line in distribution(distribution_name).requires or ():
        requirement = Requirement(line)
        wanted = (
            (requirement.marker.evaluate({"extra": extra}) for extra in ("", *extras))
            if requirement.marker
            else [True]
        )
        if any(wanted):
            yield from required(requirement.name, frozenset(requirement.extras), seen)


@pytest.fixture(scope="module")
def installed(wheel: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Install the wheel in a new environment with links to its requirements; return the program.

    The environment has no other packages and no sources, so that undeclared requirements fail.
    """
    folder = tmp_path_factory.mktemp("installed") / "venv"
    venv.create(folder, with_pip=False, symlinks=True)
    (packages,) = folder.glob("lib/python*/site-packages")
    for name in required("gaitsim", frozenset(), set()):
        if name != "gaitsim":
            link(distribution(name), packages)
    install = ["install", "--quiet", "--no-deps", "--no-index", "--no-compile"]
    target = ["--python", str(folder / "bin" / "python"), *install, str(wheel)]
    subprocess.run([sys.executable, "-m", "pip", *target], check=True)
    return folder / "bin" / "gaitsim"


def link(package: Distribution, folder: Path) -> None:
    """Link the modules and the metadata of an installed package into a folder."""
    for name in {path.parts[0] for path in package.files or ()} - {"..", "__pycache__"}:
        if not (folder / name).exists():
            (folder / name).symlink_to(Path(str(package.locate_file(name))).resolve())


IMPORT_ALL = """
import importlib, pathlib, sys
import gaitsim

root = pathlib.Path(gaitsim.__file__).parents[1]
missing = set()
for package in sorted(root.glob("gaitsim*/")):
    for path in sorted(package.rglob("*.py")):
        parts = path.relative_to(root).with_suffix("").parts
        if "__main__" not in parts:
            try:
                importlib.import_module(".".join(parts).removesuffix(".__init__"))
            except ModuleNotFoundError as error:
                missing.add(error.name)
print(*sorted(missing))
"""
EXTRAS = {"aiohttp", "dask", "distributed", "pybullet", "tensorboardX", "textual_serve"}


def test_all_modules_of_the_wheel_import_without_extras(installed: Path, tmp_path: Path) -> None:
    python = installed.with_name("python")
    done = subprocess.run(
        [python, "-c", IMPORT_ALL], cwd=tmp_path, capture_output=True, text=True, check=True
    )
    assert {*done.stdout.split()} <= EXTRAS


def test_the_wheel_alone_runs_the_commands_of_the_readme(installed: Path, tmp_path: Path) -> None:
    def program(*arguments: str) -> str:
        environment = {"PATH": os.environ["PATH"], "HOME": str(tmp_path), "COLUMNS": "100"}
        done = subprocess.run(
            [installed, *arguments],
            cwd=tmp_path,
            env=environment,
            capture_output=True,
            text=True,
            check=False,
        )
        assert done.returncode == 0, (arguments, done.stderr)
        return done.stdout

    assert program("--version").startswith("gaitsim ")
    program("run", "spider", "--population", "20", "--generations", "2", "--workers", "1")
    for arguments in (
        ["analyse", "spider"],
        ["plot", "spider", "--kind", "fitness"],
        ["video", "spider", "--size", "160x90", "--fps", "1", "--speed", "4", "--no-intro"],
        ["play", "spider", "--at", "1"],
        ["export", "spider", "--format", "mat"],
        ["export", "spider", "--format", "npz"],
        ["resume", "spider", "--generations", "3", "--workers", "1"],
        ["runs"],
        ["experiments", "list"],
    ):
        program(*arguments)
