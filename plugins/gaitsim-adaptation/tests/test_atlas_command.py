"""`gaitsim atlas`."""

import json


def test_the_summary_reports_how_much_of_the_atlas_is_filled(gaitsim, tmp_path):
    axes = "duty factor,yaw=-90:90"
    small = "--cells", "4x5", "--generations", 2, "--population", 10
    shown = gaitsim("atlas", "spider-genetic", "--axes", axes, *small).stdout
    assert (tmp_path / "runs/spider-genetic-atlas").is_dir()
    assert "of 20 cells" in shown
    assert "QD score" in shown
    assert "--member" in shown
    table = gaitsim("members", "spider-genetic-atlas", "--gaits", "--json").stdout.splitlines()
    rows = [json.loads(row) for row in table]
    assert [*rows[0]][:6] == ["member", "score", "duty factor", "yaw", "gait", "stride frequency"]
    assert all(isinstance(row["gait"], str) for row in rows)
