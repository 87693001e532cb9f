import signal

import pytest

from gaitsim_studies import running
from gaitsim_studies.compare_command import CompareExperiments

STUDY = """
name = "small"
description = "a small one"
experiments = ["millipede-random", "millipede-mutation"]
set = { "evolution.generations" = 6 }
repeats = 3
record_every = 2
target = 4.0
[axes]
"evolution.population" = [5, 9]
[published.millipede-mutation]
population = 10
generations = 19
"""


def test_a_study_writes_table_surfaces_and_report(gaitsim, tmp_path):
    (tmp_path / "small.toml").write_text(STUDY)
    done = gaitsim("study", "small.toml", "--workers", 1)
    folder = tmp_path / "studies/small"
    assert "study studies/small: 4 of 4 cells to run" in done.stderr
    assert "Cheapest population and generations that reach 4" in done.stdout
    assert "fewest evaluations" in done.stdout
    assert "confirm studies/small" in done.stderr or "fresh repeats" in done.stderr
    assert (folder / "results.csv").read_text().count("\n") == 1 + 4 * 3
    assert {path.name for path in folder.glob("surface-*")} == {
        "surface-1-millipede-random.png",
        "surface-2-millipede-mutation.png",
    }
    report = (folder / "report.md").read_text()
    assert "| 10 / 19 |" in report
    assert "| never |" in report  # nothing is published for random
    assert "100 fresh repeats" in report


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        (["study", "nosuch"], "unknown study 'nosuch'"),
        (["compare", "millipede", "milipede"], "did you mean 'millipede'?"),
        (
            ["compare", "millipede", "spider", "--evaluations", "400", "--generations", "2"],
            "'evaluations' and 'generations' cannot be combined",
        ),
    ],
)
def test_invalid_input_is_one_message(gaitsim, arguments, says):
    done = gaitsim(*arguments, code=2)
    assert says in done.stderr
    assert done.stdout == ""


SHORT = ("--population", 9, "--generations", 8, "--repeats", 12)


def test_compare_writes_a_report_with_a_command_that_repeats_it(gaitsim, tmp_path):
    done = gaitsim("compare", "millipede-random", "millipede", *SHORT, "--targets", "-1,3.5")
    folder = tmp_path / "comparisons/millipede-random-against-millipede"
    assert "differs at 5 %" in done.stdout
    assert "Areas have no interval with fewer than 20 repeats" in done.stdout
    for name in ("convergence.png", "ecdf.png"):
        assert (folder / name).stat().st_size > 10_000
    report = (folder / "report.md").read_text()
    (command,) = (line for line in report.splitlines() if line.startswith("gaitsim compare"))
    assert "--targets=-1,3.5" in command
    gaitsim(*command.split()[1:], "--out", "again")
    assert (tmp_path / "again/results.csv").read_text() == (folder / "results.csv").read_text()


def interrupt_writing(monkeypatch, number):
    """Press Ctrl-C when a number of parts of a comparison is written."""
    write, written = running._write_best, []

    def count(path, best):
        write(path, best)
        written.append(path.name)
        if len(written) == number:
            signal.raise_signal(signal.SIGINT)

    monkeypatch.setattr(running, "PER_WORKER", 20)
    monkeypatch.setattr(running, "_write_best", count)
    return written


@pytest.mark.slow
def test_a_stopped_comparison_continues_with_the_same_command(gaitsim, tmp_path, monkeypatch):
    short = ("--population", 10, "--generations", 3, "--repeats", 5, "--workers", 1)
    given = ("compare", "spider", "spider-genetic", *short)
    gaitsim(*given, "--out", "whole")
    written = interrupt_writing(monkeypatch, 1)
    folder = tmp_path / "comparisons/spider-against-spider-genetic"
    said = " ".join(gaitsim(*given, code=130).stderr.split())
    assert (
        "finished repeats are saved. Continue with: gaitsim compare spider spider-genetic" in said
    )
    assert [path.name for path in (folder / "repeats-5").iterdir()] == written
    # The terminal UI continues it, too.
    names = ("spider", "spider-genetic")
    same = CompareExperiments(experiments=names, repeats=5, population=10, generations=3)
    assert tmp_path / same.free_folder() == folder
    # Another number of repeats or other options are another comparison.
    written[:] = [""]
    for other in (("--repeats", 6), ("--set", "seed=3")):
        gaitsim(*given, *other)
    assert not (folder / "report.md").exists()
    written[:] = [""]
    gaitsim(*given)
    # CMA-ES in parts of 20 spiders; a genetic algorithm, whose repeats share streams, at once.
    assert [name.rsplit("-", 1)[0] for name in written[1:]] == ["1-2-4", "1-4-5", "2-0-5"]
    assert (folder / "results.csv").read_text() == (tmp_path / "whole/results.csv").read_text()
    assert not (folder / "repeats-5").exists()
    assert {path.name for path in (tmp_path / "comparisons").iterdir()} == {
        folder.name,
        f"{folder.name}-2",
        f"{folder.name}-3",
    }


def test_a_comparison_stopped_at_once_keeps_nothing(gaitsim, tmp_path, monkeypatch):
    monkeypatch.setattr(
        running, "complete_repeats", lambda *_, **__: signal.raise_signal(signal.SIGINT)
    )
    given = ("millipede", "millipede", "--repeats", 3, "--set", "seed=7")
    said = gaitsim("compare", *given, code=130).stderr
    assert f"gaitsim compare {' '.join(map(str, given))}" in " ".join(said.split())
    assert not [*(tmp_path / "comparisons").iterdir()]
