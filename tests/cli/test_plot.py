"""`gaitsim plot`."""

import subprocess
import sys

import pytest


@pytest.mark.parametrize(
    ("options", "says"),
    [
        (("--kind", "nothing"), "search, stability, terms, all"),
        (("--kind", "footfall"), "has no feet to plot"),
        (("--kind", "fitness", "--generation", 2), "has no option --generation"),
        (("--kind", "terms", "--channel", "a", "--window", "1:2"), "--window and --channel"),
        (("--kind", "channel", "--channel", "[red]"), "has no channel '[red]'"),
        (("--kind", "joints", "--window", "2:1"), "'2:1'"),
        (("--kind", "joints", "--out", "a.gif"), "unknown extension for plots"),
        (("--out", "a.png", "--format", "svg"), "ends with .png"),
        (("--kind", "all", "--out", "puppet.toml"), "puppet.toml is a file"),
    ],
)
def test_invalid_input_is_one_message_and_writes_nothing(
    gaitsim, finished, tmp_path, options, says
):
    before = sorted(tmp_path.rglob("*"))
    done = gaitsim("plot", "puppet", *options, code=2)
    assert says in " ".join(done.stderr.replace("│", " ").split())
    assert done.stdout == ""
    exports = tmp_path / "runs" / "puppet" / "exports"
    assert [path for path in sorted(tmp_path.rglob("*")) if path != exports] == [
        path for path in before if path != exports
    ]


@pytest.mark.slow
def test_kind_all_draws_applicable_kinds_and_names_the_others(gaitsim, finished, tmp_path):
    done = gaitsim("plot", "puppet", "--kind", "all", "--generation", 2, "--format", "svg")
    names = ["diversity", "fitness", "genome", "terms", "joints-generation-2"]
    names += ["path-generation-2"]
    assert done.stdout.splitlines() == [f"runs/puppet/exports/{name}.svg" for name in names]
    assert all((tmp_path / line).exists() for line in done.stdout.splitlines())
    assert "No plot of kind 'channel': 'joints' draws the channel 'joint_angles'" in done.stderr
    assert "No plot of kind 'footfall': organism 'puppet'" in done.stderr
    for kind in ("stability", "phase", "search", "front", "parallel", "archive"):
        assert f"No plot of kind {kind!r}" in done.stderr


def test_a_body_of_one_frame_has_plots_of_scores(gaitsim, install, working, puppet_file):
    install("still", working, {"organism": {"body": "Body"}, "fitness": {"far": "Distance"}})
    gaitsim(
        *("run", puppet_file, "--set", "organism.plugin=body"),
        *("--set", "fitness.plugin=far", "--out", "flights"),
    )
    done = gaitsim("plot", "flights", "--kind", "all")
    names = ("diversity", "fitness", "genome", "terms")
    assert done.stdout.split() == [f"flights/exports/{name}.png" for name in names]
    assert "has no channel over time" in done.stderr
    assert "only one frame" in done.stderr


@pytest.mark.slow
def test_an_unknown_backend_of_matplotlib_does_not_matter(walk, monkeypatch):
    monkeypatch.setenv("MPLBACKEND", "nonsense")
    line = [sys.executable, "-m", "gaitsim", "plot", str(walk()), "--kind", "fitness"]
    assert subprocess.run(line, check=False, capture_output=True).returncode == 0
