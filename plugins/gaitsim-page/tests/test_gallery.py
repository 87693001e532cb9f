"""Galleries: a card and a page for each run, reasons for missing runs, and safe files."""

import json
import re
import shutil
from html.parser import HTMLParser
from pathlib import Path

import pytest

import gaitsim as gs
from gaitsim.errors import GaitsimError
from gaitsim.storage.manage import write_note, write_tags
from gaitsim_page import gallery
from gaitsim_page.gallery import write_gallery

PICTURE = "data:image/webp;base64,UklGRg=="
HOSTILE = "<img src=x onerror=alert(1)>"


@pytest.fixture
def runs(tmp_path, puppets, puppet, monkeypatch):
    """Two runs with different scores, one with a hostile name and note; pages are stubs."""
    monkeypatch.setattr(gallery, "_picture", lambda skeleton, theme: PICTURE)
    monkeypatch.setattr(
        gallery, "write_page", lambda ones, path, run: path.write_text(ones[0].name) and ""
    )
    folder = tmp_path / "runs"
    for name, generations in ((HOSTILE, 1), ("b", 3)):
        search = gs.evolve(puppet(), generations=generations, out=folder / name)
        list(search)
        search.close()
    write_note(folder / HOSTILE, "<script>alert(1)</script>\nsecond line")
    write_tags(folder / HOSTILE, ["<b>good", "straight"])
    return folder


class Reader(HTMLParser):
    """Collect the elements of a page, their attributes, and the texts."""

    def __init__(self, page: bytes) -> None:
        super().__init__()
        self.tags: list[str] = []
        self.attributes: list[tuple[str, str | None]] = []
        self.texts: list[str] = []
        self.feed(page.decode())

    def handle_starttag(self, tag, attrs):
        self.tags.append(tag)
        self.attributes += attrs

    def handle_data(self, data):
        self.texts.append(data)


def test_runs_have_cards_and_pages_in_order_of_score(runs, tmp_path):
    out = tmp_path / "site"
    made = write_gallery(runs, out)
    assert (made.shown, made.problems) == (2, ())
    page = Reader(made.index.read_bytes())
    links = [value for name, value in page.attributes if name == "href"]
    assert all((out / str(link)).is_file() for link in links)
    record = json.loads((out / "gallery.json").read_text())
    scores = [one["score"] for one in record["runs"]]
    assert scores == sorted(scores, reverse=True)
    for one in record["runs"]:
        assert gs.verify(one["code"]).identical
        assert one["code"] in page.texts
    first, second = (page.texts.index(one["run"]) for one in record["runs"])
    assert first < second


def test_names_and_notes_are_escaped_and_scripts_are_forbidden(runs, tmp_path):
    made = write_gallery(runs, tmp_path / "site")
    page = Reader(made.index.read_bytes())
    assert "script" not in page.tags
    assert not [name for name, _ in page.attributes if name.startswith("on")]
    assert HOSTILE in page.texts
    assert "<script>alert(1)</script>\nsecond line" in page.texts
    assert "tags: <b>good, straight" in page.texts
    policy = dict(page.attributes)["content"] and next(
        value for name, value in page.attributes if name == "content" and "default-src" in value
    )
    assert "default-src 'none'" in policy
    assert "script-src" not in policy
    for name, value in page.attributes:
        if name in ("src", "srcset"):
            assert value.startswith("data:image/webp;base64,")
    names = [path.name for path in (tmp_path / "site").rglob("*")]
    assert all(re.fullmatch(r"[A-Za-z0-9._-]+", name) for name in names)


def test_runs_that_cannot_be_shown_are_listed_with_reasons(runs, tmp_path):
    for name in ("gone", "damaged", "cut"):
        shutil.copytree(runs / "b", runs / name)
    path = runs / "gone/experiment.toml"
    path.write_text(path.read_text().replace('"puppet-reach"', '"leap"'))
    (runs / "cut/population.pickle").write_bytes(b"")
    (runs / "cut/population.previous.pickle").unlink()
    (runs / "damaged/bests.bin").write_bytes(b"x")
    made = write_gallery(runs, tmp_path / "site")
    reasons = dict(made.problems)
    assert made.shown == 2
    assert sorted(reasons) == ["cut", "damaged", "gone"]
    assert "leap" in reasons["gone"]
    text = "".join(Reader(made.index.read_bytes()).texts)
    assert all(name in text for name in reasons)
    assert str(tmp_path) not in made.index.read_text()


def test_a_run_without_a_skeleton_has_a_card_without_picture(runs, tmp_path, puppets, monkeypatch):
    monkeypatch.setattr(puppets.Puppet, "skeleton", lambda *_: None)
    made = write_gallery(runs, tmp_path / "site")
    assert made.shown == 2
    assert len(made.problems) == 2
    page = Reader(made.index.read_bytes())
    assert "img" not in page.tags
    assert "no picture" in page.texts
    assert not [*(tmp_path / "site/pages").iterdir()]


def test_only_a_gallery_is_replaced_and_its_old_pages_are_deleted(runs, tmp_path):
    out = tmp_path / "site"
    write_gallery(runs, out)
    (out / "pages/mine.html").write_text("mine")
    shutil.rmtree(runs / "b")
    write_gallery(runs, out)
    left = sorted(path.name for path in (out / "pages").iterdir())
    assert left == ["mine.html", "run-img-src-x-onerror-alert-1.html"]
    with pytest.raises(GaitsimError, match="is not a gallery"):
        write_gallery(runs, runs)
    hostile = json.loads((out / "gallery.json").read_text())
    hostile["files"] = ["pages/../../keep.txt", "../keep.txt", "/etc/passwd", "gallery.json"]
    (out / "gallery.json").write_text(json.dumps(hostile))
    (tmp_path / "keep.txt").write_text("kept")
    write_gallery(runs, out)
    assert (tmp_path / "keep.txt").read_text() == "kept"
    for text in ("", "[]", "{}", "[" * 100_000, '{"kind": "other"}'):
        (out / "gallery.json").write_text(text)
        with pytest.raises(GaitsimError, match="is not a gallery"):
            write_gallery(runs, out)


def test_ctrl_c_leaves_a_gallery_of_the_processed_runs(runs, tmp_path, gaitsim, monkeypatch):
    calls = []

    def interrupted(ones, path: Path, run):
        calls.append(path)
        if len(calls) == 2:
            raise KeyboardInterrupt
        path.write_text("page")

    monkeypatch.setattr(gallery, "write_page", interrupted)
    shown = gaitsim("gallery", runs, "--out", "site", code=130)
    assert "Stopped" in shown.stderr
    text = "".join(Reader((tmp_path / "site/index.html").read_bytes()).texts)
    assert "1 run" in text
    assert "interrupted before this run" in text
    record = json.loads((tmp_path / "site/gallery.json").read_text())
    assert len(record["files"]) == len(record["runs"]) == 1
    monkeypatch.setattr(gallery, "write_page", lambda ones, path, run: path.write_text("page"))
    assert "2 runs" in gaitsim("gallery", runs, "--out", "site").stdout


def test_symbolic_links_in_a_gallery_are_not_followed(runs, tmp_path):
    out = tmp_path / "site"
    write_gallery(runs, out)
    elsewhere = tmp_path / "elsewhere"
    elsewhere.mkdir()
    (elsewhere / "run-b.html").write_text("kept")
    (elsewhere / "index.html").write_text("kept")
    for name, target in (("index.html", elsewhere / "index.html"), ("pages", elsewhere)):
        before = out / name
        before.rename(tmp_path / "aside")
        before.symlink_to(target)
        with pytest.raises(GaitsimError, match="symbolic link"):
            write_gallery(runs, out)
        before.unlink()
        (tmp_path / "aside").rename(before)
    assert {path.read_text() for path in elsewhere.iterdir()} == {"kept"}


def test_invalid_folders_are_reported(gaitsim, runs):
    assert "folder not found" in gaitsim("gallery", "nowhere", code=2).stderr
    assert "is a run" in gaitsim("gallery", runs / "b", code=2).stderr


def test_file_names_are_safe_and_distinct():
    names = ["a b", "a-b", "A-B", "日本", "…", "con", "x" * 300, ".."]
    found = gallery._file_names([Path(name) for name in names])
    assert len({name.casefold() for name in found}) == len(names)
    assert all(re.fullmatch(r"run[A-Za-z0-9_-]{0,90}", name) for name in found)
