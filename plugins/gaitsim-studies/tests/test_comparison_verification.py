"""`verify` finds every change in the folder of a comparison."""

import json
import os
import shutil
from importlib.metadata import version
from pathlib import Path

import numpy as np
import pytest

import gaitsim as gs
from gaitsim.errors import GaitsimError
from gaitsim_studies.comparison import Sample, analyse, load_experiments
from gaitsim_studies.comparison_report import curves, report, results, to_dict
from gaitsim_studies.running import repeat_experiment
from gaitsim_studies.verification import verify_comparison

REPEATS = 6
OPTIONS = ("--repeats", REPEATS, "--targets", "0.5, 1", "--workers", 1)


@pytest.fixture
def folder(gaitsim, puppet, tmp_path, once):
    """A comparison of two experiments, whose repeats can be evolved one by one."""
    for name, population in {"puppet": 6, "wild": 5}.items():
        own = f"name={name}", f"evolution.population={population}"
        text = puppet("search.plugin=cma-es", *own).to_toml()
        (tmp_path / f"{name}.toml").write_text(text)

    def create():
        gaitsim("compare", "puppet.toml", "wild.toml", "--out", "compared", *OPTIONS)

    return once("comparison", Path("compared"), create)


def found(folder, **options):
    """Return whether a verification finds a difference, or that nothing can be verified."""
    try:
        return not verify_comparison(folder, workers=1, **options).identical
    except GaitsimError:
        return True


def test_an_untouched_comparison_is_identical(folder, gaitsim):
    some = verify_comparison(folder, workers=1)
    assert (some.identical, some.complete, len(some.again)) == (True, False, 3)
    results = {one.file: one.result for one in some.files}
    assert (results["results.csv"], results["report.md"]) == ("cannot be known", "same")
    answer = gaitsim("verify", "compared", "--all", "--workers", 1).stdout
    assert answer.splitlines()[:2] == [
        "compared: identical",
        "6 of 6 repeats of each experiment evolved again: 1 to 6",
    ]
    content = json.loads(gaitsim("verify", "compared", "--json", "--workers", 1).stdout)
    assert (content["comparison"], content["identical"]) == ("compared", True)
    moved = folder.rename("elsewhere")
    assert gs.verify(moved).identical


def replaced(name, old, new):
    def tamper(folder):
        text = (folder / name).read_text()
        assert old in text
        (folder / name).write_text(text.replace(old, new, 1))

    return tamper


def values(**changes):
    def tamper(folder):
        content = json.loads((folder / "comparison.json").read_text())
        (folder / "comparison.json").write_text(json.dumps(content | changes))

    return tamper


def last_row(change):
    def tamper(folder):
        *lines, last = (folder / "results.csv").read_text().splitlines()
        (folder / "results.csv").write_text("\n".join([*lines, *change(last)]) + "\n")

    return tamper


def other_command(old, new):
    def tamper(folder):
        content = json.loads((folder / "comparison.json").read_text())
        command = content["command"]
        assert old in command
        for name in ("comparison.json", "report.md"):
            text = (folder / name).read_text()
            (folder / name).write_text(text.replace(command, command.replace(old, new)))

    return tamper


def swapped(folder):
    first, second = folder / "1.toml", folder / "2.toml"
    first.rename(folder / "other")
    second.rename(first)
    (folder / "other").rename(second)


TAMPERINGS = {
    "a score": last_row(lambda row: [row[:-1] + ("1" if row[-1] != "1" else "2")]),
    "a repeat deleted": last_row(lambda row: []),
    "a repeat of an unknown experiment": last_row(lambda row: [row.replace("wild", "tame")]),
    "a curve": replaced("ecdf.csv", "puppet", "wild"),
    "a median in the report": replaced("report.md", "| puppet | ", "| puppet | 9"),
    "a p-value": values(comparisons=[]),
    "no command": values(command=None),
    "the targets": other_command("0.5, 1", "0.5, 2"),
    "a seed": replaced("1.toml", "seed = ", "seed = 1"),
    "experiments swapped": swapped,
    "an experiment added": lambda folder: shutil.copy(folder / "2.toml", folder / "3.toml"),
    "no table": lambda folder: (folder / "results.csv").unlink(),
    "a huge table": lambda folder: os.truncate(folder / "results.csv", 10**11),
}


@pytest.mark.sampled
@pytest.mark.parametrize("tamper", TAMPERINGS.values(), ids=TAMPERINGS)
def test_tampering_is_found(folder, tamper):
    tamper(folder)
    assert found(folder, everything=True)


def test_a_table_with_all_that_follows_from_it_is_found_where_its_repeats_are_evolved(folder):
    command = json.loads((folder / "comparison.json").read_text())["command"]
    loaded = load_experiments([folder / "1.toml", folder / "2.toml"], {})
    samples = {
        label: Sample(one, np.array(repeat_experiment(one, REPEATS)))
        for label, one in loaded.items()
    }
    samples["wild"].best[1] += 0.5
    findings = analyse(samples, 25, [0.5, 1])
    figures = [folder / "convergence.png", folder / "ecdf.png"]
    (folder / "results.csv").write_text(results(findings))
    (folder / "ecdf.csv").write_text(curves(findings))
    (folder / "report.md").write_text(report(findings, command, figures))
    content = json.dumps({**to_dict(findings), "command": command}).replace("NaN", "null")
    (folder / "comparison.json").write_text(content.replace("Infinity", "null"))
    verdict = verify_comparison(folder, everything=True, workers=1)
    assert [*map(str, verdict.differences)] == ["results.csv: repeat 2 of wild differs"]


def test_another_version_is_named(folder, gaitsim):
    own = f"(gaitsim {version('gaitsim')})"
    replaced("comparison.json", own, "(gaitsim 0.0.1)")(folder)
    stderr = gaitsim("verify", "compared", code=2).stderr
    assert "was made by gaitsim 0.0.1" in stderr
    assert "verify it with the same version" in stderr


def test_a_stopped_comparison_is_not_finished(folder, gaitsim):
    (folder / "report.md").unlink()
    assert "is not finished" in gaitsim("verify", "compared", code=2).stderr
