"""Runs are found, sorted and grouped by their values."""

import time
from contextlib import suppress
from pathlib import Path

import pytest

from gaitsim.errors import GaitsimError
from gaitsim.storage.overview import Overview
from gaitsim.storage.query import parse_query, sort_runs

NOW = 1_000_000.0


@pytest.fixture(autouse=True)
def clock(monkeypatch):
    monkeypatch.setattr(time, "time", lambda: NOW)


RUNS = [
    Overview(
        Path("runs/hexapod"),
        "finished",
        {"organism": "robot", "fitness": "travel", "search": "cma-es"},
        seed=3,
        generation=300,
        generations=300,
        best=2.5,
        seconds=130.0,
        changed=NOW - 3 * 86400,
        note="Drags its LEFT leg",
        tags=("Größe", "good"),
        evaluations=6000,
        options={"seed": 3, "evolution.population": 20, "search.active": True, "worlds.cases": []},
        terms={"forward": 1.5, "duty factor L2": 0.6},
    ),
    Overview(
        Path("runs/spider"),
        "running",
        {"organism": "spider", "fitness": "spider-walk", "search": "genetic", "mutation": "gauss"},
        generation=10,
        generations=100,
        best=-0.5,
        seconds=20.0,
        changed=NOW - 3600,
        options={"evolution.population": 100, "search.elites": 2, "organism.symmetry": "mirror"},
        terms={"forward": 0.5},
    ),
    Overview(Path("runs/new"), "queued", {"organism": "spider"}, tags=("good-2",)),
]


@pytest.mark.parametrize(
    ("query", "found"),
    [
        ("", "hexapod spider new"),
        ("SPIDER", "spider new"),
        ("grö", "hexapod"),
        ('"left leg"', "hexapod"),
        ("'left leg", "hexapod"),
        ("note:", "hexapod"),
        ("tag:", "hexapod new"),
        ("tag:good", "hexapod"),
        ("tag:GRÖSSE", "hexapod"),
        ("name=pide", ""),
        ("body:spid", "spider new"),
        ("state:running", "spider"),
        ("state!=running", "hexapod new"),
        ("-mutation=gauss", "hexapod new"),
        ("score!=2.5", "spider"),
        ("seed=3", "hexapod"),
        ("time>2min", "hexapod"),
        ("age>=1h age<=1w", "hexapod spider"),
        ("search.active=true", "hexapod"),
        ("worlds.cases:", ""),
        ("organism.symmetry!=mirror", ""),
        ("forward>1", "hexapod"),
        ('"duty factor L2>0.5', "hexapod"),
    ],
)
def test_a_query_selects_runs(query, found):
    runs = parse_query(query).select(RUNS)
    assert " ".join(run.name for run in runs) == found
    assert runs == [run for run in RUNS if parse_query(query).matches(run)]


@pytest.mark.parametrize(
    ("query", "what", "remedy"),
    [
        ("scroe>1", "unknown key 'scroe'", "did you mean 'score'?"),
        ("search.elite=1", "unknown key 'search.elite'", "did you mean 'search.elites'?"),
        ("score>high", "score is compared with 'high', which is not a number", ""),
        ("score>", "score is compared with ''", ""),
        ("age<2x", "age is compared with '2x'", ""),
        ("seed=1min", "seed is compared with '1min'", ""),
        ("name>3", "name is a text", ""),
        ("state:runing", "unknown state 'runing'", "did you mean 'running'?"),
    ],
)
def test_a_wrong_query_is_one_message(query, what, remedy):
    with pytest.raises(GaitsimError) as error:
        parse_query(query).select(RUNS)
    assert what in error.value.what
    assert error.value.allowed
    assert error.value.remedy == remedy


def test_without_runs_no_key_is_unknown():
    assert parse_query("search.elites=2").select([]) == []


@pytest.mark.parametrize(
    "text", ["'", '"', "\\", "a\\", "-'", "a:'", "=", ":", ">", "!", "a!", "\0"]
)
def test_any_text_while_typing_is_a_query_or_one_message(text):
    with suppress(GaitsimError):
        parse_query(text).select(RUNS)


@pytest.mark.parametrize(
    ("key", "order"),
    [
        ("-name", "spider new hexapod"),
        ("score", "spider hexapod new"),
        ("-score", "hexapod spider new"),
        ("age", "spider hexapod new"),
        ("-search.elites", "spider hexapod new"),
    ],
)
def test_runs_without_a_value_are_last_in_any_order(key, order):
    assert [run.name for run in sort_runs(RUNS, key)] == order.split()
