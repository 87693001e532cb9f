"""Whatever the files of a run contain, a command ends with a result or one message."""

import shutil

import pytest
from typer.testing import CliRunner

from gaitsim.errors import GaitsimError
from gaitsim.live.watcher import RunWatcher
from gaitsim.storage.files import safe_pickle

COMMANDS = (
    "show RUN",
    "show RUN --json",
    "verify RUN --all --workers 1",
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


def changed(**values):
    """Return a function that changes values of a checkpoint of a run that lacks a plugin."""

    def change(run):
        replaced("experiment.toml", "puppet-mean", "not-installed")(run)
        for name in ("population.pickle", "population.previous.pickle"):
            content = safe_pickle.load(run / name)
            (run / name).write_bytes(safe_pickle.dumps(content | values))

    return change


def replaced(file, old, new):
    def change(run):
        text = (run / file).read_text()
        assert old in text
        (run / file).write_text(text.replace(old, new))

    return change


# Each of these once caused a traceback, a hang or silence in a command or the terminal UI. Readers
# of single files have their own tests.
FOUND = {
    "infinite seed": replaced("experiment.toml", "seed = 1", "seed = inf"),
    "a name that is a list": replaced("experiment.toml", 'name = "puppet"', "name = [1]"),
    "another experiment": replaced("experiment.toml", "population = 6", "population = 8"),
    "other islands": replaced("experiment.toml", "number = 2", "number = 3"),
    "a term renamed": replaced("history.csv", "reach", "reached"),
    "another island": replaced("islands.csv", "island 2", "island 3"),
    "versions without a name": changed(versions={" ": "x"}),
    "many evaluations": changed(evaluations=2**62),
    "a late generation": changed(generation=2**53),
    "much stagnation": changed(stagnation=99),
    "a different experiment": changed(experiment="a = 1"),
    "no terms": changed(terms={}),
}


@pytest.mark.parametrize("change", FOUND.values(), ids=FOUND.keys())
def test_cases_that_once_failed_are_one_message(run, invoke, change):
    change(run)
    check_commands(run, invoke, "show RUN --json", "differences RUN", "verify RUN")
    assert invoke("resume", run, "--generations", 5)[0] == 2


@pytest.mark.parametrize(
    "text",
    ['[{"first": 1, "parts": null}]', '[{"first": 1, "parts": {"numpy": null}}]', "[" * 100_000],
    ids=["no parts", "no version", "deep"],
)
def test_damaged_provenance_does_not_prevent_resuming(run, invoke, text):
    (run / "provenance.json").write_text(text)
    assert invoke("verify", run, "--workers", 1)[0] == 2
    check_commands(run, invoke, "resume RUN --generations 5 --workers 1")


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
