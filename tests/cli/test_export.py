"""`gaitsim export`; test_show covers the formats of joint angles."""

from itertools import chain

import pytest

from gaitsim.actions.action import SeveralIndividuals
from gaitsim.contracts.product import RESERVED
from gaitsim.inspecting import formats
from gaitsim.tui.products import forms


def table(path):
    return [line.split(",") for line in path.read_text().splitlines()]


@pytest.mark.packages
def test_angles_beyond_the_servos_are_an_error_or_clipped(gaitsim, finished, tmp_path):
    arguments = ("export", "puppet", "--format", "servo", "--out", "x.csv")
    limits = ("--min", -1, "--max", 1)
    said = gaitsim(*arguments, *limits, code=2).stderr
    assert "° at 1000 ms" in said
    assert "--clip" in said
    assert not (tmp_path / "x.csv").exists()
    said = gaitsim(*arguments, *limits, "--clip").stderr
    assert "were clipped" in said
    assert all(-1 <= float(cell) <= 1 for row in table(tmp_path / "x.csv")[1:] for cell in row[1:])


@pytest.mark.packages
@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        (("--format", "mat", "--clip"), "has no option --clip"),
        (("--keyframe-ms", 20, "--centre", 0), "--keyframe-ms and --centre"),
        (("--format", "servo", "--min", 10), "invalid servo range from 10° to 90°"),
        (("--format", "servo", "--calibration", "x", "--min", 0), "cannot be combined with --min"),
        (("--calibration-template", "x.toml"), "or use --format arduino, dynamixel, feetech"),
    ],
)
def test_contradictory_options_are_one_message(gaitsim, finished, arguments, says):
    assert says in gaitsim("export", "puppet", *arguments, code=2).stderr


@pytest.mark.parametrize("name", ["gait.xlsx", "gait.2"])
def test_a_wrong_extension_is_rejected(gaitsim, finished, tmp_path, name):
    before = sorted(tmp_path.iterdir())
    said = gaitsim("export", "puppet", "--out", name, code=2).stderr
    assert said.splitlines() == [
        f"Error: unknown extension for gaits: {name}",
        "  where:   --out",
        f"  allowed: {', '.join(formats())}",
        "  try:     change the extension, or add --format",
    ]
    assert sorted(tmp_path.iterdir()) == before
    gaitsim("export", "puppet", "--out", name, "--format", "npz")
    assert (tmp_path / name).read_bytes().startswith(b"PK")


@pytest.mark.packages
def test_a_filled_in_calibration_template_gives_a_sketch(gaitsim, finished, tmp_path):
    arguments = ("export", "puppet", "--format", "arduino")
    said = gaitsim(*arguments, "--clip").stderr
    assert "no calibration" in said
    gaitsim(*arguments, "--calibration-template", "robot.toml")
    path = tmp_path / "robot.toml"
    path.write_text(path.read_text().replace("-90.0", "-350.0").replace("90.0", "350.0"))
    said = gaitsim(*arguments, "--calibration", path, "--out", "walk", "--keyframe-ms", 50).stdout
    assert "walk: 21 keyframes × 3 joints every 50 ms" in said
    assert "126 bytes of flash" in said
    assert sorted(part.name for part in (tmp_path / "walk").iterdir()) == ["gait.h", "walk.ino"]
    # A calibration for a sketch does not suit bus servos, nor vice versa.
    said = gaitsim("export", "puppet", "--format", "feetech", "--calibration", path, code=2).stderr
    assert "id is required for feetech" in said
    assert "robot.toml" in said


BOARD = """
from typing import ClassVar
from gaitsim.contracts import Exported, Exporter, option

class Board(Exporter):
    "Angles for a board."
    title: ClassVar[str] = "My board"
    group: ClassVar[str] = "Files for robots"
    suffix: ClassVar[str] = ".board"
    channels: int = option(8, "number of channels", ge=1, le=16)

    def write(self, subject, path):
        path.write_text(f"{self.channels} {subject.individual.generation}")
        return Exported("angles")
"""


def test_a_package_adds_a_format_with_flags_and_a_form(gaitsim, finished, install, tmp_path):
    install("boards", BOARD, {"exporter": {"board": "Board"}})
    forms.cache_clear()
    text = " ".join(gaitsim("export", "--help").stdout.replace("│", " ").split())
    assert "--channels N [1<=x<=16] For --format board: number of channels. Default: 8." in text
    said = gaitsim("export", "puppet", "--out", "a.board", "--channels", 3).stdout
    assert said == "a.board: angles\n"
    assert (tmp_path / "a.board").read_text().startswith("3 ")
    refused = gaitsim("export", "puppet", "--format", "board", "--channels", 17, code=2).stderr
    assert "invalid --channels: '17'" in refused
    (form,) = [form for form in [*chain(*forms().values())] if form.title == "My board"]
    assert next(iter(form.fields())) == "channels"
    run = tmp_path / "runs/puppet"
    assert form.read(run, {"channels": "4"})[0][2:] == ("--format", "board", "--channels", "4")
    assert form.read(run, {"channels": "x"})[1].keys() == {"channels"}
    forms.cache_clear()


def test_names_of_the_commands_options_are_reserved():
    assert {*SeveralIndividuals.model_fields} <= {*RESERVED}
