"""The site: its navigation, links, equations, pictures and generated pages."""

import importlib.util
import re
import sys
from pathlib import Path
from types import ModuleType

import pytest
from typer.main import get_command
from typer.testing import CliRunner

import gaitsim as gs
from gaitsim.registry import PLUGINS, entries, load_class, options

ROOT = Path(__file__).parents[2]
BUILD = ROOT / "docs_build"
RUNNER = CliRunner(env={"COLUMNS": "200", "NO_COLOR": "1", "TERM": "dumb"})


def module(name: str, monkeypatch: pytest.MonkeyPatch) -> ModuleType:
    """Import a script of docs_build, which is not a package."""
    monkeypatch.syspath_prepend(BUILD)
    spec = importlib.util.spec_from_file_location(name, BUILD / f"{name}.py")
    assert spec is not None
    assert spec.loader is not None
    made = importlib.util.module_from_spec(spec)
    monkeypatch.setitem(sys.modules, name, made)
    spec.loader.exec_module(made)
    return made


@pytest.mark.packages
def test_every_page_is_in_the_navigation(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    build = module("build", monkeypatch)
    monkeypatch.setattr(build, "STAGE", tmp_path / "docs")
    build.collect_pages()
    listed = re.findall(r": ([\w-]+\.md)$", (ROOT / "mkdocs.yml").read_text(), re.MULTILINE)
    assert sorted(listed) == sorted(page.name for page in (tmp_path / "docs").glob("*.md"))


@pytest.mark.packages
def test_links_to_files_outside_docs_lead_to_pages(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    build = module("build", monkeypatch)
    monkeypatch.setattr(build, "STAGE", tmp_path / "docs")
    build.collect_pages()
    for page in (tmp_path / "docs").glob("*.md"):
        assert "](../" not in page.read_text(), page.name
    text = "[a](docs/tui.md#keys) [b](https://x.org) [c](#d) [e](data/make_gaits.py)"
    assert build.with_site_links(text, ROOT) == "[a](tui.md#keys) [b](https://x.org) [c](#d) e"


def test_every_character_of_an_equation_is_in_the_font(monkeypatch: pytest.MonkeyPatch) -> None:
    font = module("font", monkeypatch)
    assert font.FONT.stat().st_size < 150_000
    assert "SIL OPEN FONT LICENSE" in font.FONT.with_suffix(".LICENSE").read_text()
    assert (
        font.missing_characters("<math><mi>h</mi><mi>θ</mi><mo>&#x0003C;</mo><mi>sin</mi></math>")
        == ""
    )
    assert font.missing_characters("<mi>x</mi><mtext>步 態</mtext>") == "態步"
    pytest.importorskip("latex2mathml")  # in the extra `docs`; otherwise only the build checks
    mathml = module("mathml", monkeypatch)
    for page in (*ROOT.glob("docs/*.md"), *ROOT.glob("plugins/*/docs/*.md")):
        for source in re.findall(r"^```math\n(.*?)^```$", page.read_text(), re.DOTALL | re.M):
            assert "<math" in mathml.block(source, "math", "", {}, None)
    with pytest.raises(Exception, match="步"):
        mathml.block(r"\text{步} + 1", "math", "", {}, None)


def test_every_command_is_in_the_reference(monkeypatch: pytest.MonkeyPatch) -> None:
    commands = module("commands", monkeypatch)
    page = commands.page()
    from gaitsim.cli.app import app

    names = [name for name, _ in commands.commands(get_command(app), "gaitsim")]
    assert {"gaitsim run", "gaitsim tui", "gaitsim plugins list"} <= set(names)
    parts = dict(zip(names, re.split(r"^## .*$", page, flags=re.MULTILINE)[1:], strict=True))
    for name, part in parts.items():
        shown = RUNNER.invoke(app, [*name.split()[1:], "--help"]).output
        flags = set(re.findall(r"(?<![\w-])--[a-z][\w-]*", shown)) - {"--help"}
        assert flags <= set(re.findall(r"--[a-z][\w-]*", part)), name
    assert "gaitsim run spider --from spider@120\n" in parts["gaitsim run"]
    row = "| <code>--kind</code> KIND | Kind of plot:<br>of a front or an archive: archive, "
    assert row in parts["gaitsim plot"]
    assert "| <code>fitness</code> |" in parts["gaitsim plot"]
    assert "[bold]" not in page


def test_every_option_of_every_plugin_is_in_the_reference(monkeypatch: pytest.MonkeyPatch) -> None:
    page = module("parts", monkeypatch).page()
    for kind in PLUGINS:
        for name in entries(kind):
            assert f"### {name}\n" in page
            for option, field in load_class(kind, name).model_fields.items():
                assert f"| `{option}` | " in page
                assert options.default(field) in page


@pytest.mark.slow
def test_everything_has_a_line_with_a_link(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.syspath_prepend(BUILD)
    build, pages = module("build", monkeypatch), module("everything", monkeypatch)
    documented = {one: name for name, (_, objects) in build.API.items() for one in objects}
    page = pages.page(documented)
    names = [f"gs.{name}" for name in gs.__all__] + ["run.export", "individual.plot"]
    names += ["individual.genome", "run.path", "search.champion"]
    names += ["gaitsim verify", "joint_angles", "forward", "altitude"]
    names += [name for kind in ("plot", "exporter", "organism") for name in entries(kind)]
    assert not [name for name in (*names, *gs.presets()) if f"[`{name}`](" not in page]
    headings = module("parts", monkeypatch).page()
    headings += module("commands", monkeypatch).page()
    titles = {re.sub(r"[^\w-]", "-", one) for one in re.findall("^#+ (.*)$", headings, re.M)}
    for target in re.findall(r"\]\(([^)]+)\)", page):
        file, _, anchor = target.partition("#")
        known = file in ("parts.md", "commands.md") and re.sub(r"_\d$", "", anchor) in titles
        pages = (ROOT / "docs" / file, *ROOT.glob(f"plugins/*/docs/{file}")) if file else ()
        assert known or anchor in documented or any(one.exists() for one in pages), target


@pytest.mark.packages
def test_all_pictures_are_used_and_small() -> None:
    pages = [ROOT / "README.md", *ROOT.glob("docs/*.md"), *ROOT.glob("plugins/*/docs/*.md")]
    shown = {
        (page.parent / target).resolve()
        for page in pages
        for target in re.findall(r"!\[[^\]]*\]\(([^)]+)\)", page.read_text())
    }
    kept = {path for path in (ROOT / "docs" / "pictures").iterdir() if path.name != "icon.svg"}
    assert shown == kept
    assert sum(path.stat().st_size for path in kept) < 3_000_000


def test_pictures_load_nothing_from_the_network() -> None:
    for picture in (ROOT / "docs" / "pictures").glob("*.svg"):
        found = set(re.findall(r"https?://[^\s\"')<]+", picture.read_text()))
        assert found <= {"http://www.w3.org/2000/svg", "https://www.textualize.io"}, picture
