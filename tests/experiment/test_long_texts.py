"""Options that hold a long text, such as a robot that was read from a file."""

import tomllib
from pathlib import Path

import pytest
from hypothesis import given, strategies as st
from tomlkit import document, dumps, table

from gaitsim import toml
from gaitsim.errors import GaitsimError
from gaitsim.experiment import load_experiment, parse_assignments, parse_experiment
from gaitsim.experiment.model import _multiline

LINES = '<shape name="cube">\n' + "  <side/>\n" * 20_000 + "</shape>\n"


@given(st.text(st.characters(exclude_categories=["Cs"])) | st.text("'\"\\\n\t\r#[] a"))
def test_a_text_of_several_lines_comes_back_to_the_letter(text):
    section = table()
    section.add("shape", _multiline(text))
    section.add("size", 2)
    whole = document()
    whole["organism"] = section
    whole["fitness"] = {"plugin": "far"}
    written = dumps(whole)
    expected = {"organism": {"shape": text, "size": 2}, "fitness": {"plugin": "far"}}
    assert tomllib.loads(written) == expected
    assert toml.parse(written, "") == expected


def test_a_file_is_written_into_the_experiment_which_does_without_it(shaped, tmp_path, monkeypatch):
    folder = tmp_path / "elsewhere"
    folder.mkdir()
    file, shape = folder / "x.toml", folder / "cube.shape"
    shape.write_text(LINES)
    file.write_text(shaped.replace('plugin = "cube"', 'plugin = "cube"\nshape = "cube.shape"'))
    monkeypatch.chdir(tmp_path)
    experiment = load_experiment(str(file))  # relative to the file
    monkeypatch.chdir(folder)
    typed = parse_assignments(["organism.shape=cube.shape"])
    assert parse_experiment(shaped, "x.toml", typed) == experiment  # to the current folder
    shape.unlink()
    text = experiment.to_toml()
    assert parse_experiment(text, "again") == experiment
    assert len(text) > len(LINES)
    organism = text.partition("[organism]")[2].partition("[fitness]")[0]
    assert organism.rstrip().endswith("'''")
    assert LINES in organism.partition("size = ")[2]  # below the other options
    shown = experiment.to_toml(brief=True)
    assert len(shown) < 4000
    assert '<shape name=\\"cube\\"> (200 kB of text, SHA-256 ' in shown


def test_a_run_does_not_name_files(shaped, tmp_path, monkeypatch):
    (tmp_path / "cube.shape").write_text(LINES)
    monkeypatch.chdir(tmp_path)
    with pytest.raises(GaitsimError, match="no file is read here"):
        parse_experiment(shaped.replace('"cube"', '"cube"\nshape = "cube.shape"'), "a checkpoint")


def test_the_words_of_a_validator_have_the_key_of_their_option(problem, shaped):
    found = problem("organism.shape=none.shape", text=shaped)
    assert found.key == "organism.shape"
    assert found.where == f"command line, key organism.shape: {Path('none.shape')}"
    assert (found.what, found.allowed, found.remedy) == (
        "the shape cannot be read",
        "a shape",
        "another file",
    )
    long = problem(f"organism.size={LINES}", text=shaped)
    assert len(str(long)) < 500
    too_long = problem(f"organism.label={LINES * 6}", text=shaped)
    assert "too long" in too_long.what
    assert len(str(too_long)) < 500


def test_dots_in_a_long_text_are_no_nested_tables():
    dots = "a." * 50 + "a"
    value = f"'''\n{dots}\n'''"
    assert toml.parse(f"x = {value}", "") == {"x": f"{dots}\n"}
    for hidden in (f"# '''\n{dots} = 1", f"x = \"'''\"\n{dots} = 1", f"x = '''a''''\n{dots} = 1"):
        with pytest.raises(GaitsimError, match="nested too deeply"):
            toml.parse(hidden, "")
