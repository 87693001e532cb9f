"""Displays of an evolving run, on a console of fixed size with a simulated clock."""

import dataclasses
import io
import json
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from rich.console import Console

from gaitsim.console.displays import Display, JsonLines, LiveView, PlainLines, row_of
from gaitsim.evaluation import Evaluation
from gaitsim.evolution import Generation, SearchProgress
from gaitsim.experiment import Islands
from gaitsim.live.protocol import snapshot_of

CLASSIC = {
    "movement": 3.5,
    "band": 2.0,
    "low movement": -0.25,
    "penetration": -0.021,
    "variance": -0.048,
    "overlapping legs": -0.428,
    "angle change": -0.239,
}


def generation(
    number: int, terms: dict[str, float] | None = None, *, population: int = 20, stop: str = ""
) -> Generation:
    """Return a generation whose n-th best has the terms minus n thousandths."""
    less = np.arange(population) / 1000
    parts = {name: value - less for name, value in (terms or {"forward": 1.0}).items()}
    scores = np.sum(list(parts.values()), axis=0)
    return Generation(
        number=number,
        genomes=np.zeros((population, 2)),
        evaluation=Evaluation(scores, parts, {}),
        progress=SearchProgress(population * number, float(scores.max()), 3, None),
        diversity=0.25,
        seconds=0.1,
        is_champion=False,
        stop=stop,
    )


def known(
    total: int = 300, last: Generation | None = None, scored_from: int = 1, **history: list[float]
) -> Any:
    """Return the arguments of a display: a path and a snapshot."""
    rows = {name: np.array(values) for name, values in history.items()}
    found = snapshot_of(last, experiment(total), rows=rows, scored_from=scored_from)
    return Path("runs/spider"), found


def experiment(total: int = 300, islands: int = 1) -> Any:
    return SimpleNamespace(
        evolution=SimpleNamespace(generations=total), islands=Islands(number=islands)
    )


def update(view: Display, made: Generation, total: int = 300, islands: int = 1) -> None:
    snapshot = snapshot_of(made, experiment(total, islands))
    view.update(snapshot, [row_of(made, snapshot)])


class Clock:
    """A clock that stands still until it is set."""

    def __init__(self) -> None:
        self.now = 100.0

    def __call__(self) -> float:
        return self.now


def drawn(view: LiveView, width: int = 80, height: int = 24) -> list[str]:
    console = Console(file=io.StringIO(), width=width, height=height, record=True)
    console.print(view)
    return console.export_text().splitlines()


def view_at_work(
    clock: Clock, terms: dict[str, float] | None = None, generations: int = 10
) -> LiveView:
    """Return a view after a number of generations of half a second each."""
    view = LiveView(*known(), Console(file=io.StringIO()), clock)
    for number in range(1, generations + 1):
        clock.now += 0.5
        update(view, generation(number, terms))
    return view


@pytest.fixture
def clock() -> Clock:
    return Clock()


class TestPlainLines:
    def test_first_last_and_one_every_two_seconds(
        self, capsys: pytest.CaptureFixture[str], clock: Clock
    ) -> None:
        with PlainLines(*known(12), clock) as lines:
            for number in range(1, 13):
                update(lines, generation(number, stop="done" if number == 12 else ""), 12)
                clock.now += 0.5
        assert capsys.readouterr().out.splitlines() == [
            "run runs/spider",
            "generation 1/12  best 1.0000  mean 0.9905  diversity 0.250",
            "generation 6/12  best 1.0000  mean 0.9905  diversity 0.250",
            "generation 11/12  best 1.0000  mean 0.9905  diversity 0.250",
            "generation 12/12  best 1.0000  mean 0.9905  diversity 0.250",
        ]

    def test_a_long_generation_prints_its_progress_every_ten_seconds(
        self, capsys: pytest.CaptureFixture[str], clock: Clock
    ) -> None:
        with PlainLines(*known(12), clock) as lines:
            for step in range(1, 11):
                clock.now += 4
                lines.scored(step / 10)
            update(lines, generation(1), 12)
        assert capsys.readouterr().out.splitlines()[1:] == [
            "generation 1/12  30% scored",
            "generation 1/12  60% scored",
            "generation 1/12  90% scored",
            "generation 1/12  best 1.0000  mean 0.9905  diversity 0.250",
        ]


def test_the_best_of_each_island_is_reported(capsys: pytest.CaptureFixture[str]) -> None:
    with PlainLines(*known()) as lines:
        update(lines, generation(1), islands=4)
    assert capsys.readouterr().out.splitlines()[1] == (
        "generation 1/300  best 1.0000  mean 0.9905  diversity 0.250"
        "  islands 1.0000 0.9950 0.9900 0.9850"
    )
    with JsonLines(*known()) as json_lines:
        update(json_lines, generation(1), islands=4)
    found = json.loads(capsys.readouterr().out)["islands"]
    assert found == pytest.approx([1.0, 0.995, 0.99, 0.985])


class TestLiveView:
    def test_a_long_generation_shows_its_progress(self, clock: Clock) -> None:
        view = LiveView(*known(), Console(file=io.StringIO()), clock)
        view.scored(0.1)
        assert len(drawn(view)) == 1
        clock.now += 36_000.0
        view.scored(0.25)
        assert drawn(view)[1] == "generation 1: 25% scored"
        view.scored(0.00014)
        assert drawn(view)[1] == "generation 1: 0.01% scored"
        update(view, generation(1))
        assert "scored" not in "\n".join(drawn(view))
        assert drawn(view)[0].endswith(" 1/300 124 days, 14:00:00 left")

    def test_shows_progress_curves_and_terms(self, clock: Clock) -> None:
        lines = drawn(view_at_work(clock, CLASSIC))
        assert lines[0].startswith("spider ━")
        assert lines[0].endswith(" 10/300 0:02:25 left")
        assert [line.split()[:2] for line in lines[1:4]] == [
            ["best", "4.514"],
            ["mean", "4.447"],
            ["diversity", "0.250"],
        ]
        assert lines[4] == "40 evaluations/s, best of generation 7"
        assert lines[6].split() == ["#1", "#2", "#3", "#4", "#5", "mean"]
        assert lines[7].split() == ["score", "4.514", "4.507", "4.500", "4.493", "4.486", "4.447"]
        assert [line.split("  ")[0] for line in lines[8:15]] == [*CLASSIC]
        assert "overlapping legs   −0.428   −0.429" in lines[13]

    @pytest.mark.parametrize(("width", "height"), [(40, 16), (80, 24), (160, 48)])
    def test_fits_the_terminal(self, clock: Clock, width: int, height: int) -> None:
        lines = drawn(view_at_work(clock, CLASSIC, 250), width, height)
        assert len(lines) < height  # the last line is left for the cursor
        assert max(map(len, lines)) <= min(width, 100)
        assert not any("…" in line for line in lines[1:])
        assert any(line.startswith("angle change") for line in lines)

    def test_remaining_time_follows_the_recent_speed(self, clock: Clock) -> None:
        view = LiveView(*known(4000), Console(file=io.StringIO()), clock)
        for number in range(1, 2001):
            clock.now += 1.0 if number <= 1000 else 0.1
            update(view, generation(number), 4000)
        assert drawn(view)[0].endswith("0:03:20 left")

    @pytest.mark.parametrize("reevaluated", [True, False])
    def test_a_stage_with_new_scores_restarts_their_curves(
        self, clock: Clock, reevaluated: bool
    ) -> None:
        course = {"best": [5.0, 9.0], "mean": [4.0, 8.0], "diversity": [0.3, 0.2]}
        file = io.StringIO()
        view = LiveView(*known(20, generation(2), **course), Console(file=file, width=80), clock)
        progress = SearchProgress(40, -np.inf, -1, None, 2)
        last = dataclasses.replace(generation(2), progress=progress)
        _, rescored = known(20, last, best=[1.0], mean=[0.991])
        view.start_stage(2, 3, ["a rate: 0.1, now 0.2"], rescored if reevaluated else None)
        assert file.getvalue() == "stage 2, from generation 3: a rate: 0.1, now 0.2\n"
        before = {"best": "1.000 ⡀", "mean": "0.991 ⡀"}
        if not reevaluated:
            before = {"best": "9.000 ⡸", "mean": "8.000 ⡸"}
        lines = drawn(view)
        assert " ".join(lines[1].split()) == f"best {before['best']}"
        assert " ".join(lines[2].split()) == f"mean {before['mean']}"
        assert lines[3].split() == ["diversity", "0.200", "⢱"]
        clock.now += 2
        progress = SearchProgress(60, 1.0, 0, None, 2)
        update(view, dataclasses.replace(generation(3), progress=progress), 20)
        assert drawn(view)[4] == "10 evaluations/s, best of generation 3, stage 2"
