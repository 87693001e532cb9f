"""Whatever the files of a run contain, a command ends with a result or one message."""

import random
import shutil

import pytest
from mutations import mutations, mutations_of_values
from typer.testing import CliRunner

from gaitsim.errors import GaitsimError
from gaitsim.live.watching import RunWatcher
from gaitsim.runs.files import safe_pickle

COMMANDS = (
    "show RUN",
    "show RUN --json",
    "verify RUN --generations 1,3 --workers 1",
    "verify RUN --json --workers 1",
    "differences RUN RUN --by seconds",
    "differences RUN --json",
    "plot RUN --kind fitness --out plot.svg",
    "plot RUN --kind terms --out plot.svg",
    "analyse RUN",
    "export RUN --format csv --out gait.csv",
    "fork RUN --out copy",
    "resume RUN --generations 6 --workers 1",
    "resume RUN --generations 7 --set mutation.plugin=none --workers 1",
)
OPTIONS = (
    *("--generations", 4, "--set", "islands.number=2", "--set", "evolution.fitness_threshold=0"),
    *("--workers", 1),
)


@pytest.fixture(scope="module")
def folder_of_runs(tmp_path_factory):
    """Return a folder that holds the runs, which are evolved once."""
    return tmp_path_factory.mktemp("made") / "runs"


@pytest.fixture
def run(gaitsim, folder_of_runs, puppet_file, tmp_path):
    """Return a run of four generations on two islands; a second run beside it stays unchanged."""
    if not folder_of_runs.exists():
        gaitsim("run", puppet_file, *OPTIONS, "--out", folder_of_runs / "spoilt")
        shutil.copytree(folder_of_runs / "spoilt", folder_of_runs / "sound")
    shutil.copytree(folder_of_runs, tmp_path / "runs")
    return tmp_path / "runs/spoilt"


@pytest.fixture
def invoke():
    """Run a command in this process; return its exit code and output."""

    def invoke(*words):
        # Imported here, after the conftest has put the puppets on the path.
        from gaitsim.cli.app import app

        done = CliRunner().invoke(app, [str(word) for word in words])
        if isinstance(done.exception, GaitsimError):
            return 2, str(done.exception)
        if done.exception and not isinstance(done.exception, SystemExit):
            raise AssertionError(f"{words} ended with a traceback") from done.exception
        return done.exit_code, done.output

    return invoke


def check_commands(run, invoke, *commands):
    """Run commands on a run; the list of runs and the live view must not fail, either."""
    code, listed = invoke("runs", "runs", "--json")
    assert code == 0
    assert '"sound"' in listed
    RunWatcher(run).poll()
    for command in commands:
        invoke(*command.replace("RUN", str(run)).split())


def change_cell(column, value, generation=4):
    """Return a function that changes a cell of a table."""

    def change(text):
        lines = text.splitlines()
        cells = lines[generation].split(",")
        cells[lines[0].split(",").index(column)] = value
        lines[generation] = ",".join(cells)
        return "\n".join(lines) + "\n"

    return change


def replace_with(old, new):
    def change(text):
        assert old in text
        return text.replace(old, new)

    return change


# Each of these once caused a traceback, a hang or silence in a command or the terminal UI.
FOUND = {
    "evaluations that are not a number": ("history.csv", change_cell("evaluations", "nan")),
    "infinite evaluations": ("history.csv", change_cell("evaluations", "inf")),
    "infinite seconds": ("history.csv", change_cell("seconds", "inf")),
    "seconds that are not a number": ("history.csv", change_cell("seconds", "nan", 2)),
    "a term renamed": ("history.csv", replace_with("reach", "reached")),
    "a mean renamed": ("history.csv", replace_with("mean:reach", "mean:reached")),
    "a column twice": ("history.csv", replace_with("price,mean:reach", "reach,mean:reach")),
    "empty lines": ("history.csv", lambda text: "\n" * 1_000_000),
    "infinite best of an island": ("islands.csv", change_cell("island 2", "inf")),
    "scores too far apart": ("history.csv", change_cell("best", "-1e308", 2)),
    "infinite seed": ("experiment.toml", replace_with("seed = 1", "seed = inf")),
    "seed too large": ("experiment.toml", replace_with("seed = 1", "seed = 1e400")),
    "negative seed": ("experiment.toml", replace_with("seed = 1", "seed = -1")),
    "a name that is a list": ("experiment.toml", replace_with('name = "puppet"', "name = [1]")),
    "deep nesting": ("experiment.toml", lambda text: "a = " + "[" * 5000),
    "a very long list": ("experiment.toml", lambda text: f"a = [{'1,' * 300_000}]\n" + text),
    "another experiment": ("experiment.toml", replace_with("population = 6", "population = 8")),
    "other islands": ("experiment.toml", replace_with("number = 2", "number = 3")),
    "parts that are null": ("provenance.json", lambda text: '[{"first": 1, "parts": null}]'),
    "parts in a list": ("provenance.json", lambda text: '[{"first": 1, "parts": ["a"]}]'),
    "a version that is null": ("provenance.json", replace_with('"0.1.0"', "null")),
    "deep JSON": ("provenance.json", lambda text: "[" * 100_000),
}


@pytest.mark.parametrize(("name", "change"), FOUND.values(), ids=FOUND.keys())
def test_cases_that_once_failed_are_one_message(run, invoke, name, change):
    path = run / name
    path.write_text(change(path.read_text()))
    if name == "provenance.json":
        assert invoke("verify", run, "--workers", 1)[0] == 2
        check_commands(run, invoke, "resume RUN --generations 5 --workers 1")
        return
    check_commands(run, invoke, "show RUN --json", "differences RUN")
    assert invoke("resume", run, "--generations", 5)[0] == 2


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("versions", {" ": "x"}),
        ("evaluations", 2**62),
        ("generation", 2**53),
        ("stagnation", 99),
        ("experiment", "a = 1"),
        ("terms", {}),
    ],
)
def test_checkpoints_that_once_failed_are_one_message(run, invoke, name, value):
    for file in ("population.pickle", "population.previous.pickle"):
        content = safe_pickle.load(run / file)
        (run / file).write_bytes(safe_pickle.dumps(content | {name: value}))
    path = run / "experiment.toml"
    path.write_text(path.read_text().replace("puppet-mean", "not-installed"))
    check_commands(run, invoke, "show RUN --json", "differences RUN", "verify RUN")
    assert invoke("resume", run, "--generations", 5)[0] == 2


def test_too_many_terms_are_not_drawn(run, invoke):
    more = [f"term {number}" for number in range(60)]

    def with_columns(line, names, means):
        cells = line.split(",")
        return ",".join([*cells[:-2], *names, *cells[-2:], *means])

    path = run / "history.csv"
    head, *rows = path.read_text().splitlines()
    lines = [with_columns(head, more, [f"mean:{name}" for name in more])]
    lines += [with_columns(row, ["1.0"] * 60, ["1.0"] * 60) for row in rows]
    path.write_text("\n".join(lines) + "\n")
    check_commands(run, invoke, "show RUN")
    code, message = invoke("plot", run, "--kind", "terms")
    assert code == 2
    assert "62 terms, too many" in message


def test_files_of_a_different_run_are_rejected(run, gaitsim, invoke, puppet_file):
    gaitsim("run", puppet_file, "--generations", 2, "--out", "other")
    for name in ("population.pickle", "experiment.toml", "history.csv", "bests.bin"):
        kept = (run / name).read_bytes()
        shutil.copy(run.parents[1] / "other" / name, run / name)
        check_commands(run, invoke, "show RUN --json")
        assert invoke("verify", run, "--workers", 1)[0] != 0
        (run / name).write_bytes(kept)
    assert invoke("verify", run, "--workers", 1)[0] == 0


def changed_files(path, count, seed):
    if path.suffix != ".pickle":
        yield from mutations(path.read_bytes(), count, seed)
        return
    for values in mutations_of_values(safe_pickle.load(path), count, seed):
        try:
            yield safe_pickle.dumps(values)
        except ValueError:
            continue


@pytest.mark.slow
@pytest.mark.parametrize(
    "name",
    [
        *("experiment.toml", "history.csv", "islands.csv", "bests.bin", "checksums.bin"),
        *("provenance.json", "population.pickle", "population.previous.pickle"),
        "champions/generation-000001.pickle",
    ],
)
def test_commands_on_mutated_files_end_with_a_result_or_one_message(run, invoke, tmp_path, name):
    kept = shutil.copytree(run, tmp_path / "kept")
    for number, data in enumerate(changed_files(run / name, 15, sum(name.encode()))):
        shutil.rmtree(run)
        shutil.copytree(kept, run)
        (run / name).write_bytes(data)
        check_commands(run, invoke, *random.Random(number).sample(COMMANDS, 4))
