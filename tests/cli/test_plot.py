"""`gaitsim plot`."""

import pytest


@pytest.mark.parametrize(
    ("options", "says"),
    [
        (("--kind", "nothing"), "search, stability, terms, all"),
        (("--kind", "fitness", "--generation", 2), "has no option --generation"),
        (("--kind", "terms", "--channel", "a", "--window", "1:2"), "--window and --channel"),
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
