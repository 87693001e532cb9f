"""Fixtures that read experiments and their problems."""

import tomllib

import pytest
import tomlkit

from gaitsim.errors import ExperimentError
from gaitsim.experiment import parse_assignments, parse_experiment
from gaitsim.registry.loading import read_preset


@pytest.fixture(scope="session")
def parsed():
    """Read an experiment after changes: the spider's, or that of a text."""

    def parsed(*overrides, text=None):
        text = read_preset("spider-genetic") if text is None else text
        return parse_experiment(text, "x.toml", parse_assignments(overrides))

    return parsed


@pytest.fixture(scope="session")
def problems():
    """Read an invalid experiment; return all problems."""

    def problems(*overrides, text=None):
        text = read_preset("spider-genetic") if text is None else text
        with pytest.raises(ExperimentError) as raised:
            parse_experiment(text, "x.toml", parse_assignments(overrides))
        found = raised.value.problems
        assert all(problem.what and problem.where for problem in found)
        return found

    return problems


@pytest.fixture(scope="session")
def problem(problems):
    """Read an experiment with one problem; return it."""

    def problem(*overrides, text=None):
        found = problems(*overrides, text=text)
        assert len(found) == 1, [str(one) for one in found]
        return found[0]

    return problem


@pytest.fixture(scope="session")
def custom():
    """The TOML of the spider's experiment with other plugins: kind = name."""

    def custom(**sections):
        data = tomllib.loads(read_preset("spider-genetic"))
        data.update({kind: {"plugin": name} for kind, name in sections.items()})
        return tomlkit.dumps(data)

    return custom
