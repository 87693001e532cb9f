"""Saved views of lists of runs."""

import pytest

from gaitsim.errors import GaitsimError
from gaitsim.storage.views import (
    View,
    find_view,
    forget_view,
    read_views,
    save_view,
    views_path,
)

VIEW = View("good ones", "tag:good score>5", ("name", "score"), "-score", "body")


@pytest.fixture(autouse=True)
def folder(tmp_path, monkeypatch):
    monkeypatch.setenv("XDG_CONFIG_HOME", str(tmp_path))


def test_views_are_saved_replaced_and_forgotten():
    assert read_views() == ({}, {})
    save_view(View("other", "spider"))
    save_view(View(VIEW.name, "x"))
    save_view(VIEW)
    assert find_view(VIEW.name) == VIEW
    assert [*read_views()[0]] == ["other", "good ones"]
    forget_view("other")
    assert read_views() == ({VIEW.name: VIEW}, {})


def test_the_rest_of_the_file_is_kept():
    views_path().parent.mkdir()
    views_path().write_text('# mine\n[a]\nwhere = "x" # why\n')
    save_view(VIEW)
    assert views_path().read_text().startswith('# mine\n[a]\nwhere = "x" # why\n')


@pytest.mark.parametrize(
    ("text", "what"),
    [
        ("a = 3", "'a' is not a view"),
        ("[a]\nwere = 'x'", "unknown key 'were'"),
        ("[a]\nwhere = 3", "invalid where: 3"),
        ("[a]\ncolumns = 'name'", "invalid columns"),
        ("[a]\ncolumns = [3]", "invalid columns"),
        ("[a]\nwhere = 'score>x'", "is not a number"),
    ],
)
def test_an_invalid_view_is_one_message_and_the_others_work(text, what):
    views_path().parent.mkdir()
    views_path().write_text(f"{text}\n[b]\n")
    views, problems = read_views()
    assert views == {"b": View("b")}
    with pytest.raises(GaitsimError) as error:
        find_view("a")
    assert what in str(problems["a"]) == str(error.value)
    assert str(views_path()) in error.value.where
    forget_view("a")
    assert read_views() == ({"b": View("b")}, {})


def test_a_file_that_is_not_toml_is_one_message_and_stays():
    views_path().parent.mkdir()
    views_path().write_text("[a")
    for action in (read_views, lambda: save_view(VIEW), lambda: forget_view("a")):
        with pytest.raises(GaitsimError, match="not valid TOML"):
            action()
    views_path().write_bytes(b"\xff")
    with pytest.raises(GaitsimError, match="it is not UTF-8 text"):
        read_views()


def test_wrong_views_are_not_saved():
    for view in (View(""), View("a\nb"), View("x" * 101), View("a", "age<x")):
        with pytest.raises(GaitsimError):
            save_view(view)
    assert not views_path().exists()


def test_an_unknown_view_names_the_others():
    with pytest.raises(GaitsimError, match="unknown view 'god'") as error:
        find_view("god")
    assert error.value.allowed == "none; save one with 'gaitsim runs --save-view NAME'"
    save_view(View("good"))
    with pytest.raises(GaitsimError) as error:
        forget_view("god")
    assert (error.value.allowed, error.value.remedy) == ("good", "did you mean 'good'?")
