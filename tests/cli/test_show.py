import pytest
from run_helpers import strict

from gaitsim.storage.files.history import best_terms
from gaitsim.storage.snapshot import RunSnapshot


@pytest.fixture
def unstarted(puppet, tmp_path):
    """A run without a generation."""
    from gaitsim.storage.creation import create_run

    return create_run(puppet(), tmp_path / "runs/unstarted")


def test_a_run_is_shown_in_full(gaitsim, finished):
    shown = gaitsim("show", "puppet")
    assert shown.stderr == ""
    assert "\x1b" not in shown.stdout
    for text in (
        "runs/puppet",
        "seed 1  organism puppet  fitness puppet-reach  search genetic  selection puppet-best",
        "generation 5 of 5, 30 evaluations in ",
        "Champion of generation ",
        "how far it reaches",
        "score = reach ",
    ):
        assert text in shown.stdout
    assert gaitsim("show", "runs/puppet").stdout == shown.stdout


def test_json_agrees_with_the_files_of_the_run(gaitsim, finished, puppets):
    shown = strict(gaitsim("show", "puppet", "--json").stdout)
    run = RunSnapshot(finished)
    best = run.individual()
    generation, score = best.generation, best.score
    assert shown["champion"]["generation"] == generation
    assert shown["champion"]["score"] == score
    assert shown["champion"]["terms"] == best_terms(run.history, generation)
    assert list(shown["champion"]["measures"]) == ["reach"]
    assert shown["plugins"]["organism"] == "puppet"
    assert (shown["generation"], shown["generations"], shown["evaluations"]) == (5, 5, 30)
    assert shown["seconds"] == run.history["seconds"].sum()
    assert shown["fingerprint"] == run.fingerprint()
    printed = gaitsim("show", "puppet", "--fingerprint").stdout
    assert printed == run.fingerprint() + "\n"
    assert strict(gaitsim("show", "puppet", "--fingerprint", "--json").stdout) == {
        "run": "runs/puppet",
        "fingerprint": run.fingerprint(),
    }


def test_a_run_without_a_generation_is_shown(gaitsim, unstarted):
    shown = gaitsim("show", "unstarted")
    assert (
        "No generation is finished yet. To continue: gaitsim resume runs/unstarted" in shown.stdout
    )
    shown = strict(gaitsim("show", "unstarted", "--json").stdout)
    assert (shown["generation"], shown["champion"], shown["fingerprint"]) == (0, None, None)
    for arguments in (
        ("show", "unstarted", "--fingerprint"),
        ("export", "unstarted"),
        ("plot", "unstarted"),
    ):
        done = gaitsim(*arguments, code=2)
        assert done.stdout == ""
        assert "the run runs/unstarted has no finished generation yet" in done.stderr
        assert "gaitsim resume runs/unstarted" in done.stderr


def test_damaged_runs_are_listed_too(gaitsim, finished, unstarted, tmp_path, puppets):
    root = tmp_path / "runs"
    for name, text in [
        ("foreign", "this is not TOML ["),
        ("other", "a = 1"),
        ("binary", "\0"),
        ("[red]odd", "[organism]\nplugin = 3\n[fitness]\nplugin = 4\n[evolution]\npopulation = 1"),
    ]:
        (root / name).mkdir()
        (root / name / "experiment.toml").write_text(text)
    damaged = root / "damaged"
    damaged.mkdir()
    for path in finished.iterdir():
        if path.is_file():
            (damaged / path.name).write_bytes(path.read_bytes())
    for name in ("population.pickle", "population.previous.pickle"):
        (damaged / name).write_bytes(b"damaged")
    (root / "folder").mkdir()
    (root / "file").touch()
    before = sorted(root.rglob("*"))
    rows = [strict(line) for line in gaitsim("runs", "--json").stdout.splitlines()]
    assert {row["run"]: row["state"] for row in rows} == {
        "puppet": "finished",
        "unstarted": "stopped",
        "foreign": "damaged",
        "other": "damaged",
        "binary": "damaged",
        "[red]odd": "damaged",
        "damaged": "damaged",
    }
    row = next(row for row in rows if row["run"] == "puppet")
    assert row["best"] == RunSnapshot(finished).history["best"].max()
    assert (row["generation"], row["generations"], row["organism"]) == (5, 5, "puppet")
    listed = gaitsim("runs").stdout
    assert "[red]odd" in listed
    assert "5/5" in listed
    assert sorted(root.rglob("*")) == before


@pytest.mark.parametrize("more", [(), ("--json",), ("--delete", "puppet", "--yes")])
def test_a_folder_that_cannot_hold_runs_is_rejected(gaitsim, finished, more):
    for root, says in [
        ("nope", "folder not found: nope"),
        ("runs/nope", "folder not found: runs/nope"),
        ("x" * 300, "folder not found: xxx"),
        ("runs/puppet", "try:     gaitsim show runs/puppet"),
    ]:
        done = gaitsim("runs", root, *more, code=2)
        assert says in done.stderr
        assert done.stdout == ""
    assert "Error: runs/puppet is a run\n" in done.stderr
    assert finished.is_dir()


@pytest.fixture(autouse=True)
def installed(puppets):
    """Install the puppets, which the tests themselves need to read runs."""


def test_measures_that_are_not_finite_are_null(gaitsim, finished, install, tmp_path):
    source = (
        "import numpy as np\nfrom gaitsim.contracts import Measure\nfrom gaitsim_puppets import "
        "Puppet\nclass Odd(Puppet):\n    def measures(self, motion):\n        return {'a': "
        "Measure(np.array([np.nan]), '', 'odd'), 'b': Measure(np.array([np.inf]), '', '[red]')}\n"
    )
    install("odd", source, {"organism": {"odd": "Odd"}})
    gaitsim("run", tmp_path / "puppet.toml", "--set", "organism.plugin=odd", "--out", "odd-run")
    shown = strict(gaitsim("show", "odd-run", "--json").stdout)
    assert shown["champion"]["measures"] == {"a": None, "b": None}
    assert "[red]" in gaitsim("show", "odd-run").stdout


def test_an_empty_folder_lists_no_runs(gaitsim, tmp_path):
    (tmp_path / "empty").mkdir()
    for arguments, root in [(("empty",), "empty"), ((), "runs"), (("runs/",), "runs")]:
        assert f"No runs in {root}." in gaitsim("runs", *arguments).stdout
        assert gaitsim("runs", *arguments, "--json").stdout == ""
    (tmp_path / "file").touch()
    assert "cannot list file: Not a directory" in gaitsim("runs", "file", code=2).stderr
