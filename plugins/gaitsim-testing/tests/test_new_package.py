"""A new package works as it is; what cannot be made leaves nothing behind."""

import os
import subprocess
import sys
import tomllib

import pytest

from gaitsim.errors import GaitsimError
from gaitsim.registry import PLUGINS
from gaitsim_testing.scaffold import new_package


@pytest.mark.slow
@pytest.mark.parametrize("kind", PLUGINS)
def test_a_new_package_passes_the_check_and_its_own_tests(tmp_path, kind):
    folder = new_package("two-legs", kind, tmp_path)
    assert folder == tmp_path / "two-legs"
    assert [path.name for path in tmp_path.iterdir()] == ["two-legs"]
    done = subprocess.run(
        [sys.executable, "-m", "pytest", "-v", "-p", "no:cacheprovider"],
        cwd=folder,
        capture_output=True,
        text=True,
        timeout=200,
        check=False,
    )
    assert done.returncode == 0, done.stdout
    assert f"{kind}-two-legs" in done.stdout
    assert "$" not in "".join(
        p.read_text() for p in folder.rglob("*") if p.suffix in (".py", ".toml")
    )


def test_an_organism_comes_with_a_fitness_and_an_experiment(tmp_path):
    folder = new_package("gaitsim-hopper", "organism", tmp_path)
    project = tomllib.loads((folder / "pyproject.toml").read_text())["project"]
    assert project["name"] == "gaitsim-hopper"
    points = {kind.removeprefix("gaitsim."): [*of] for kind, of in project["entry-points"].items()}
    assert points == {
        "organism": ["hopper"],
        "fitness": ["hopper-distance"],
        "experiments": ["hopper"],
    }
    assert "plugins check" in (folder / "README.md").read_text()


@pytest.mark.parametrize(
    "name", ["organism", "genomes", "option", "np", "self", "class", "real-space"]
)
def test_names_that_mean_something_in_python_do_no_harm(tmp_path, name):
    folder = new_package(name, "organism", tmp_path)
    (file,) = folder.glob("src/*/__init__.py")
    names = {}
    exec(compile(file.read_text(), str(file), "exec"), names)
    assert names["Distance"]().needs == ("joint_angles", "feet")


BAD = {
    "": "a name such as 'two-legs'",
    "Hopper": "'hopper'",
    "two_legs": "'two-legs'",
    "two legs": "'two-legs'",
    "2legs": "'legs'",
    "-hopper": "'hopper'",
    "hop--per": "'hop-per'",
    "../hopper": "'hopper'",
    "hopper/": "'hopper'",
    "höpper": "'h-pper'",
    "a" * 41: "",
    "gaitsim-": "",
    "\n": "a name such as 'two-legs'",
}


@pytest.mark.parametrize(("name", "remedy"), BAD.items(), ids=repr)
def test_a_name_that_cannot_be_a_packages_is_refused(tmp_path, name, remedy):
    with pytest.raises(GaitsimError, match="invalid name for a plugin") as raised:
        new_package(name, "organism", tmp_path)
    assert remedy in raised.value.remedy
    assert "lowercase letters" in raised.value.allowed
    assert list(tmp_path.iterdir()) == []


TAKEN = {
    "spider": "organism of package gaitsim",
    "gaitsim-spider": "organism of package gaitsim",
    "truncation": "selection of package gaitsim",
    "fly-hover": "preset of package gaitsim",
    "operators": "gaitsim_operators is already installed",
}


@pytest.mark.parametrize(("name", "says"), TAKEN.items())
def test_a_name_that_is_taken_is_refused(tmp_path, name, says):
    with pytest.raises(GaitsimError, match=r"taken|already installed") as raised:
        new_package(name, "fitness", tmp_path)
    assert says in raised.value.what
    assert list(tmp_path.iterdir()) == []


def test_an_unknown_kind_is_refused(tmp_path):
    with pytest.raises(GaitsimError, match="organsim") as raised:
        new_package("hopper", "organsim", tmp_path)
    assert raised.value.remedy == "did you mean 'organism'?"
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("make", ["mkdir", "touch", "dangling"])
def test_what_is_there_already_is_left_alone(tmp_path, make):
    folder = tmp_path / "hopper"
    folder.symlink_to("nowhere") if make == "dangling" else getattr(folder, make)()
    with pytest.raises(GaitsimError, match="already exists"):
        new_package("hopper", "organism", tmp_path)
    assert list(tmp_path.iterdir()) == [folder]


def test_a_disk_that_fails_leaves_nothing(tmp_path, monkeypatch):
    from pathlib import Path

    real = Path.write_text

    def full(self, text, **options):
        if self.name == "__init__.py":
            raise OSError(28, "No space left on device")
        return real(self, text, **options)

    monkeypatch.setattr(Path, "write_text", full)
    with pytest.raises(GaitsimError, match="No space left"):
        new_package("hopper", "organism", tmp_path)
    assert list(tmp_path.iterdir()) == []


def test_a_folder_that_is_not_there(tmp_path):
    with pytest.raises(GaitsimError, match="cannot write") as raised:
        new_package("hopper", "organism", tmp_path / "none")
    assert raised.value.remedy
    assert os.listdir(tmp_path) == []  # noqa: PTH208


def test_it_can_be_read_by_others(tmp_path):
    folder = new_package("hopper", "fitness", tmp_path)
    assert folder.stat().st_mode & 0o755 == 0o755
