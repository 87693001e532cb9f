"""Commands and snapshots as lines, and the history built from rows."""

import json
import math

import numpy as np
import pytest

from gaitsim.errors import ExperimentError, GaitsimError
from gaitsim.experiment import Typed
from gaitsim.live.protocol import (
    Best,
    Event,
    RunCommand,
    Snapshot,
    merge,
    read_command,
    read_snapshot,
    write_command,
    write_snapshot,
)
from gaitsim.storage.growing import HistoryBuffer

BEFORE = Snapshot("running", generation=3, champion=Best(2, 1.0, (0.5,)), top=(Best(3, 1),))


def rows(first, last, **columns):
    numbers = np.arange(first, last + 1, dtype=float)
    return {"generation": numbers} | {name: numbers * factor for name, factor in columns.items()}


@pytest.mark.parametrize(
    "command",
    [RunCommand("go"), RunCommand("set", {"mutation.rate": 0.1, "name": Typed("[b]'\n\"ü")})],
)
def test_commands_survive_a_round_trip(command):
    line = write_command(command)
    assert line.count(b"\n") == 1
    assert read_command(line) == command


@pytest.mark.parametrize(
    "line",
    [
        b"",
        b"3",
        b'{"do":"jump"}',
        b'{"do":["go"]}',
        b'{"do":"set","values":3}',
    ],
)
def test_an_invalid_command_is_ignored(line):
    assert read_command(line) is None


def test_snapshots_survive_a_round_trip():
    values = {
        "state": "paused",
        "generation": 5,
        "rows": {"generation": [4, 5], "best": [1.5, -math.inf]},
        "top": [{"generation": 5, "score": 1.5, "terms": {"reach": 1.5, "price": math.nan}}],
        "champion": {"generation": 4, "score": 1.5, "genome": [0.1, 1e-300]},
        "events": [{"generation": 4, "kind": "best", "text": "1.5"}],
    }
    line = write_snapshot(values)
    json.loads(line, parse_constant=pytest.fail)
    found = read_snapshot(line, BEFORE)
    assert (found.state, found.generation, found.generations) == ("paused", 5, 0)
    np.testing.assert_equal(found.rows["best"], [1.5, np.nan])
    assert found.top[0].terms["reach"] == 1.5
    assert math.isnan(found.top[0].terms["price"])
    assert found.champion == Best(4, 1.5, (0.1, 1e-300))
    assert found.events == (Event(4, "best", "1.5"),)


def test_missing_keys_keep_their_values_except_news():
    reported = read_snapshot(write_snapshot({"state": "finished", "reason": "done"}), BEFORE)
    then = read_snapshot(write_snapshot({"state": "running"}), reported)
    assert (then.champion, then.top, then.generation) == (BEFORE.champion, BEFORE.top, 3)
    assert (then.reason, dict(then.rows), then.events, then.error) == ("", {}, (), None)


@pytest.mark.parametrize("line", [b"", b'{"stat": 1}', b'{"champion": {"score": 1}}'])
def test_an_invalid_snapshot_is_an_error(line):
    with pytest.raises(ValueError):  # noqa: PT011 - any text will do
        read_snapshot(line, BEFORE)


@pytest.mark.parametrize(
    "error",
    [
        GaitsimError("it broke", where="here", allowed="that", remedy="this"),
        ExperimentError([GaitsimError("one", where="a"), GaitsimError("two", remedy="b")]),
    ],
)
def test_errors_survive_a_round_trip(error):
    line = write_snapshot({"state": "failed", "error": error.to_dict()})
    found = read_snapshot(line, BEFORE).error
    assert str(found) == str(error)
    assert isinstance(found, type(error))


def test_merged_snapshots_lose_nothing():
    first = Snapshot("running", rows=rows(1, 2, best=1), events=(Event(1, "best", "1"),),
                     error=GaitsimError("no"))  # fmt: skip
    then = Snapshot("paused", rows=rows(3, 4, other=2), events=(Event(3, "best", "2"),))
    both = merge(first, then)
    np.testing.assert_equal(both.rows["generation"], [1, 2, 3, 4])
    np.testing.assert_equal(both.rows["best"], [1, 2, np.nan, np.nan])
    np.testing.assert_equal(both.rows["other"], [np.nan, np.nan, 6, 8])
    assert [event.generation for event in both.events] == [1, 3]
    assert (both.state, both.error.what) == ("paused", "no")


def test_a_history_skips_rows_that_it_already_has():
    history = HistoryBuffer(rows(1, 3, best=1))
    assert history.extend(rows(2, 6, best=1))
    assert history.extend({})
    assert history.extend(rows(2, 6, best=7))
    np.testing.assert_equal(history["best"], [1, 2, 3, 4, 5, 6])
    assert not history.extend(rows(8, 9, best=1))
    assert len(history) == 6
    assert history.extend(rows(1, 2, best=7))  # the file was rewritten
    np.testing.assert_equal(history["best"], [7, 14])


def test_a_history_accepts_new_terms():
    history = HistoryBuffer(rows(1, 2, **{"reach": 1, "mean:reach": 1}))
    for number in range(3, 100):
        assert history.extend(rows(number, number, **{"height": 2, "mean:height": 1}))
    assert history.terms == ["reach", "height"]
    np.testing.assert_equal(history["reach"][:4], [1, 2, np.nan, np.nan])
    np.testing.assert_equal(history["height"][:4], [np.nan, np.nan, 6, 8])
    assert len(history["height"]) == len(history) == 99
