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


def test_a_folder_that_cannot_hold_runs_is_rejected(gaitsim, finished):
    for more in ((), ("--delete", "puppet", "--yes")):
        assert "folder not found: nope" in gaitsim("runs", "nope", *more, code=2).stderr
        done = gaitsim("runs", "runs/puppet", *more, code=2)
        assert "try:     gaitsim show runs/puppet" in done.stderr
        assert done.stdout == ""
    assert finished.is_dir()


@pytest.fixture(autouse=True)
def installed(puppets):
    """Install the puppets, which the tests themselves need to read runs."""


def test_an_empty_folder_lists_no_runs(gaitsim, tmp_path):
    (tmp_path / "empty").mkdir()
    for arguments, root in [(("empty",), "empty"), ((), "runs"), (("runs/",), "runs")]:
        assert f"No runs in {root}." in gaitsim("runs", *arguments).stdout
        assert gaitsim("runs", *arguments, "--json").stdout == ""
    (tmp_path / "file").touch()
    assert "cannot list file: Not a directory" in gaitsim("runs", "file", code=2).stderr
