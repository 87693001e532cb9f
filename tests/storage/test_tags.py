"""Tags of runs."""

import os

import pytest

from gaitsim.errors import RunError
from gaitsim.storage.creation import create_run, fork_run
from gaitsim.storage.growing import overview
from gaitsim.storage.manage import LONGEST_TAG, MOST_TAGS, read_tags, write_tags
from gaitsim.storage.overview import list_overviews
from gaitsim.storage.snapshot import RunSnapshot


@pytest.fixture
def run(puppet, here):
    return create_run(puppet())


def test_tags_are_stored_sorted_and_once(run):
    assert read_tags(run) == ()
    assert write_tags(run, ["straight", "good", "Größe", "good"]) == ("Größe", "good", "straight")
    assert read_tags(run) == overview(run).tags == ("Größe", "good", "straight")
    assert (run / "tags.txt").read_text() == "Größe\ngood\nstraight\n"
    write_tags(run, [])
    assert read_tags(run) == ()
    assert not (run / "tags.txt").exists()


def test_the_two_forms_of_an_accent_are_one_tag(run):
    assert write_tags(run, ["e\u0301te\u0301", "\u00e9t\u00e9"]) == ("\u00e9t\u00e9",)


@pytest.mark.parametrize(
    "tag",
    ["", "a b", "a,b", "a\n", "\x1b", "\u202e", "x" * (LONGEST_TAG + 1)],
)
def test_an_invalid_tag_is_one_message_and_changes_nothing(run, tag):
    write_tags(run, ["good"])
    with pytest.raises(RunError, match="invalid tag") as error:
        write_tags(run, ["fine", tag])
    assert error.value.allowed
    assert read_tags(run) == ("good",)


def test_too_many_tags_are_one_message(run):
    with pytest.raises(RunError, match="too many tags: 101") as error:
        write_tags(run, map(str, range(MOST_TAGS + 1)))
    assert error.value.allowed == "up to 100 tags per run"


def test_a_foreign_file_gives_only_valid_tags(run):
    (run / "tags.txt").write_text("b\n\n a \nnot a tag\n\x1b[2J\nb\n")
    assert read_tags(run) == ("a", "b")
    (run / "tags.txt").write_bytes(b"\xff\xfe")
    with pytest.raises(RunError, match="it is not a text file in UTF-8"):
        read_tags(run)
    assert overview(run).tags == ()
    (run / "tags.txt").unlink()
    os.mkfifo(run / "tags.txt")
    assert overview(run).tags == ()


def test_tags_are_in_the_quick_list_but_not_in_results_and_copies(half):
    before = half.fingerprint()
    write_tags(half.path, ["good"])
    assert RunSnapshot(half.path).fingerprint() == before
    (listed,) = list_overviews(half.path.parent, lambda path: pytest.fail("read in full"))
    assert listed.tags == ("good",)
    assert read_tags(fork_run(half.path)) == ()
